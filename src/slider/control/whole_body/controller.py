"""Walking with a whole-body QP: entry, modes and stance are shared, the way of stepping differs.

At zero commanded velocity the robot stands on both feet. At any other it sways into the lateral
orbit and walks. Back at zero it steps until the capture point lies between the feet:
STAND → SWAY → WALK → STAND. Where a mode or a step ends is decided once per tick.

The controller receives the true state, contact flags and a nominal model of the robot, or the
estimate of an observer; ``docs/explanation/baseline.md`` compares this with the policy's input.
"""

from typing import Protocol

import numpy as np

from slider.config.control import ModelBasedConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body.memory import (
    FEET,
    LEFT,
    OFF,
    RIGHT,
    STAND,
    SWAY,
    WALK,
    Memory,
    Orbit,
)
from slider.control.whole_body.model import Dynamics, NominalModel
from slider.control.whole_body.observer import Observer
from slider.control.whole_body.references import Entry, natural_frequency
from slider.control.whole_body.tasks import BodyControl, Solved
from slider.core.arrays import scatter, take
from slider.env.instruments import CONTACT_FORCE
from slider.env.state import RobotState
from slider.robot import names

_GIVE_UP_TILT = 1.2  # [rad]; beyond it, or without a solution, the drives are switched off


class Stepping(Protocol):
    """A way of stepping, for the robots (n,) of a memory that walk."""

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""

    def set_velocity(self, memory: Memory, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from now on."""

    def orbit(self, velocity: np.ndarray, stance: np.ndarray) -> Orbit:
        """Lateral orbits of first steps, stance feet ``stance`` (n,), towards velocities (n, 3)."""
        ...

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """Begin a new step with stance feet ``stance`` (n,)."""

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,); ``contact`` (n,) is that of the swing feet."""
        ...

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques of this tick."""
        ...


class PlantModel:
    """Nominal robot, pendulum, entry and body tasks, which all ways of stepping share.

    Attributes:
        model: nominal, not the plant.
        period: of a tick [s].
        omega: natural frequency of the pendulum [rad/s].
        body: tasks of the body and their solution.
    """

    def __init__(
        self, robot: RobotConfig, config: ModelBasedConfig, search: float, period: float
    ) -> None:
        self.period = period
        self.model = NominalModel(robot)
        height = config.height * self.model.nominal_height
        self.omega = natural_frequency(height)
        self.reach = min(robot.geometry.heel, robot.geometry.toe)
        self.body = BodyControl(robot, config.whole_body, search, height)
        self.entry = Entry(config.entry, self.omega, self.reach)


class WalkingController:
    """Torques of N robots, once per tick; an ``observer`` estimates their states."""

    def __init__(
        self, plant: PlantModel, stepping: Stepping, observer: Observer | None = None
    ) -> None:
        self._plant, self._stepping, self._observer = plant, stepping, observer

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start on both feet; ``velocity`` (N, 3) is vx, vy [m/s], yaw rate [rad/s]."""
        self._begin_sway(np.arange(state.num_robots), self._start(state, velocity, state.yaw))

    def start_on_gait(self, state: RobotState, velocity: np.ndarray, heading: np.ndarray) -> None:
        """Start in the first step of a walk on the left foot, at ``velocity`` (N, 3).

        The stance foot points along x; in a turning walk the ``heading`` (N,) [rad] differs.
        """
        dynamics, count = self._start(state, velocity, heading), state.num_robots
        self.memory.mode[:] = WALK
        self.memory.previous[:] = velocity[:, :2]
        self._stepping.begin(self.memory, np.arange(count), dynamics, np.full(count, LEFT))

    def _start(self, state: RobotState, velocity: np.ndarray, heading: np.ndarray) -> Dynamics:
        if self._observer is not None:
            self._observer.reset(state)
        self.memory = Memory.on_both_feet(velocity.copy(), heading)
        self._stepping.reset(state.num_robots)
        return self._plant.model.evaluate(state.qpos, state.qvel)

    def deactivate(self, robots: np.ndarray) -> None:
        """Switch off the drives of ``robots`` (N,) and stop observing them."""
        if self._observer is not None:
            self._observer.deactivate(robots)
        self.memory.mode[robots] = OFF

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from now on."""
        self._stepping.set_velocity(self.memory, velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N]; the upper feet have no drive."""
        if self._observer is not None:
            state = self._observer.estimate(state)
        memory = self.memory
        memory.ground = state.ground
        memory.mode[-state.gravity[:, 2] < np.cos(_GIVE_UP_TILT)] = OFF
        torques = np.zeros((state.num_robots, names.NUM_JOINTS))
        active = np.flatnonzero(memory.mode != OFF)
        if len(active):
            dynamics = self._plant.model.evaluate(state.qpos[active], state.qvel[active])
            contact = state.foot_forces[active] > CONTACT_FORCE
            self._switch(active, dynamics, contact)
            torques[active] = self._drive(active, dynamics, contact)
            memory.heading[active] += memory.yaw_rate(active) * self._plant.period
        memory.tick += 1
        if self._observer is not None:
            self._observer.send(torques)
        return torques

    def _drive(self, active: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> np.ndarray:
        """Torques (n, 12) of the active robots, one mode after the other.

        While a robot walks, its stance foot is assumed to be in contact.
        """
        memory, sway = self.memory, self.memory.sway
        torques = np.zeros((len(active), names.NUM_JOINTS))
        modes = memory.mode[active]
        for mode in (STAND, SWAY, WALK):
            index = np.flatnonzero(modes == mode)
            if not len(index):
                continue
            robots, own, touching = active[index], dynamics.take(index), contact[index]
            if mode == WALK:
                result = self._stepping.torques(memory, robots, own)
            else:
                desired = np.zeros((len(robots), 2, 3))
                if mode == SWAY:
                    desired = self._plant.entry.reference(take(sway, robots))
                    sway.elapsed[robots] += self._plant.period
                result = self._plant.body.on_both_feet(memory, robots, own, touching, desired)
            torques[index], solved = result
            memory.mode[robots[~solved]] = OFF
        return torques

    def _begin_sway(self, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Begin a sway from the current state, towards the higher foot (one still in the air)."""
        places = dynamics.foot_positions[:, :, :2].swapaxes(0, 1)
        feet = np.stack([self.memory.to_heading(foot, robots) for foot in places], axis=1)
        position = self.memory.to_heading(dynamics.com[:, :2], robots)
        height = dynamics.foot_positions[:, :, 2]
        side = np.where(height[:, LEFT] >= height[:, RIGHT], 1.0, -1.0)
        velocity = self.memory.velocity[robots]
        orbit = self._stepping.orbit(velocity, _first_stance(side))
        sway = self._plant.entry.begin(feet, position, side, velocity[:, 0], orbit)
        scatter(self.memory.sway, robots, sway)

    def _switch(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> None:
        """Switch modes and steps that are due; ``contact`` (n, 2) is that of the feet."""
        memory = self.memory
        stands = memory.mode[robots] == STAND
        go = np.flatnonzero(stands & ~memory.commanded_to_stand(robots))
        if len(go):
            memory.mode[robots[go]] = SWAY
            self._begin_sway(robots[go], dynamics.take(go))
        sways = np.flatnonzero(memory.mode[robots] == SWAY)
        if len(sways):
            index = sways[self._sway_ends(robots[sways], dynamics.take(sways))]
            memory.mode[robots[index]] = WALK
            stance = _first_stance(memory.sway.side[robots[index]])
            self._stepping.begin(memory, robots[index], dynamics.take(index), stance)
        walks = np.flatnonzero(memory.mode[robots] == WALK)
        landing = contact[walks, 1 - memory.stance[robots[walks]]]
        index = walks[self._stepping.end(memory, robots[walks], landing)]
        stops = memory.commanded_to_stand(robots[index])
        if stops.any():
            standing = index[stops]
            stops[stops] = self._can_stop(robots[standing], dynamics.take(standing))
            ends, index = index[stops], index[~stops]
            if len(ends):
                memory.mode[robots[ends]] = STAND
                memory.forget_walk(robots[ends])
                self._begin_sway(robots[ends], dynamics.take(ends))
        if len(index):
            stance = 1 - memory.stance[robots[index]]
            self._stepping.begin(memory, robots[index], dynamics.take(index), stance)

    def _sway_ends(self, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Whether robots are due for the first step (n,); those out of time restart the sway."""
        sway = take(self.memory.sway, robots)
        position = self.memory.to_heading(dynamics.com[:, :2], robots)
        velocity = self.memory.to_heading(dynamics.com_velocity[:, :2], robots)
        support = dynamics.foot_positions[np.arange(len(robots)), _first_stance(sway.side), :2]
        foot = self.memory.to_heading(support, robots)
        done = self._plant.entry.done(sway, position, velocity, foot)
        self._plant.entry.restart(sway, position, velocity)
        scatter(self.memory.sway, robots, sway)
        return done

    def _can_stop(self, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Whether the capture point is between the feet and within their length (n,)."""
        capture = dynamics.com[:, :2] + dynamics.com_velocity[:, :2] / self._plant.omega
        feet = [self.memory.to_heading(dynamics.foot_positions[:, i, :2], robots) for i in FEET]
        place = self.memory.to_heading(capture, robots)
        apart = np.abs(feet[LEFT] - feet[RIGHT])[:, 0]
        ahead = np.abs(place - 0.5 * (feet[LEFT] + feet[RIGHT]))[:, 0]
        between = (place[:, 1] < feet[LEFT][:, 1]) & (place[:, 1] > feet[RIGHT][:, 1])
        beside = (apart < self._plant.reach) & (ahead < self._plant.reach / 2)
        return between & beside


def _first_stance(side: np.ndarray) -> np.ndarray:
    return np.where(side > 0, LEFT, RIGHT)
