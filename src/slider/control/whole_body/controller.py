"""Walking with a whole-body QP: entry, modes and stance are shared, the way of stepping differs.

At zero command it stands on both feet. At another it sways into the sideways orbit and walks. Back
at zero it steps until the capture point lies between the feet.

It receives the true state, contact flags and a nominal model of the robot, or the estimate of an
observer; ``docs/explanation/baseline.md`` compares this with what the policy receives.
"""

from typing import Protocol

import numpy as np

from slider.config.control import ModelBasedConfig
from slider.config.robot import RobotConfig
from slider.control.rows import put
from slider.control.whole_body import lip
from slider.control.whole_body.clock import TickClock
from slider.control.whole_body.entry import Entry
from slider.control.whole_body.memory import LEFT, OFF, STAND, SWAY, WALK, Memory
from slider.control.whole_body.modes import Modes
from slider.control.whole_body.nominal import Dynamics, NominalModel
from slider.control.whole_body.observer import Observer
from slider.control.whole_body.tasks import BodyControl, Solved
from slider.env.instruments import CONTACT_FORCE
from slider.env.state import RobotState
from slider.env.underlying import NOBODY
from slider.robot import names

_GIVE_UP_TILT = 1.2  # [rad]; beyond it, or without a solution, the drives are switched off


class Stepping(Protocol):
    """A way of stepping, for the robots (n,) of a memory that walk."""

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""

    def command(self, memory: Memory, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """A new step on the feet ``stance`` (n,)."""

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        ...

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques of this tick."""
        ...


class Surroundings:
    """What any way of stepping needs of the robot.

    Attributes:
        model: nominal, not the plant.
        period: of a tick [s].
        clock: cost of the parts of a tick.
        omega: natural frequency of the pendulum [rad/s].
        body: tasks of the body and their solution.
    """

    def __init__(
        self, robot: RobotConfig, config: ModelBasedConfig, search: float, period: float
    ) -> None:
        self.clock, self.period = TickClock(), period
        self.model = NominalModel(robot)
        self.omega = lip.rate(self.model.nominal_height)
        self.reach = min(robot.geometry.heel, robot.geometry.toe)
        height = self.model.nominal_height
        self.body = BodyControl(robot, config.whole_body, search, height, self.clock)
        self.entry = Entry(config.step, config.entry, self.omega, self.reach)


class WalkingController:
    """Torques of N robots, once per tick.

    Args:
        around: the robot, its entry and its body.
        stepping: how it walks.
    """

    def __init__(self, around: Surroundings, stepping: Stepping) -> None:
        self.clock = around.clock
        self._period, self._model = around.period, around.model
        self._entry, self._body, self._stepping = around.entry, around.body, stepping
        self._modes = Modes(around.entry, stepping, around.omega, around.reach)

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew on both feet; ``velocity`` (N, 3) is vx, vy [m/s], yaw rate [rad/s]."""
        self._start(state, velocity, state.yaw, NOBODY)

    def start_on_gait(self, state: RobotState, velocity: np.ndarray, heading: np.ndarray) -> None:
        """Start anew in the first step of a walk on the left foot, at ``velocity``.

        The foot is along x; a walk that turns has another ``heading`` (N,) [rad] there.
        """
        self._start(state, velocity, heading, LEFT)

    def _start(
        self, state: RobotState, velocity: np.ndarray, heading: np.ndarray, stance: int
    ) -> None:
        count = state.num_robots
        self.allocate(count)
        self.restart(np.arange(count), state, velocity, heading, np.full(count, stance))

    def allocate(self, count: int) -> None:
        """Memory of ``count`` robots, none of which has started."""
        self.memory = Memory.on_both_feet(np.zeros((count, 3)), np.zeros(count))
        self._stepping.reset(count)

    def restart(
        self,
        robots: np.ndarray,
        state: RobotState,
        velocity: np.ndarray,
        heading: np.ndarray,
        stance: np.ndarray,
    ) -> None:
        """Start ``robots`` (n,) of N anew; see :class:`UnderlyingController`."""
        memory = self.memory
        put(memory, robots, Memory.on_both_feet(velocity, heading))
        dynamics = self._model.evaluate(state.qpos[robots], state.qvel[robots])
        walks = stance != NOBODY
        self._modes.sway(memory, robots[~walks], dynamics.of(~walks))
        memory.mode[robots[walks]] = WALK
        memory.old[robots[walks]] = velocity[walks, :2]
        self._stepping.begin(memory, robots[walks], dynamics.of(walks), stance[walks])

    def give_up(self, robots: np.ndarray) -> None:
        """Switch the drives of ``robots`` (N,) off."""
        self.memory.mode[robots] = OFF

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._stepping.command(self.memory, velocity)

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
        return self._body.on_both_feet(self.memory, robots, dynamics, contact, still)

    def _sway(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        sway = self.memory.sway
        desired = self._entry.reference(sway.of(robots))
        sway.elapsed[robots] += self._period
        return self._body.on_both_feet(self.memory, robots, dynamics, contact, desired)

    def _walk(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> Solved:
        """Counts on the stance foot, whatever its ``contact``."""
        return self._stepping.torques(self.memory, robots, dynamics)


class ObservingController:
    """The controller behind its observer, whose estimates it receives."""

    def __init__(self, controller: WalkingController, observer: Observer) -> None:
        self._controller, self._observer = controller, observer

    @property
    def clock(self) -> TickClock:
        """Cost of the parts of a tick."""
        return self._controller.clock

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew; see :class:`WalkingController`."""
        self._observer.reset(state)
        self._controller.reset(state, velocity)

    def give_up(self, robots: np.ndarray) -> None:
        """Switch the drives of ``robots`` (N,) off and observe them no longer."""
        self._observer.give_up(robots)
        self._controller.give_up(robots)

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


ModelBased = WalkingController | ObservingController
