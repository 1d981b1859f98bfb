"""Check 5: the gait as a table over time, replayed in MuJoCo with foot placement.

A time-indexed gait does not stay up without it. The error of the divergent component of motion,
c + ċ/ω (Takenaka et al. 2009; Englsberger et al. 2015), grows by exp(ω t) until touchdown; the
swing foot goes by a share of what it will be then. The foot lands level along its heading, and
what the last impact left of errors fades out.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from slider.config.gait import RegulatorConfig, ReplayConfig
from slider.config.robot import Geometry, RobotConfig
from slider.robot import names
from slider.robot.kinematics import about_z
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.transmission import Transmission, by_motor
from slider.verification.inverse_kinematics import level_leg
from slider.verification.plant import Plant
from slider.verification.stored import StoredGait

_EARLY = 0.5  # a contact of the swing foot counts as touchdown from this phase on
_ITERATIONS = 50  # of MuJoCo's solver
_ENDS = np.cumsum([names.NUM_JOINTS] * 3 + [3, 3, 3, 3])  # of the fields of a reference


class Reference(NamedTuple):
    """A point of a step on the prismatic robot, relative to the stance foot, world axes.

    Attributes:
        joints, velocities, efforts: (12,).
        com, com_velocity: centre of mass (3,) [m] and its velocity [m/s].
        swing, direction: sole of the swing foot (3,) [m] and direction of its line.
        tilt: sines of the base's roll and pitch (2,).
    """

    joints: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    swing: np.ndarray
    direction: np.ndarray
    tilt: np.ndarray


class Measurement(NamedTuple):
    """State that the regulator receives, world axes; in a verification it is exact.

    Attributes:
        base: position (3,) [m] and rotation to world (3, 3).
        joints: (12,) [rad, m].
        com, com_velocity: of the whole robot (3,) [m], [m/s].
        stance, swing: soles (3,) [m].
    """

    base: tuple[np.ndarray, np.ndarray]
    joints: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    stance: np.ndarray
    swing: np.ndarray


@dataclass(frozen=True)
class Regulator:
    """Joint targets of a step of a gait of forward velocity ``speed`` [m/s]."""

    geometry: Geometry
    config: RegulatorConfig
    speed: float

    def targets(
        self,
        measured: Measurement,
        desired: Reference,
        past: tuple[np.ndarray, np.ndarray],
        side: str,
        phase: float,
        left: float,
    ) -> np.ndarray:
        """Joint targets (12,) of a stance ``side`` at a phase, with ``left`` seconds to go.

        ``past`` are the errors of joints (12,) and swing foot (3,) [m] just after the touchdown.
        The stance hip holds the torso where it should be in the world, not on the leg.
        """
        fade = 1.0 - _smooth(phase / self.config.fade)
        targets = desired.joints + fade * past[0]
        leg = names.SIDES.index(side) * names.LEG_SIZE
        hips = [leg + self.geometry.leg_joints.index(name) for name in ("hip_roll", "hip_pitch")]
        targets[hips] = measured.joints[hips] + (tilt_of(measured.base[1]) - desired.tilt)
        place = measured.stance + desired.swing + fade * past[1]
        place[:2] += _smooth(phase / self.config.placement_end) * self._displacement(
            measured, desired, left
        )
        other = names.other_side(side)
        start = names.SIDES.index(other) * names.LEG_SIZE
        driven = slice(start, start + names.UPPER_FOOT)
        targets[driven] = level_leg(
            self.geometry, other, measured.base, place, desired.direction, desired.joints[driven]
        )
        return targets

    def _displacement(self, measured: Measurement, desired: Reference, left: float) -> np.ndarray:
        """By how much (2,) [m] the swing foot lands away from the gait's own place."""
        frequency = np.sqrt(names.GRAVITY / desired.com[2])
        place = measured.com - measured.stance - desired.com
        error = place + (measured.com_velocity - desired.com_velocity) / frequency
        forward = np.interp(self.speed, self.config.speeds, self.config.forward)
        share = np.array([forward, self.config.lateral])
        grown = share * error[:2] * np.exp(frequency * max(left, 0.0))
        return np.clip(grown, -self.config.reach, self.config.reach)


