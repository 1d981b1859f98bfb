"""Batched MuJoCo physics on a thread pool, driven by joint positions or by joint efforts."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import copy
import ctypes
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout

from slider.config.env import OnboardConfig, PhysicsConfig
from slider.config.robot import RobotConfig
from slider.core.arrays import Array, consecutive
from slider.env.disturbance import (
    TILES,
    Disturbance,
    DisturbanceModel,
    SeededRandom,
    build_plant,
    has_terrain,
)
from slider.env.height_field import FLAT, Ground
from slider.env.height_field import TILES as TABLE
from slider.env.instruments import Contacts, DriveLoads, acting_torques, loads, observe
from slider.env.onboard import OnboardState
from slider.env.randomization import Fields, vary
from slider.env.state import SPEED_LIMIT, RobotState, SensorIndex, read_state
from slider.env.terrain import Terrain
from slider.robot import names
from slider.robot.mjcf import Actuation, SimulationOptions, nominal_qpos
from slider.robot.transmission import Transmission, by_motor

_CONTROL, _APPLIED = mujoco.mjtState.mjSTATE_CTRL, mujoco.mjtState.mjSTATE_QFRC_APPLIED
_START_TIME = 1.0  # nonzero: reveals an automatic reset of MuJoCo even after one step


def _stop_timers() -> None:
    """Disable MuJoCo's profiling timers, which are unused and run many times in each step."""
    for library in Path(mujoco.__file__).parent.glob("libmujoco.*"):
        ctypes.c_void_p.in_dll(ctypes.CDLL(str(library)), "mjcb_time").value = None


