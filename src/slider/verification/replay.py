"""Check 5: the gait as a table over time, replayed in MuJoCo with foot placement."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

from slider.config.gait import ReplayConfig
from slider.config.robot import RobotConfig
from slider.robot import names
from slider.robot.kinematics import about_z
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.transmission import Transmission, by_motor
from slider.verification.plant import Plant, PlantState
from slider.verification.regulator import Measurement, Reference, Regulator, tilt_of, touchdown
from slider.verification.stored import StoredGait

_EARLY = 0.5  # a contact of the swing foot counts as touchdown from this phase on
_ITERATIONS = 50  # of MuJoCo's solver


_ENDS = np.cumsum([0] + [names.NUM_JOINTS] * 3 + [3, 3, 3, 3, 2])
_PARTS = [slice(start, end) for start, end in pairwise(_ENDS)]


@dataclass(frozen=True)
class StepReference:
    """N points of a step on the prismatic robot, relative to the stance foot, world axes.

    Attributes:
        side: the stance foot's.
        duration: [s].
        table: (N, 12 + 12 + 12 + 3 + 3 + 3 + 3 + 2) joints, velocities, efforts, centre of mass
            [m] and its velocity [m/s], sole of the swing foot [m], direction of its line, sines
            of the base's roll and pitch.
    """

    side: str
    duration: float
    table: np.ndarray

    def at(self, time: float) -> "Reference":
        """Linear interpolation; before the start and after the end the outermost points hold."""
        place = min(max(time / self.duration, 0.0), 1.0) * (len(self.table) - 1)
        k = min(int(place), len(self.table) - 2)
        row = self.table[k] + (place - k) * (self.table[k + 1] - self.table[k])
        return Reference(*(row[part] for part in _PARTS))


def tabulate(gait: StoredGait, plant: Plant, points: int) -> tuple[StepReference, StepReference]:
    """Both steps of a gait after eq. 1 (exact), with the plant's own efforts.

    The ground wrench is the one that balances the base, but for a moment about the foot line,
    which the line cannot carry; of a gait with the prismatic leg's dynamics it is the gait's.
    """
    steps = []
    for motion in gait.steps:
        times = np.linspace(0.0, motion.duration, points)
        rows = [_row(plant, plant.moving(motion, time), motion.side) for time in times]
        steps.append(StepReference(motion.side, motion.duration, np.array(rows)))
    return steps[0], steps[1]


def _row(plant: Plant, state: PlantState, side: str) -> np.ndarray:
    efforts, _ = plant.balanced(state, side)
    data, model = plant.data, plant.model
    mujoco.mj_subtreeVel(model, data)
    base = model.body(names.BASE).id
    foot = data.site(names.sole(names.other_side(side)))
    direction = foot.xmat.reshape(3, 3)[:, 0]
    joints, velocities = state.qpos[7:], state.qvel[6:]
    return np.concatenate(
        [joints, velocities, efforts, data.subtree_com[base], data.subtree_linvel[base]]
        + [foot.xpos, direction, tilt_of(data.xmat[base].reshape(3, 3))]
    )


class Simulation:
    """The prismatic robot in MuJoCo, its drives following the targets of a gait.

    Attributes:
        course: yaw of the axes in which the regulator sees the robot [rad]: of a gait that turns,
            those of the present stance foot's line.
    """

    def __init__(self, robot: RobotConfig, config: ReplayConfig) -> None:
        self.robot, self.config = robot, config
        options = SimulationOptions(config.timestep, _ITERATIONS, _ITERATIONS)
        self.model = build_model(robot, options)
        self.data = mujoco.MjData(self.model)
        self.base = self.model.body(names.BASE).id
        self.course = 0.0
        self.motors = Transmission.of(robot)
        gains = by_motor(robot, robot.gains) * len(names.SIDES)
        self.kp, self.kd = (
            np.array([getattr(gain, name) for gain in gains]) for name in ("kp", "kd")
        )

    def start(self, gait: StoredGait, desired: Reference) -> None:
        """Put the robot where a walk starts, just after touchdown."""
        mujoco.mj_resetData(self.model, self.data)
        self.course = 0.0
        self.data.qpos[:] = np.concatenate([gait.base[0, :7], desired.joints])
        self.data.qvel[:] = np.concatenate([gait.base[0, 7:], desired.velocities])
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_subtreeVel(self.model, self.data)

    def drive(self, targets: np.ndarray, desired: Reference) -> None:
        """One control step: PD about the targets (12,), the gait's velocities and efforts."""
        motors = self.motors
        torques = self.kd * motors.angles(desired.velocities) + motors.torques(desired.efforts)
        self.data.ctrl[:] = motors.angles(targets) + torques / self.kp
        mujoco.mj_step(self.model, self.data, self.config.substeps)

    def measure(self, side: str) -> Measurement:
        """State in stance ``side``, along the course."""
        data, axes = self.data, about_z(np.array([self.course]))[0]
        mujoco.mj_subtreeVel(self.model, data)
        return Measurement(
            (data.xpos[self.base] @ axes, axes.T @ data.xmat[self.base].reshape(3, 3)),
            data.qpos[7:].copy(),
            data.subtree_com[self.base] @ axes,
            data.subtree_linvel[self.base] @ axes,
            data.site(names.sole(side)).xpos @ axes,
            data.site(names.sole(names.other_side(side))).xpos @ axes,
        )

    def loaded(self, side: str) -> bool:
        """Whether a foot touches the ground."""
        force = self.data.sensor(f"{side}_foot_force").data
        return bool(np.linalg.norm(force) > self.config.contact)

    def fallen(self) -> bool:
        """Whether the base is too low, tilted too far or not finite."""
        height, upright = self.data.xpos[self.base, 2], self.data.xmat[self.base, 8]
        falls = height < self.config.height or upright < np.cos(self.config.tilt)
        return bool(falls or not np.isfinite(self.data.qpos).all())


