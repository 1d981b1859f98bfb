"""``slider benchmark-control``: µs per robot and tick of a controller, physics and QPs alone.

Physics and QPs that are timed alone are those of the same rollout, every ``_EVERY``-th.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import argparse
import os
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from slider.artefacts.current import add_store_argument
from slider.bench.stopwatch import replaced
from slider.config.control import HzdControlConfig
from slider.config.env import PlantConfig
from slider.config.hzd import enforced_section
from slider.config.schema import Config
from slider.control import qp
from slider.control.hzd.controller import EnforcedGaits
from slider.control.model_based import build_controller
from slider.core.errors import UserError
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import at_rest
from slider.evaluation.baseline import build_plant
from slider.library.choose import current_gaits
from slider.robot.transmission import Transmission

_EVERY = 20
_PARTS = ("model", "assembly", "solution", "footsteps")
_HEADER = (
    "                                       µs per robot and tick          alone\n"
    "controller        vx [m/s]   whole   model  assembly  solution  footsteps   physics   QPs"
)


@dataclass(frozen=True)
class Cost:
    """Processor time per robot and tick [µs].

    Attributes:
        whole: of a rollout: controller, physics, records.
        parts: of the controller.
        physics: of ``mujoco.rollout`` alone.
        qps: of the solver alone.
    """

    whole: float
    parts: dict[str, float]
    physics: float
    qps: float

    def line(self, name: str, speed: float) -> str:
        """One row of the table."""
        parts = (self.parts.get(part, 0.0) for part in _PARTS)
        model, assembly, solution, footsteps = parts
        return (
            f"{name:<16}  {speed:8.1f}  {self.whole:6.1f}  {model:6.1f}  {assembly:8.1f}  "
            f"{solution:8.1f}  {footsteps:9.1f}  {self.physics:8.1f}  {self.qps:4.1f}"
        )


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
    """Print a row per controller and forward command."""
    from slider.artefacts.runner import keep_freed_memory, limit_threads
    from slider.config.compose import compose
    from slider.core.machine import machine
    from slider.env.terms import checked

    if arguments.robots < 1 or not arguments.seconds > 0:
        found = f"{arguments.robots} for {arguments.seconds:g} s"
        raise UserError(f"--robots, --seconds: expected robots and a time, found {found}")
    config = checked(compose(arguments.overrides, arguments.conf))
    for name in arguments.controllers:
        if name not in config.control:
            known = ", ".join(config.control)
            raise UserError(f"--controllers: expected some of {known}, found {name}")
    limit_threads(1)  # as a job of the pipeline has
    keep_freed_memory()
    print(f"{machine()}; 1 thread, load {os.getloadavg()[0]:.1f} before the start")
    print(_HEADER, flush=True)
    for name in arguments.controllers:
        gaits = _gaits(config, name, arguments.artefacts)
        for vx in arguments.vx:
            cost = measure(config, name, gaits, arguments.robots, vx, arguments.seconds)
            print(cost.line(name, vx), flush=True)


def _gaits(config: Config, name: str, artefacts: Path) -> EnforcedGaits | None:
    """What ``hzd`` walks by, of the current plan."""
    if not isinstance(config.control[name], HzdControlConfig):
        return None
    return EnforcedGaits.load(*current_gaits(artefacts), enforced_section(config.hzd))


def measure(
    config: Config, name: str, gaits: EnforcedGaits | None, robots: int, vx: float, seconds: float
) -> Cost:
    """Roll a controller out at a forward command [m/s] from the protocol's starts."""
    env, control = config.env, config.control[name]
    plant = PlantConfig(env.control_period, env.physics, env.termination)
    physics = build_plant(config.robot, env.physics, control, robots)
    controller = build_controller(config.robot, control, env.physics, robots, gaits)
    start = at_rest(config.robot, config.evaluation.start, np.random.default_rng(0), robots)
    command = np.tile([vx, 0.0, 0.0], (robots, 1))
    steps, programmes = [], []
    motors = Transmission.of(config.robot)

    def note_step(efforts: np.ndarray) -> None:
        steps.append((physics.state.copy(), motors.torques(efforts)))

    with _noted(physics, "step", note_step), _noted(qp, "solve", lambda *p: programmes.append(p)):
        used = _seconds(lambda: roll_out(controller, physics, plant, start, command, seconds))
    return Cost(
        1e6 * used / max(controller.clock.ticks, 1),
        controller.clock.microseconds(),
        1e6 * _seconds(lambda: _step(physics, steps)) / (len(steps) * robots),
        1e6
        * _seconds(lambda: [qp.solve(*programme) for programme in programmes])
        / max(sum(len(programme[1]) for programme in programmes), 1),
    )


def _step(physics: BatchedPhysics, steps: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """One tick from each of the states (N, 38), with its torques of the motors (N, 10)."""
    pool, data = rollout.Rollout(nthread=1), [mujoco.MjData(physics.model)]
    substeps = round(physics.period / physics.model.opt.timestep)
    for state, torques in steps:
        pool.rollout(physics.model, data, state, np.repeat(torques[:, None], substeps, axis=1))


def _noted(owner: Any, name: str, note: Callable[..., None]) -> AbstractContextManager[None]:
    """Let ``note`` have the arguments of every ``_EVERY``-th call of a function."""
    original, calls = getattr(owner, name), count()

    def noted(*arguments: Any) -> Any:
        if next(calls) % _EVERY == 0:
            note(*arguments)
        return original(*arguments)

    return replaced(owner, name, noted)


def _seconds(work: Callable[[], object]) -> float:
    """Processor time of all threads [s]."""
    start = time.process_time()
    work()
    return time.process_time() - start
