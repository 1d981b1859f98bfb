"""Roll a controller out from given starts and record what the metrics need.

The rollout owns plant, starts, commands and terminations; a controller only maps state to the
plant's inputs. It serves all controllers and the checks during training alike. A plant
with a shorter period than the control period calls its controller more often. States are recorded
and failures detected once per control period; loads of the drives, contacts and the distance of
the legs at every simulation step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from slider.config.env import EnvConfig, PlantConfig, StartNoise
from slider.env import terminations
from slider.env.instruments import Contacts, DriveLoads, join, over
from slider.env.physics import BatchedPhysics
from slider.env.starts import at_rest
from slider.env.state import RobotState
from slider.env.terrain import Terrain
from slider.robot.names import GRAVITY


class Controller(Protocol):
    """Maps the state of N robots to the plant's inputs, once per step of the plant."""

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start an episode of N robots commanded to ``velocity`` (N, 3): vx, vy, yaw rate."""

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from the next call of ``control`` on."""

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m], or torques [N m or N] of a torque plant."""
        ...


@runtime_checkable
class CanFail(Controller, Protocol):
    """A slow controller, so that robots that have failed are not simulated further."""

    def deactivate(self, robots: np.ndarray) -> None:
        """Stop controlling ``robots`` (N,); their inputs are zero."""


@dataclass(frozen=True)
class Recording:
    """Time series of N robots over S control steps; after a failure the values are meaningless.

    Attributes:
        period: control period [s].
        command: (S, N, 3) vx, vy [m/s], yaw rate [rad/s] of each step.
        alive: (S, N) not failed up to and including this step.
        velocity: (S, N, 2) forward and leftward velocity of the base [m/s].
        yaw: (S, N) [rad].
        position: (S, N, 2) of the base in the world [m].
        foot_positions: (S, N, 2, 3) [m], z above the ground below.
        contacts: of the feet and between the legs at each of the T simulation steps.
        estimate_error: (S, N, 4) error of the state that the controller receives: forward and
            leftward velocity [m/s], height [m], tilt [rad].
        power, effort_share, speed_share: (S, N) see :class:`DriveLoads`, over each control step.
        diverged: (N,) the simulation blew up, for deactivated robots before their deactivation.
        weight: (N,) m g [N].
    """

    period: float
    command: np.ndarray
    alive: np.ndarray
    velocity: np.ndarray
    yaw: np.ndarray
    position: np.ndarray
    foot_positions: np.ndarray
    contacts: Contacts
    estimate_error: np.ndarray
    power: np.ndarray
    effort_share: np.ndarray
    speed_share: np.ndarray
    diverged: np.ndarray
    weight: np.ndarray

    @property
    def survived(self) -> np.ndarray:
        """Robots (N,) that did not fail."""
        return self.alive[-1]

    @property
    def timestep(self) -> float:
        """Simulation step [s]."""
        return self.period * len(self.alive) / len(self.contacts.forces)

    @property
    def foot_forces(self) -> np.ndarray:
        """Vertical ground reactions (S, N, 2) [N] at the end of each control step."""
        ticks = len(self.contacts.forces) // len(self.alive)
        return self.contacts.forces[ticks - 1 :: ticks]


def roll_out(
    controller: Controller,
    physics: BatchedPhysics,
    config: EnvConfig | PlantConfig,
    start: tuple[np.ndarray, np.ndarray],
    command: np.ndarray,
    duration: float,
    progress: Callable[[float], None] = lambda share: None,
) -> Recording:
    """Simulate N robots for ``duration`` [s].

    Args:
        controller: for N robots; if it is a :class:`CanFail`, failed robots are not simulated.
        physics: of N robots; its state is overwritten. Its period divides the control period. The
            controller receives the measured state; everything else is the true one.
        config: control period and terminations.
        start: positions (N, 19) and velocities (N, 18).
        command: vx, vy [m/s], yaw rate [rad/s]: (N, 3) constant from t = 0, or (S, N, 3) of each
            control step.
        duration: [s].
        progress: called with the share done.
    """
    steps = round(duration / config.control_period)
    ticks = round(config.control_period / physics.period)
    physics.restart_disturbances()
    physics.reset(np.arange(physics.num_robots), *start)
    state = physics.read()
    commands = np.broadcast_to(command, (steps, physics.num_robots, 3))
    controller.reset(physics.measure(state), commands[0])
    alive = np.ones(physics.num_robots, dtype=bool)
    diverged = np.zeros(physics.num_robots, dtype=bool)
    rows: list[dict[str, np.ndarray]] = []
    contacts: list[Contacts] = []
    for step in range(steps):
        if step and (commands[step] != commands[step - 1]).any():
            controller.set_velocity(commands[step])
        state, record, blown_up, touched = run_ticks(controller, physics, state, ticks)
        diverged |= blown_up
        alive = alive & ~terminations.failed(state, config.termination.terms) & ~diverged
        feet = state.foot_positions.copy()
        feet[..., 2] -= state.ground.height(feet[..., :2], gaps=False)
        row = {
            "alive": alive,
            "velocity": state.heading_velocity,
            "yaw": state.yaw,
            "position": state.base_position[:, :2],
            "foot_positions": feet.astype(np.float32),
        }
        rows.append(row | record)
        contacts.append(touched)
        progress((step + 1) / steps)
        if isinstance(controller, CanFail):
            controller.deactivate(~alive)
            physics.deactivate(~alive)
            if not alive.any():
                break
    missing = steps - len(rows)
    rows, contacts = rows + rows[-1:] * missing, contacts + contacts[-1:] * missing
    return Recording(
        config.control_period,
        commands,
        **{name: np.stack([row[name] for row in rows]) for name in rows[0]},
        contacts=join(contacts),
        diverged=diverged,
        weight=physics.masses * GRAVITY,
    )


def run_ticks(
    controller: Controller, physics: BatchedPhysics, state: RobotState, ticks: int
) -> tuple[RobotState, dict[str, np.ndarray], np.ndarray, Contacts]:
    """Call the controller and step the plant ``ticks`` times.

    Returns:
        The state afterwards; loads of the drives, and ``estimate_error`` at the start, as in
        :class:`Recording`; robots (N,) whose simulation blew up; contacts.
    """
    measured = physics.measure(state)
    error = _estimate_error(measured, state)
    diverged = np.zeros(physics.num_robots, dtype=bool)
    loads: list[DriveLoads] = []
    contacts: list[Contacts] = []
    for tick in range(ticks):
        physics.step(controller.control(physics.measure(state) if tick else measured))
        state = physics.read()
        loads.append(physics.loads())
        contacts.append(physics.contacts())
        diverged |= state.diverged
    return state, over(loads)._asdict() | {"estimate_error": error}, diverged, join(contacts)


def _estimate_error(measured: RobotState, state: RobotState) -> np.ndarray:
    """Forward, leftward velocity, height and tilt (N, 4); see :class:`Recording`."""
    velocity = measured.heading_velocity - state.heading_velocity
    height = measured.base_height - state.base_height
    tilt = np.linalg.norm(measured.gravity - state.gravity, axis=1)
    return np.column_stack([velocity, height, tilt]).astype(np.float32)


@dataclass(frozen=True)
class Frame:
    """One frame of a motion.

    Attributes:
        time: since the start [s].
        qpos: base pose and joint positions (19,).
        velocity: forward and leftward velocity of the base (2,) [m/s], heading frame.
        failed: a termination term holds.
    """

    time: float
    qpos: np.ndarray
    velocity: np.ndarray
    failed: bool


def mean_speed(frames: Sequence[Frame]) -> float:
    """Mean forward velocity in the second half of the frames [m/s]."""
    return float(np.mean([frame.velocity[0] for frame in frames[len(frames) // 2 :]]))


class Episode:
    """A controller and one simulated robot that starts at rest, for videos and the viewer.

    ``noise`` is that of the starts; ``period`` is the time between two frames [s]. Velocities (3,)
    are the command: vx, vy [m/s], yaw rate [rad/s].
    """

    def __init__(
        self,
        controller: Controller,
        physics: BatchedPhysics,
        config: EnvConfig | PlantConfig,
        noise: StartNoise,
        seed: int,
    ) -> None:
        self.period = config.control_period
        self._controller, self._physics, self._config = controller, physics, config
        self._noise, self._generator = noise, np.random.default_rng(seed)
        self._ticks = round(config.control_period / physics.period)
        self._state: RobotState = physics.read()
        self._steps = 0

    def start(self, velocity: np.ndarray) -> Frame:
        """Place the robot at rest, with new noise."""
        place = at_rest(self._physics.robot, self._noise, self._generator, 1)
        self._physics.reset(np.arange(1), *place)
        self._state, self._steps = self._physics.read(), 0
        self._controller.reset(self._physics.measure(self._state), velocity[None].copy())
        return self._frame()

    @property
    def terrain(self) -> Terrain | None:
        """Uneven ground, if there is any."""
        return self._physics.terrain

    def step(self, velocity: np.ndarray) -> Frame:
        """Simulate one control period."""
        self._controller.set_velocity(velocity[None].copy())
        self._state, *_ = run_ticks(self._controller, self._physics, self._state, self._ticks)
        self._steps += 1
        return self._frame()

    def push(self, velocity: np.ndarray) -> None:
        """Add ``velocity`` (2,) [m/s], world frame, to the base's, as an impulse would."""
        self._physics.qvel[0, :2] += velocity

    def _frame(self) -> Frame:
        failed = terminations.failed(self._state, self._config.termination.terms)
        return Frame(
            time=self._steps * self._config.control_period,
            qpos=self._state.qpos[0],
            velocity=self._state.heading_velocity[0].copy(),
            failed=bool(failed[0]),
        )
