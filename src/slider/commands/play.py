"""``slider play``: watch a policy, the baseline, a gait, or an agent that knows nothing."""

import argparse
import os
from pathlib import Path

from slider.artefacts.store import ARTEFACTS

BASELINES = ("mpc_wbc_literal", "mpc_wbc_tuned", "mpc_wbc_observer")
AGENTS = ("policy", *BASELINES, "zero", "random")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("agent", nargs="?", choices=AGENTS, default="policy", help="who walks")
    parser.add_argument("--policy", type=Path, help="policy file (default: of the current plan)")
    parser.add_argument(
        "--gait",
        type=float,
        nargs=2,
        metavar=("VX", "VY"),
        help="replay the nearest gait of the library, without physics [m/s]",
    )
    parser.add_argument("--library", type=Path, help="gait library (default: of the current plan)")
    parser.add_argument(
        "--command", type=float, nargs=3, default=(0.4, 0.0, 0.0), metavar=("VX", "VY", "YAW_RATE")
    )
    parser.add_argument("--web", action="store_true", help="show it in a browser")
    parser.add_argument("--port", type=int, default=0, help="of --web (default: from 8080 on)")
    parser.add_argument("--headless", action="store_true", help="show nothing, say how it went")
    parser.add_argument("--film", type=Path, help="write an animated picture (.webp) instead")
    parser.add_argument("--seconds", type=float, help="stop after this time [s]")
    parser.add_argument("--seed", type=int, default=0, help="of the start and of the random agent")
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        metavar="KEY=VALUE",
        help="overrides of the configuration, such as evaluation=robust; a policy walks on its "
        "own robot and environment, unless they change these",
    )
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Watch it; with ``--headless`` status 1 if the robot fell."""
    if arguments.film is not None:
        os.environ.setdefault("MUJOCO_GL", "egl")  # MuJoCo reads it when it is imported
    from slider.play import scenes
    from slider.play.control import Control

    scene = scenes.build(arguments)
    control = Control(arguments.command)
    if arguments.headless:
        from slider.play import headless

        return headless.run(scene, control, arguments.seconds)
    if arguments.film is not None:
        from slider.play import animation

        animation.run(scene, control, arguments.seconds, arguments.film)
        return 0
    if arguments.web:
        from slider.play import web

        web.run(scene, control, arguments.seconds, arguments.port)
        return 0
    from slider.play import window

    window.run(scene, control, arguments.seconds)
    return 0
