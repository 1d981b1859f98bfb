"""``slider benchmark-control``: µs per robot and tick of a controller, and of its physics."""

import argparse
import os
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from slider.artefacts.current import add_store_argument
from slider.bench import timed
from slider.config.control import HzdControlConfig
from slider.config.hzd import enforced_section
from slider.config.schema import Config
from slider.control.footsteps import FootstepPlanner
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.model_based import build_controller, build_plant
from slider.control.whole_body.model import NominalModel
from slider.control.whole_body.problem import WholeBody
from slider.core.errors import UserError, require
from slider.env.rollout import roll_out
from slider.env.starts import at_rest
from slider.library.choose import current_gaits

_PARTS = ("whole", "model", "assembly", "solution", "footsteps", "physics")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("overrides", nargs="*", help="such as control.mpc_wbc_tuned.step.time=0.4")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument("--controllers", nargs="+", default=["mpc_wbc_tuned", "mpc_wbc_literal"])
    parser.add_argument("--vx", type=float, nargs="+", default=[0.6], help="[m/s] (default: 0.6)")
    parser.add_argument("--robots", type=int, default=1000, help="default: 1000")
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated (default: 2)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print a row per controller and forward speed."""
    from slider.artefacts.runner import keep_freed_memory, limit_threads
    from slider.config.compose import compose
    from slider.core.machine import machine
    from slider.env.terms import checked

    if arguments.robots < 1 or not arguments.seconds > 0:
        given = f"{arguments.robots} for {arguments.seconds:g} s"
        raise UserError(f"--robots, --seconds: expected robots and a time, found {given}")
    config = checked(compose(arguments.overrides, arguments.conf))
    for name in arguments.controllers:
        expected = f"some of {', '.join(config.control)}"
        require(name in config.control, "--controllers", expected, name)
    limit_threads(1)  # as a job of the pipeline has
    keep_freed_memory()
    print(f"{machine()}; 1 thread, load {os.getloadavg()[0]:.1f} before the start")
    print("µs per robot and tick\n" + f"{'controller':<16}{'vx [m/s]':>10}", end="")
    print("".join(f"{part:>11}" for part in _PARTS), flush=True)
    for name in arguments.controllers:
        gaits = None
        if isinstance(config.control[name], HzdControlConfig):
            loaded = current_gaits(arguments.artefacts)
            gaits = EnforcedGaits.load(*loaded, enforced_section(config.hzd))
        for speed in arguments.vx:
            cost = measure(config, name, gaits, arguments.robots, speed, arguments.seconds)
            columns = "".join(f"{cost.get(part, 0.0):11.1f}" for part in _PARTS)
            print(f"{name:<16}{speed:>10.1f}{columns}", flush=True)


def measure(
    config: Config,
    name: str,
    gaits: EnforcedGaits | None,
    robots: int,
    speed: float,
    seconds: float,
) -> dict[str, float]:
    """Roll a controller out at a forward speed [m/s] from the protocol's starts.

    Returns:
        Processor time per robot and tick [µs] by part; ``whole`` is the rollout with its records.
    """
    env, control = config.env, config.control[name]
    plant = env.plant
    physics = build_plant(config.robot, plant, control, robots)
    controller = build_controller(config.robot, control, env.physics, robots, gaits)
    start = at_rest(config.robot, config.evaluation.start, np.random.default_rng(0), robots)
    velocities = np.tile([speed, 0.0, 0.0], (robots, 1))
    methods = {
        "model": (NominalModel, "evaluate"),
        "assembly": (WholeBody, "build"),
        "solution": (WholeBody, "solve"),
        "footsteps": (FootstepPlanner, "plan"),
        "physics": (physics, "step"),
    }
    spent: dict[str, float] = defaultdict(float)
    start_time = time.process_time()
    with timed(methods, spent):
        roll_out(controller, physics, plant, start, velocities, seconds)
    spent["whole"] = time.process_time() - start_time
    ticks = robots * round(seconds / physics.period)
    return {name: 1e6 * part / ticks for name, part in spent.items()}
