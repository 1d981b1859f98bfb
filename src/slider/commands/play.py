"""``slider play``: watch a policy, a controller of ``conf/control``, a gait or a smoke agent."""

import argparse
import math
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from slider.artefacts.current import add_store_argument, current_folder
from slider.artefacts.run_metadata import last_robot
from slider.artefacts.store import Store
from slider.commands.runs import check_port
from slider.config.control import POLICY, SMOKE_AGENTS
from slider.core.errors import UserError, require

if TYPE_CHECKING:
    from slider.play.scenes import Scene

VELOCITY = ("VX", "VY", "YAW_RATE")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    smoke = " or ".join(SMOKE_AGENTS)
    parser.add_argument(
        "agent",
        nargs="?",
        default=POLICY,
        help=f"{POLICY} (default), a controller of conf/control, {smoke}",
    )
    parser.add_argument(
        "--policy",
        type=Path,
        help="policy.pt, or the folder of an export (default: of the current plan)",
    )
    parser.add_argument(
        "--gait",
        type=float,
        nargs="+",
        metavar=("VX", "VY"),
        help="replay the nearest gait of the library, without physics: VX VY [YAW_RATE]",
    )
    parser.add_argument("--library", type=Path, help="gait library (default: of the current plan)")
    parser.add_argument(
        "--velocity", type=float, nargs=3, default=(0.4, 0.0, 0.0), metavar=VELOCITY
    )
    parser.add_argument("--web", action="store_true", help="show it in a browser")
    parser.add_argument("--port", type=int, default=0, help="of --web (default: from 8080 on)")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address of --web (default: 127.0.0.1, this machine alone; :: is every address, and "
        "whoever reaches it can steer)",
    )
    parser.add_argument(
        "--headless", action="store_true", help="without pictures: print the outcome"
    )
    parser.add_argument(
        "--film",
        type=Path,
        help="film of a walk, or a fall, from side and front",
    )
    parser.add_argument(
        "--tiles",
        action="store_true",
        help="with --film: three speeds, a push, a slope and stairs beside each other",
    )
    parser.add_argument("--seconds", type=float, help="stop after this time [s]")
    parser.add_argument("--seed", type=int, default=0, help="of initial state and random agent")
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        metavar="KEY=VALUE",
        help="overrides, such as evaluation=robust; the robot is that of Snakemake's last run, a "
        "policy walks on its own robot and environment, unless they change these",
    )
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Show the scene; with ``--headless`` or ``--film``, status 1 if the robot fell."""
    check(arguments)
    renderer = os.environ.setdefault("MUJOCO_GL", "egl") if arguments.film else None
    try:
        import mujoco
    except (ImportError, RuntimeError, AttributeError) as error:  # it reads MUJOCO_GL then
        found = f"found {error}: MUJOCO_GL=egl may work"
        raise UserError(f"MUJOCO_GL={renderer}: expected a renderer, {found}") from None

    from slider.play import loop

    # Keep MuJoCo from writing MUJOCO_LOG.TXT into the working directory.
    mujoco.set_mju_user_warning(lambda _: None)  # pyright: ignore[reportAttributeAccessIssue]
    if arguments.tiles:
        from slider.play import animation

        def chosen(overrides: list[str]) -> "Scene":
            asked = [*arguments.set, *overrides]
            return choose(argparse.Namespace(**{**vars(arguments), "set": asked}))

        return animation.run_tiles(chosen, arguments.seconds, arguments.film)
    scene = choose(arguments)
    control = loop.Control(arguments.velocity, scene.top)
    for name, value, (low, high) in zip(VELOCITY, arguments.velocity, control.limits, strict=True):
        expected = f"{name} between {low:g} and {high:g}"
        require(low <= value <= high, "--velocity", expected, f"{value:g}")
    if arguments.headless:
        return loop.run_headless(scene, control, arguments.seconds)
    if arguments.film is not None:
        from slider.play import animation

        return animation.run(scene, control, arguments.seconds, arguments.film)
    if not arguments.web:
        from slider.play import window

        try:
            window.run(scene, control, arguments.seconds)
            return 0
        except window.NoWindow as reason:
            check_port(arguments.port, arguments.host)
            print(f"{reason}: shown in a browser")
    from slider.play import web

    web.run(scene, control, arguments.seconds, arguments.host, arguments.port)
    return 0


def check(arguments: argparse.Namespace) -> None:
    """Reject invalid arguments."""
    count, seconds = len(arguments.gait or (0, 0)), arguments.seconds
    require(count in (2, 3), "--gait", "VX VY [YAW_RATE]", f"{count} values")
    require(all(map(math.isfinite, arguments.gait or ())), "--gait", "numbers", arguments.gait)
    require(arguments.gait or not arguments.library, "--library", "--gait", "none")
    require(arguments.seed >= 0, "--seed", "no negative number", arguments.seed)
    require(seconds is None or seconds > 0, "--seconds", "a positive number", seconds)
    require(arguments.film is not None or not arguments.tiles, "--tiles", "--film", "none")
    require(not (arguments.headless and arguments.film), "--headless", "no --film", "one")
    if arguments.web:
        check_port(arguments.port, arguments.host)


def choose(arguments: argparse.Namespace) -> "Scene":
    """Build the scene that the arguments select.

    Raises:
        UserError: agent, policy or library do not exist, or are inconsistent.
    """
    from slider.commands.library import current_gaits, library_path
    from slider.composition.compose import compose
    from slider.control import POLICY_FILE
    from slider.env.terms import checked
    from slider.play import scenes

    robot = last_robot(arguments.artefacts)
    if any(text.startswith("robot=") for text in arguments.set):
        robot = []
    config = checked(compose([*robot, *arguments.set], arguments.conf))
    if arguments.gait is not None:
        velocity = [*arguments.gait, 0.0][:3]
        return scenes.gait_scene(library_path(arguments), velocity, config)
    path = arguments.policy
    if arguments.agent != POLICY:
        require(path is None, "--policy", f"the agent {POLICY}", arguments.agent)
        gaits = partial(current_gaits, arguments.artefacts)
        return scenes.agent_scene(arguments.agent, config, gaits, arguments.seed)
    if path is None:
        store = Store(arguments.artefacts)
        path = current_folder(store, "walking", "snakemake -j2 policy") / POLICY_FILE
    plain = compose(robot, arguments.conf)
    return scenes.policy_scene(path, config, plain, arguments.seed)
