"""The model-predictive controller: entry, footstep MPC, swing foot and whole-body QP for N robots.

At zero command it stands on both feet. At another it sways into the sideways orbit and walks. Back
at zero it steps until the capture point lies between the feet.

It receives the true state, contact flags and a nominal model of the robot, or the estimate of an
observer; ``docs/explanation/baseline.md`` compares this with what the policy receives.
"""

from dataclasses import replace

import numpy as np

from slider.config.control import MpcConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.mpc import lip
from slider.control.mpc.clock import TickClock
from slider.control.mpc.entry import Entry
from slider.control.mpc.memory import OFF, STAND, SWAY, WALK, Memory
from slider.control.mpc.modes import Modes
from slider.control.mpc.nominal import Dynamics, NominalModel
from slider.control.mpc.observer import Observer
from slider.control.mpc.steps import ReferenceVelocity, Steps
from slider.control.mpc.tasks import Solved, TorqueControl
from slider.env.instruments import CONTACT_FORCE
from slider.env.state import RobotState
from slider.robot import names

_GIVE_UP_TILT = 1.2  # [rad]; beyond it, or without a solution, the drives are switched off


class MpcController:
    """Torques of N robots, once per tick.

    Args:
        robot: the nominal robot, not the plant.
        config: settings of the baseline.
        period: of a tick [s].
    """

    def __init__(self, robot: RobotConfig, config: MpcConfig, period: float) -> None:
        self.clock = TickClock()
        self._period = period
        self._model = NominalModel(robot)
        omega = lip.rate(self._model.nominal_height)
        reach = min(robot.geometry.heel, robot.geometry.toe)
        self._velocity = ReferenceVelocity(config.planner, period)
        self._entry = Entry(config.step, config.entry, omega, reach)
        self._steps = Steps(config, omega, self._velocity, period, self.clock)
        self._modes = Modes(self._entry, self._steps, omega, reach)
        self._torques = TorqueControl(robot, config, self._model.nominal_height, self.clock)

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew on both feet; ``velocity`` (N, 3) is vx, vy [m/s], yaw rate [rad/s]."""
        self.memory = Memory.on_both_feet(velocity, state.yaw)
        dynamics = self._model.evaluate(state.qpos, state.qvel)
        self._modes.sway(self.memory, np.arange(state.num_robots), dynamics)

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._velocity.change(self.memory, velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N]; the upper feet have no drive."""
        memory = self.memory
        memory.mode[-state.gravity[:, 2] < np.cos(_GIVE_UP_TILT)] = OFF
        torques = np.zeros((state.num_robots, names.NUM_JOINTS))
        active = np.flatnonzero(memory.mode != OFF)
        if len(active):
            self.clock.ticks += len(active)
            with self.clock.part("model"):
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
                found = drive(active[index], dynamics.of(index), contact[index])
                torques[index], solved = found
                self.memory.mode[active[index[~solved]]] = OFF
        return torques

    def _stand(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        still = np.zeros((len(robots), 2, 3))
        return self._torques.on_both_feet(self.memory, robots, dynamics, contact, still)

    def _sway(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        sway = self.memory.sway
        desired = self._entry.reference(sway.of(robots))
        sway.elapsed[robots] += self._period
        return self._torques.on_both_feet(self.memory, robots, dynamics, contact, desired)

    def _walk(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        """Counts on the stance foot, whatever its ``contact``."""
        self._steps.advance(self.memory, robots, dynamics)
        return self._torques.on_one_foot(self.memory, robots, dynamics)


class ObservingController:
    """The controller behind its observer, whose estimates it receives."""

    def __init__(self, controller: MpcController, observer: Observer) -> None:
        self._controller, self._observer = controller, observer

    @property
    def clock(self) -> TickClock:
        """Cost of the parts of a tick."""
        return self._controller.clock

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew; see :class:`MpcController`."""
        self._observer.reset(state)
        self._controller.reset(state, velocity)

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._controller.command(velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N] from measured states."""
        with self.clock.part("observer"):
            estimate = self._observer.estimate(state)
        torques = self._controller.control(estimate)
        self._observer.send(torques)
        return torques


Baseline = MpcController | ObservingController


def build_controller(
    robot: RobotConfig, config: MpcConfig, physics: PhysicsConfig, count: int, threads: int = 1
) -> Baseline:
    """The baseline for ``count`` robots.

    Args:
        robot: the nominal robot, not the plant.
        config: settings.
        physics: of the plant; the observer's model has the same.
        count: number of robots.
        threads: of the observer's simulation.
    """
    tick = replace(physics, substeps=config.substeps)
    controller = MpcController(robot, config, tick.substeps * tick.timestep)
    if config.observer is None:
        return controller
    return ObservingController(controller, Observer(robot, tick, config.observer, count, threads))