def regulated(gait: StoredGait, simulation: Simulation, plant: Plant) -> dict[str, float]:
    """Completed steps of the replay; without any there is no error of the mean velocity [m/s]."""
    config, speed = simulation.config, float(gait.velocities[0])
    references = tabulate(gait, plant, config.points)
    regulator = Regulator(simulation.robot.geometry, config.regulator, speed)
    simulation.start(gait, references[0].at(0.0))
    steps, time, courses = 0, 0.0, [0.0]
    places = [simulation.data.qpos[:2].copy()]
    while steps < config.steps and regulated_step(simulation, references[steps % 2], regulator):
        simulation.course += float(gait.turns[steps % 2])
        steps += 1
        time = float(simulation.data.time)
        places.append(simulation.data.qpos[:2].copy())
        courses.append(simulation.course)
    if not steps:
        return {"regulated_steps": 0.0}
    mean = _distance(np.array(places), np.array(courses)) / time
    return {"regulated_steps": float(steps), "regulated_speed": abs(mean - speed)}


def _distance(places: np.ndarray, courses: np.ndarray) -> float:
    """Distance forward [m] through places (S, 2), each part of it along its course (S,) [rad]."""
    if not courses.any():
        return float(places[-1, 0] - places[0, 0])
    parts, along = np.diff(places, axis=0), courses[:-1]
    return float(np.sum(np.cos(along) * parts[:, 0] + np.sin(along) * parts[:, 1]))


def regulated_step(simulation: Simulation, step: StepReference, regulator: Regulator) -> bool:
    """One step from touchdown to touchdown; false where the robot falls."""
    config = simulation.config
    start = float(simulation.data.time)
    past = touchdown(simulation.measure(step.side), step.at(0.0))
    swing = names.other_side(step.side)
    time = 0.0
    while time < config.patience * step.duration:
        desired = step.at(time)
        late = max(0.0, time - step.duration)
        desired.swing[2] -= regulator.config.descent * late
        measured = simulation.measure(step.side)
        phase, left = time / step.duration, step.duration - time
        targets = regulator.targets(measured, desired, past, step.side, phase, left)
        simulation.drive(targets, desired)
        time = float(simulation.data.time) - start
        if simulation.fallen():
            return False
        if time > _EARLY * step.duration and simulation.loaded(swing):
            return True
    return False
