"""``slider config``: print the resolved configuration."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as gait.cost=torque experiment=paper")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")


def run(arguments: argparse.Namespace) -> None:
    """Print YAML that shows every value."""
    from omegaconf import OmegaConf

    from slider.config.compose import compose
    from slider.config.convert import to_dict
    from slider.env.terms import checked

    values = to_dict(checked(compose(arguments.overrides, arguments.conf)))
    print(OmegaConf.to_yaml(OmegaConf.create(values)), end="")
