"""``slider config``: print the resolved configuration, a reference of its keys, or its schema."""

import argparse
import json
from pathlib import Path

_WIDEST = 44  # maximum column width; longer cells shift the rest of their row


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as gait.cost=transport experiment=paper")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument(
        "--keys",
        nargs="?",
        const="",
        metavar="KEY",
        help="print type, unit, bound, default and meaning of all keys, of those at or below KEY, "
        "or of those that match it, such as '*.ppo.*'",
    )
    parser.add_argument(
        "--schema",
        nargs="?",
        const="",
        metavar="GROUP",
        help="print the JSON schema for editors of the files of conf/GROUP, or of conf/experiment",
    )


def run(arguments: argparse.Namespace) -> None:
    """Print YAML that shows every value, a table of keys or a schema."""
    from omegaconf import OmegaConf

    from slider.composition.compose import compose
    from slider.config.convert import to_dict
    from slider.config.reference import Entry, editor_schema, entries, matching
    from slider.env.terms import checked, parameter_types
    from slider.reports.sections import check_sections

    if arguments.schema is not None:
        print(json.dumps(editor_schema(arguments.schema), indent=1, ensure_ascii=False))
        return
    config = checked(compose(arguments.overrides, arguments.conf))
    check_sections(config)
    if arguments.keys is None:
        print(OmegaConf.to_yaml(OmegaConf.create(to_dict(config))), end="")
        return
    rows = [Entry._fields, *matching(entries(config, parameter_types(config)), arguments.keys)]
    widths = [min(max(map(len, column)), _WIDEST) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(map(str.ljust, row, widths)).rstrip())