def _smooth(x: float) -> float:
    """From 0 to 1 with zero slope at both ends."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def tilt_of(rotation: np.ndarray) -> np.ndarray:
    """Sines of roll and pitch (2,) of a rotation (3, 3) to world."""
    return np.array([rotation[2, 1], -rotation[2, 0]])


@dataclass(frozen=True)
class StepReference:
    """N points of a step: stance side, duration [s], and their references in a table (N, 50)."""

    side: str
    duration: float
    table: np.ndarray

    def at(self, time: float) -> Reference:
        """Linear interpolation; before the start and after the end the outermost points hold."""
        place = min(max(time / self.duration, 0.0), 1.0) * (len(self.table) - 1)
        k = min(int(place), len(self.table) - 2)
        row = self.table[k] + (place - k) * (self.table[k + 1] - self.table[k])
        return Reference(*np.split(row, _ENDS))


def tabulate(gait: StoredGait, plant: Plant, points: int) -> list[StepReference]:
    """Both steps of a gait after eq. 1 (exact), with the plant's own efforts.

    The ground wrench is the one that balances the base, but for a moment about the foot line,
    which the line cannot carry; of a gait with the prismatic leg's dynamics it is the gait's.
    """
    steps, data = [], plant.data
    base = plant.model.body(names.BASE).id
    for motion in gait.steps:
        foot, rows = data.site(names.sole(names.other_side(motion.side))), []
        for time in np.linspace(0.0, motion.duration, points):
            state = plant.moving(motion, time)
            efforts, _ = plant.balanced(state, motion.side)
            mujoco.mj_subtreeVel(plant.model, data)
            parts = [state.qpos[7:], state.qvel[6:], efforts]
            parts += [data.subtree_com[base], data.subtree_linvel[base]]
            parts += [foot.xpos, foot.xmat.reshape(3, 3)[:, 0]]
            rows.append(np.concatenate([*parts, tilt_of(data.xmat[base].reshape(3, 3))]))
        steps.append(StepReference(motion.side, motion.duration, np.array(rows)))
    return steps


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


def regulated(gait: StoredGait, simulation: Simulation, plant: Plant) -> dict[str, float]:
    """Completed steps of the replay; without any there is no error of the mean velocity [m/s].

    The distance is forward, that of each step of a gait that turns along the step's course.
    """
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
    distance = float(places[-1][0] - places[0][0])
    if any(courses):
        parts, along = np.diff(places, axis=0), np.array(courses[:-1])
        distance = float(np.sum(np.cos(along) * parts[:, 0] + np.sin(along) * parts[:, 1]))
    return {"regulated_steps": float(steps), "regulated_speed": abs(distance / time - speed)}


def regulated_step(simulation: Simulation, step: StepReference, regulator: Regulator) -> bool:
    """One step from touchdown to touchdown; false where the robot falls."""
    config, data = simulation.config, simulation.data
    start, time = float(data.time), 0.0
    measured, desired = simulation.measure(step.side), step.at(0.0)
    past = (
        measured.joints - desired.joints,
        measured.swing - measured.stance - desired.swing,
    )
    while time < config.patience * step.duration:
        desired = step.at(time)
        late = max(0.0, time - step.duration)
        desired.swing[2] -= regulator.config.descent * late
        measured = simulation.measure(step.side)
        phase, left = time / step.duration, step.duration - time
        targets = regulator.targets(measured, desired, past, step.side, phase, left)
        simulation.drive(targets, desired)
        time = float(data.time) - start
        height, upright = data.xpos[simulation.base, 2], data.xmat[simulation.base, 8]
        fallen = height < config.height or upright < np.cos(config.tilt)
        if fallen or not np.isfinite(data.qpos).all():
            return False
        force = data.sensor(f"{names.other_side(step.side)}_foot_force").data
        if time > _EARLY * step.duration and np.linalg.norm(force) > config.contact:
            return True
    return False
