"""The stage ``gait_start``, and a comparison of stored gaits that may be on different meshes."""

from dataclasses import dataclass
from math import gcd
from pathlib import Path

import numpy as np
from scipy.integrate import simpson

from slider.config.convert import from_dict
from slider.config.gait import StartSpread
from slider.core.job import Inputs, Job, Section, Summary
from slider.gait.guess import random_start
from slider.gait.stage import prepare, write_report


@dataclass(frozen=True)
class MeshGait:
    """A stored gait on its mesh of n nodes per step.

    Attributes:
        joints, torques: (2, n, 10) of both steps, virtual knee [rad], [N m].
        roll: (2, n) of the stance foot [rad].
        step_time: of the first step [s].
    """

    joints: np.ndarray
    torques: np.ndarray
    roll: np.ndarray
    step_time: float

    @classmethod
    def load(cls, folder: Path) -> "MeshGait":
        """Load a result of the stage ``gait``."""
        names = ("knee_positions", "knee_torques", "roll", "step_time")
        joints, torques, roll, times = (np.load(folder / f"{name}.npy") for name in names)
        steps = (2, -1, joints.shape[-1])
        return cls(joints.reshape(steps), torques.reshape(steps), roll[..., 0], float(times[0]))

    @property
    def intervals(self) -> int:
        """Number of intervals between the nodes of a step."""
        return self.roll.shape[1] - 1

    @property
    def torque_cost(self) -> float:
        """Σ over steps of (1/T) ∫ ‖τ‖² dt by Simpson's rule [N² m²]."""
        squares = (self.torques**2).sum(axis=-1)
        return float(np.sum(simpson(squares, dx=1.0 / self.intervals, axis=-1)))

    def difference(self, other: "MeshGait") -> dict[str, float]:
        """Greatest differences [rad] of joints and roll at the phases that both meshes have.

        Over both steps; ``roll_end_difference``: at the ends of the steps only.
        """
        common = gcd(self.intervals, other.intervals)
        joints, roll = (
            np.abs(mine[:, :: self.intervals // common] - its[:, :: other.intervals // common])
            for mine, its in ((self.joints, other.joints), (self.roll, other.roll))
        )
        return {
            "joints_difference": float(joints.max()),
            "roll_difference": float(roll.max()),
            "roll_end_difference": float(roll[:, -1].max()),
        }


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Solve one gait from random start number ``index`` of a seed; write its report."""
    solver, velocity = prepare(section, job)
    start, step_time = section["start"], section["solve"]["step_time"]
    duration = step_time["lower"], step_time["upper"]
    spread = from_dict(StartSpread, start["spread"])
    generator = np.random.default_rng([start["seed"], start["index"]])
    guess = random_start(solver.problem, velocity[0], duration, spread, generator)
    solve = solver.solve(*velocity, start=guess)
    return write_report(section, solver.problem, solve, out, job)[1]
