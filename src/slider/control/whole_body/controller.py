"""Walking with a whole-body QP: entry, modes and stance are shared, the way of stepping differs.

At zero velocity the robot stands on both feet. At another it sways into the sideways orbit and
walks. Back at zero it steps until the capture point lies between the feet.

The controller receives the true state, contact flags and a nominal model of the robot, or the
estimate of an observer; ``docs/explanation/baseline.md`` compares this with the policy's input.
"""

import numpy as np

from slider.config.control import ModelBasedConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body.memory import LEFT, OFF, STAND, SWAY, WALK, Memory, take
from slider.control.whole_body.model import Dynamics, NominalModel
from slider.control.whole_body.modes import Entry, Modes, Stepping
from slider.control.whole_body.references import natural_frequency
from slider.control.whole_body.tasks import BodyControl, Solved
from slider.env.instruments import CONTACT_FORCE
from slider.env.state import RobotState
from slider.robot import names

_GIVE_UP_TILT = 1.2  # [rad]; beyond it, or without a solution, the drives are switched off


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
        self.omega = natural_frequency(self.model.nominal_height)
        self.reach = min(robot.geometry.heel, robot.geometry.toe)
        height = self.model.nominal_height
        self.body = BodyControl(robot, config.whole_body, search, height)
        self.entry = Entry(config.step, config.entry, self.omega, self.reach)


class WalkingController:
    """Torques of N robots, once per tick.

    Args:
        plant: the robot, its entry and its body.
        stepping: how it walks.
    """

    def __init__(self, plant: PlantModel, stepping: Stepping) -> None:
        self._period, self._model = plant.period, plant.model
        self._entry, self._body, self._stepping = plant.entry, plant.body, stepping
        self._modes = Modes(plant.entry, stepping, plant.omega, plant.reach)

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start on both feet; ``velocity`` (N, 3) is vx, vy [m/s], yaw rate [rad/s]."""
        robots, dynamics = self._start(state, velocity, state.yaw)
        self._modes.sway(self.memory, robots, dynamics)

    def start_on_gait(self, state: RobotState, velocity: np.ndarray, heading: np.ndarray) -> None:
        """Start in the first step of a walk on the left foot, at ``velocity`` (N, 3).

        The foot is along x; a walk that turns has another ``heading`` (N,) [rad] there.
        """
        robots, dynamics = self._start(state, velocity, heading)
        self.memory.mode[:] = WALK
        self.memory.previous[:] = velocity[:, :2]
        self._stepping.begin(self.memory, robots, dynamics, np.full(len(robots), LEFT))

    def _start(
        self, state: RobotState, velocity: np.ndarray, heading: np.ndarray
    ) -> tuple[np.ndarray, Dynamics]:
        """Reset the memory; indices of all robots and their dynamics."""
        self.memory = Memory.on_both_feet(velocity.copy(), heading)
        self._stepping.reset(state.num_robots)
        dynamics = self._model.evaluate(state.qpos, state.qvel)
        return np.arange(state.num_robots), dynamics

    def give_up(self, robots: np.ndarray) -> None:
        """Switch the drives of ``robots`` (N,) off."""
        self.memory.mode[robots] = OFF

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._stepping.set_velocity(self.memory, velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N]; the upper feet have no drive."""
        memory = self.memory
        memory.mode[-state.gravity[:, 2] < np.cos(_GIVE_UP_TILT)] = OFF
        torques = np.zeros((state.num_robots, names.NUM_JOINTS))
        active = np.flatnonzero(memory.mode != OFF)
        if len(active):
            dynamics = self._model.evaluate(state.qpos[active], state.qvel[active])
            contact = state.foot_forces[active] > CONTACT_FORCE
            self._modes.switch(memory, active, dynamics, contact)
            torques[active] = self._drive(active, dynamics, contact)
            memory.heading[active] += memory.yaw_rate(active) * self._period
        memory.tick += 1
        return torques

    def _drive(self, active: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> np.ndarray:
        """Torques (n, 12) of the active robots, one mode after the other."""
        torques = np.zeros((len(active), names.NUM_JOINTS))
        modes = self.memory.mode[active]
        for mode, drive in ((STAND, self._stand), (SWAY, self._sway), (WALK, self._walk)):
            index = np.flatnonzero(modes == mode)
            if len(index):
                torques[index], solved = drive(active[index], dynamics.take(index), contact[index])
                self.memory.mode[active[index[~solved]]] = OFF
        return torques

    def _stand(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        still = np.zeros((len(robots), 2, 3))
        return self._body.on_both_feet(self.memory, robots, dynamics, contact, still)

    def _sway(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        sway = self.memory.sway
        desired = self._entry.reference(take(sway, robots))
        sway.elapsed[robots] += self._period
        return self._body.on_both_feet(self.memory, robots, dynamics, contact, desired)

    def _walk(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        """Assume the stance foot in contact, whatever its ``contact``."""
        return self._stepping.torques(self.memory, robots, dynamics)
