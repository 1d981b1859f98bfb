"""The stage ``gait_walks``: every gait walks in MuJoCo from its first sample, under feedback.

The controller is ``hzd``, integral action included, at the gait's constant velocity, without noise
and without the controller's speed limit.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from slider.config.control import HzdControlConfig
from slider.config.convert import from_dict
from slider.config.env import PlantConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.hzd.steps import hzd_controller
from slider.control.model_based import build_plant
from slider.control.whole_body.controller import WalkingController
from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.tables import Table
from slider.env import terminations
from slider.env.physics import BatchedPhysics
from slider.library.reader import STORE, GaitLibrary
from slider.robot.names import NUM_JOINTS, VELOCITY

CSV, MARKDOWN = "gait_walks.csv", "gait_walks.md"
_IN_PLACE = 1e-9  # forward [m/s]; a robot stands at zero velocity
_PATIENCE = 1.5  # time limit of a walk, as a multiple of the gaits' duration


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Walk all gaits at once; write how many steps each makes and how fast it is."""
    robot = from_dict(RobotConfig, section["robot"])
    plant = from_dict(PlantConfig, section["plant"])
    config = from_dict(HzdControlConfig, section["control"])
    library = GaitLibrary.load(inputs["library"][0] / STORE)
    config = replace(config, fastest=float(library.velocities[:, 0].max()))  # each at its own speed
    gaits = EnforcedGaits.load(inputs["library"][0], inputs["foot_placement"][0], section["hzd"])
    physics = build_plant(robot, plant, config, len(library), threads=job.threads)
    controller = hzd_controller(robot, config, gaits, physics.period)
    walks = walk(controller, physics, plant, library, section["steps"], job)
    columns = dict(zip(VELOCITY, library.velocities.T, strict=True)) | walks
    _write(pd.DataFrame(columns), section["steps"], out)
    return {"gaits": len(library), "walked": int((walks["walked"] >= section["steps"]).sum())}


def walk(
    controller: WalkingController,
    physics: BatchedPhysics,
    plant: PlantConfig,
    library: GaitLibrary,
    steps: int,
    job: Job,
) -> dict[str, np.ndarray]:
    """Completed steps (G,), and mean speed along each robot's heading up to the last [m/s] (G,)."""
    physics.reset(np.arange(len(library)), *first_samples(library))
    state = physics.read()
    velocities = library.velocities.copy()
    velocities[(velocities == 0.0).all(axis=1), 0] = _IN_PLACE
    turn = velocities[:, 2] * library.arrays["step_time"][:, 0]
    controller.start_on_gait(state, velocities, -turn / 2)
    alive, walked = np.ones(len(library), dtype=bool), np.zeros(len(library), dtype=int)
    ticks, distance = np.zeros(len(library)), np.zeros(len(library))
    longest = _PATIENCE * steps * library.arrays["step_time"].max()
    for tick in range(round(longest / physics.period)):
        physics.step(controller.control(state))
        state = physics.read()
        alive &= ~terminations.failed(state, plant.termination.terms) & ~state.diverged
        going = alive & (walked < steps)
        if not going.any():
            break
        controller.deactivate(~going)
        physics.deactivate(~going)
        walked = np.where(going, controller.memory.steps - 1, walked)
        ticks, distance = ticks + going, distance + going * state.heading_velocity[:, 0]
        if tick % 1000 == 0:
            job.progress(f"{walked.min()} to {walked.max()} of {steps} steps")
    return {"walked": walked, "speed": distance / np.maximum(ticks, 1)}


def first_samples(library: GaitLibrary) -> tuple[np.ndarray, np.ndarray]:
    """Positions (G, 19) and velocities (G, 18) at the start of each gait."""
    base, samples = library.arrays["base"][:, 0], library.arrays["samples"][:, 0]
    qpos = np.concatenate([base[:, :7], samples[:, :NUM_JOINTS]], axis=1)
    qvel = np.concatenate([base[:, 7:], samples[:, NUM_JOINTS : 2 * NUM_JOINTS]], axis=1)
    return qpos, qvel


def _write(table: pd.DataFrame, steps: int, out: Path) -> None:
    """Write a CSV of all gaits, and as Markdown how many walk at each forward speed."""
    tables.write(table, out / CSV)
    rows = []
    for vx, walked in table.groupby("vx")["walked"]:
        done = (walked >= steps).sum()
        rows.append([f"{vx:g}", f"{len(walked)}", f"{done}", f"{walked.min():g}"])
    heads = ["vx [m/s]", "gaits", f"walk {steps} steps", "fewest steps"]
    text = tables.markdown([Table(heads, rows)])
    (out / MARKDOWN).write_text(text, encoding="utf-8")