class BatchedPhysics:
    """Steps ``num_robots`` copies of the robot.

    Inputs are desired joint positions or joint efforts, which the transmission maps to motor angles
    or torques. See :class:`SimulationOptions`.
    A ``disturbance`` varies the robots, delays their inputs, pushes them and adds noise to
    :meth:`measure`; with ``onboard``, that returns the estimate from onboard sensors. Without
    ``instruments`` the simulation is faster but has no :meth:`contacts`. Robots are frozen from
    :meth:`deactivate` to their next :meth:`reset`.

    Attributes:
        state: MuJoCo's full physics state (N, 38): time, positions, velocities.
    """

    def __init__(
        self,
        robot: RobotConfig,
        config: PhysicsConfig,
        num_robots: int,
        threads: int = 1,
        actuation: Actuation = "position",
        disturbance: Disturbance | None = None,
        instruments: bool = True,
        onboard: OnboardConfig | None = None,
    ) -> None:
        options = SimulationOptions.of(config, actuation=actuation, instruments=instruments)
        # Write no log file: blow-ups are detected, counted and ended here.
        mujoco.set_mju_user_warning(lambda message: None)
        _stop_timers()
        self.robot = robot
        self.model = build_plant(robot, options, disturbance)
        self.models = [self.model] * num_robots
        self._disturber: DisturbanceModel | None = None
        self.terrain: Terrain | None = None
        self._ground: Ground = FLAT
        seeds = (0,) if disturbance is None else disturbance.seeds
        if disturbance is not None:
            write, on_terrain = None, has_terrain(disturbance.config)
            if on_terrain or vary(disturbance.config):
                self.models = [copy.copy(self.model) for _ in range(num_robots)]
                self._constants = mujoco.MjData(self.model)
                write = self._set_fields
            if on_terrain:  # robots of all seeds share one table of tiles
                table = (
                    SeededRandom(seeds[:1], 1)
                    .generators(TILES, 0)[0]
                    .uniform(-1, 1, (TABLE, TABLE))
                )
                self.terrain = Terrain(disturbance.config.terrain, robot, self.models, table)
                self._ground = self.terrain.ground
            self._disturber = DisturbanceModel(
                disturbance, robot, self.model, actuation, num_robots, write, ground=self.terrain
            )
        self.num_robots = num_robots
        self.nominal = nominal_qpos(robot)
        self._substeps = config.substeps
        self.period = config.substeps * config.timestep
        self._data = [mujoco.MjData(self.model) for _ in range(threads)]
        self._pool = rollout.Rollout(nthread=threads if threads > 1 else 0)
        self._rest = np.concatenate([[0.0], self.nominal, np.zeros(self.model.nv)])
        self.state = np.tile(self._rest, (num_robots, 1))
        self._sensors = np.zeros((num_robots, self.model.nsensordata))
        self._before = self.state
        self._series = self.state[:, None], self._sensors[:, None]
        self._onboard: OnboardState | None = None
        if onboard is not None:
            self._onboard = OnboardState(onboard, robot, seeds, num_robots, self._rest)
        self._diverged = np.zeros(num_robots, dtype=bool)
        self._inactive = np.zeros(num_robots, dtype=bool)
        self._index = SensorIndex(self.model, instruments)
        self._motors = Transmission.of(robot)
        damping = np.array([gains.kd for gains in by_motor(robot, robot.gains) * len(names.SIDES)])
        self._damping = damping if actuation == "position" else 0.0 * damping
        self._to_motors = self._motors.torques if actuation == "torque" else self._motors.angles

    @property
    def qpos(self) -> np.ndarray:
        """View of the base pose and joint positions (N, 19)."""
        return self.state[:, 1 : 1 + self.model.nq]

    @property
    def qvel(self) -> np.ndarray:
        """View of the base and joint velocities (N, 18): linear world, angular base frame."""
        return self.state[:, 1 + self.model.nq :]

    def _set_fields(self, index: np.ndarray, fields: Fields) -> None:
        """Write fields (n, ...) of the models of robots (n,), and update derived constants."""
        for row, robot in enumerate(index):
            model = self.models[robot]
            for name, values in fields.items():
                getattr(model, name)[:] = values[row]
            mujoco.mj_setConst(model, self._constants)

    def reset(self, index: Array, qpos: Array, qvel: Array) -> None:
        """Place robots ``index`` at positions (n, 19) and velocities (n, 18).

        Arguments are arrays, or tensors on the CPU.
        """
        index, qpos, qvel = np.asarray(index), np.asarray(qpos), np.asarray(qvel)
        if self._onboard is not None:
            self._onboard.begin(index, qpos, qvel)
        if self._disturber is not None:
            qpos = self._disturber.begin(index, qpos)
        self.qpos[index] = qpos
        self.qvel[index] = qvel
        self._sensors[index] = 0.0
        self._diverged[index] = self._inactive[index] = False

    def deactivate(self, robots: np.ndarray) -> None:
        """Stop simulating ``robots`` (N,)."""
        self._inactive |= robots

    def step(self, inputs: Array) -> None:
        """Simulate one ``period`` [s] with constant inputs (N, 12) [rad or m; N m or N].

        Inputs are an array, or a tensor on the CPU, whose memory is used without a copy.
        """
        inputs = np.asarray(inputs)
        self.state[:, 0] = _START_TIME
        control = np.repeat(self._to_motors(inputs)[:, None], self._substeps, axis=1)
        if self._disturber is not None:
            force = self._disturber.push()
            control = self._disturber.drive(control)
            if force is not None and force.any():  # generalised forces follow the control
                applied = np.zeros((*control.shape[:2], self.model.nv))
                applied[..., :2] = force[:, None]
                control = np.concatenate([control, applied], axis=2)
        states, sensors = self._simulate(control)
        self._diverged = self._find_diverged(states[:, -1]) | ~np.isfinite(inputs).all(axis=1)
        self._diverged &= ~self._inactive
        if self._diverged.any():
            states[self._diverged] = self._rest
            sensors[self._diverged] = 0.0
        self._before = self.state
        self.state, self._sensors = states[:, -1].copy(), sensors[:, -1].copy()
        self._series = states, sensors
        if self._onboard is not None:
            torques = self._drive()[0].mean(axis=1)
            self._onboard.advance(self.period, self._substeps, torques)
        if self.terrain is not None:
            state = self.read()
            feet, speeds = state.foot_positions[..., :2], state.foot_velocities[..., :2]
            self.terrain.follow(state.base_position[:, :2], feet, speeds)

    def check(self) -> None:
        """Do nothing: :meth:`step` detects every error at once."""

    def _simulate(self, control: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States (N, S, 38) and sensors (N, S, sensors) after each of S steps."""
        spec = _CONTROL | _APPLIED if control.shape[2] > self.model.nu else _CONTROL
        shape, still = (self.num_robots, self._substeps), self._inactive
        states = np.empty((*shape, self.state.shape[1]))
        sensors = np.empty((*shape, self._sensors.shape[1]))
        states[still], sensors[still] = self.state[still, None], self._sensors[still, None]
        going = np.flatnonzero(~still)
        if len(going):
            rows = consecutive(going)
            results = states[rows], sensors[rows]
            self._pool.rollout(
                self.models if len(going) == len(still) else [self.models[i] for i in going],
                self._data,
                self.state[rows],
                control[rows],
                control_spec=int(spec),
                skip_checks=True,  # of every model in every step
                nstep=self._substeps,
                state=results[0],
                sensordata=results[1],
            )
            states[rows], sensors[rows] = results
        return states, sensors

    def _find_diverged(self, state: np.ndarray) -> np.ndarray:
        """Whether robots diverged (N,). MuJoCo silently resets such a state, and its clock to 0."""
        late = np.abs(state[:, 0] - _START_TIME - self.period) > 1e-9
        wild = ~np.isfinite(state).all(axis=1)
        with np.errstate(invalid="ignore"):
            fast = (np.abs(state[:, 1 + self.model.nq :]) > SPEED_LIMIT).any(axis=1)
        return late | wild | fast

    def loads(self) -> DriveLoads:
        """Loads of the motors in the last :meth:`step`, at each of its simulation steps."""
        return loads(self._motors, *self._drive())

    def _drive(self) -> tuple[np.ndarray, np.ndarray]:
        """Motor torques [N m] that acted in the last :meth:`step`, and speeds after [rad/s].

        Both (N, S, 10), for its S simulation steps.
        """
        states, sensors = self._series
        joints = slice(-names.NUM_JOINTS, None)
        rates = [self._before[:, None, joints], states[:, :, joints]]
        speeds = self._motors.angles(np.concatenate(rates, axis=1))
        gain = 1.0 if self._disturber is None else self._disturber.motor_gain
        motors = replace(
            self._motors, torque=gain * self._motors.torque, stall=gain * self._motors.stall
        )
        demanded = sensors.take(self._index.torques, 2)
        return acting_torques(motors, gain * self._damping, demanded, speeds), speeds[:, 1:]

    def contacts(self) -> Contacts:
        """Feet and legs in the last :meth:`step`, at each of its simulation steps."""
        sensors, index = self._series[1], self._index
        forces = np.abs(sensors.take(index.forces, 2))
        distances = sensors.take(index.distances, 2)
        return observe(forces, *self.foot_ends(), distances, self._ground)

    def foot_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest points of heel and toe at each simulation step of the last :meth:`step`.

        Returns:
            Positions [m], and velocities of the foot there, v + ω × (0, 0, −r) [m/s],
            (N, steps, 2, 2, 3) in the world: foot (left, right), end (heel, toe), coordinate.
        """
        sensors, index, radius = self._series[1], self._index, self.robot.geometry.foot_radius
        positions, velocities = sensors.take(index.ends, 2), sensors.take(index.end_velocities, 2)
        turning = radius * sensors.take(index.turning, 2)[..., None, :]
        positions[..., 2] -= radius
        velocities[..., 0] -= turning[..., 1]
        velocities[..., 1] += turning[..., 0]
        return positions, velocities

    def read(self) -> RobotState:
        """Name the quantities of the current state."""
        state = read_state(self.qpos, self.qvel, self._sensors, self._index, self._diverged)
        return replace(state, ground=self._ground)

    def measure(self, state: RobotState) -> RobotState:
        """The state as a controller receives it: with sensor noise, or estimated."""
        if self._onboard is not None:
            return self._onboard.measure(state)
        return state if self._disturber is None else self._disturber.measure(state)

    def restart_disturbances(self) -> None:
        """Restart the sequences of disturbances and sensor errors."""
        if self._onboard is not None:
            self._onboard.restart()
        if self._disturber is not None:
            self._disturber.restart()

    @property
    def masses(self) -> np.ndarray:
        """Mass of each robot (N,) [kg]."""
        return np.array([model.body_mass.sum() for model in self.models])
