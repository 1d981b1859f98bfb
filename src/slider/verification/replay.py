"""Check 6: the gait replayed in MuJoCo with foot placement."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np

from slider.config.robot import RobotConfig
from slider.config.verification import ReplayConfig
from slider.robot import names
from slider.robot.kinematics import about_z
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.transmission import Transmission, by_motor
from slider.verification.plant import Plant
from slider.verification.reference import Reference, StepReference, tabulate
from slider.verification.regulator import Measurement, Regulator, Touchdown, touchdown
from slider.verification.stored import StoredGait

_EARLY = 0.5  # a contact of the swing foot counts as touchdown from this phase on
_ITERATIONS = 50  # of MuJoCo's solver


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
        gains = by_motor(robot.gains) * len(names.SIDES)
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
        """The state as the regulator wants it, in stance ``side``, along the course."""
        data, axes = self.data, about_z(np.array([self.course]))[0]
        mujoco.mj_subtreeVel(self.model, data)
        other = names.SIDES[1 - names.SIDES.index(side)]
        return Measurement(
            (data.xpos[self.base] @ axes, axes.T @ data.xmat[self.base].reshape(3, 3)),
            data.qpos[7:].copy(),
            data.subtree_com[self.base] @ axes,
            data.subtree_linvel[self.base] @ axes,
            data.site(names.sole(side)).xpos @ axes,
            data.site(names.sole(other)).xpos @ axes,
        )

    def loaded(self, side: str) -> bool:
        """Whether a foot touches the ground."""
        force = self.data.sensor(f"{side}_foot_force").data
        return bool(np.linalg.norm(force) > self.config.contact)

    def fallen(self) -> bool:
        """Base too low, tilted too far, or numbers gone wild."""
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
    past: Touchdown = touchdown(simulation.measure(step.side), step.at(0.0))
    other = names.SIDES[1 - names.SIDES.index(step.side)]
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
        if time > _EARLY * step.duration and simulation.loaded(other):
            return True
    return False
