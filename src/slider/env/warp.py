"""MuJoCo Warp: the physics of many robots on a device, behind the methods of ``BatchedPhysics``.

All arrays are float32 torch tensors that share Warp's memory. A control step is one graph: CUDA
runs it without the host, and Warp's CPU device replays it in a thirtieth of the time that launching
its kernels one by one takes. Nothing in a step waits for the device.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import torch

from slider.config.env import DisturbanceConfig, PhysicsConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.env import randomization
from slider.env.disturbance import Disturbance, Disturber, build_plant
from slider.env.randomization import GAIN_COLUMNS, RESISTANCE, SLIDING
from slider.env.state import SPEED_LIMIT, RobotState, SensorIndex, read_state
from slider.robot import names
from slider.robot.mjcf import Actuation, SimulationOptions, nominal_qpos
from slider.robot.transmission import Transmission

try:
    import mujoco_warp as mjw
    import warp as wp
except ModuleNotFoundError as error:
    message = "expected MuJoCo Warp, found none: pip install -e '.[gpu]' -c constraints.txt"
    raise UserError(message) from error

CONTACTS = 16  # per robot, on average over all: a robot that stands has 4
ROWS = 64  # of constraints per robot: 16 in stance, 26 where robots lie on the ground and kick
_DERIVED = ("body_subtreemass", "body_invweight0", "dof_invweight0", "tendon_invweight0")
# Solver and line search stop at their limit as MuJoCo's own do, which says nothing either.
_LIMITS = mjw.OverflowType.ITERATIONS | mjw.OverflowType.LS_ITERATIONS
VARIED_FIELDS = (
    *("body_mass", "body_inertia", "body_ipos", "geom_friction"),
    *("actuator_gainprm", "actuator_forcerange"),
)


class WarpPhysics:
    """Steps ``num_robots`` copies of the robot on flat ground, disturbed as in ``BatchedPhysics``.

    Evaluation needs contacts and loads of every simulation step and runs on MuJoCo itself. The
    kernels are compiled, which takes half a minute unless Warp's cache has them.

    Args:
        device: Warp's and torch's name of it, such as ``cpu`` or ``cuda:0``.
        rows: of constraints that a robot may have.

    Other arguments are those of ``BatchedPhysics``.

    Attributes:
        qpos, qvel: (N, 19), (N, 18) positions and velocities, shared with the simulation.
        model: of the nominal robot.
        device: where the tensors are.
        terrain: none; the ground is flat.
    """

    terrain = None

    def __init__(
        self,
        robot: RobotConfig,
        config: PhysicsConfig,
        num_robots: int,
        device: str = "cpu",
        disturbance: Disturbance | None = None,
        actuation: Actuation = "position",
        rows: int = ROWS,
    ) -> None:
        options = SimulationOptions(
            config.timestep,
            config.solver_iterations,
            config.line_search_iterations,
            actuation=actuation,
        )
        self.robot, self.num_robots = robot, num_robots
        self.period = config.substeps * config.timestep
        self.model = build_plant(robot, options, None)
        varied = disturbance is not None and randomization.vary(disturbance.config)
        self._warp_device = _device(device)
        self.device = torch.device(wp.device_to_torch(self._warp_device))
        sizes = dict.fromkeys((*VARIED_FIELDS, *_DERIVED), num_robots) if varied else {}
        with wp.ScopedDevice(self._warp_device):
            self._models = mjw.put_model(self.model, sizes)
            self._models.opt.warn_overflow = 0  # see check
            self._data = mjw.make_data(self.model, num_robots, nconmax=CONTACTS, njmax=rows)
            control = wp.zeros((config.substeps, num_robots, self.model.nu), dtype=float)
        self._inputs = [control[i] for i in range(config.substeps)]
        self._control = wp.to_torch(control)  # (steps, N, inputs)
        self.qpos, self.qvel = wp.to_torch(self._data.qpos), wp.to_torch(self._data.qvel)
        self._applied = wp.to_torch(self._data.qfrc_applied)
        self._sensors = wp.to_torch(self._data.sensordata)  # one simulation step older
        self._overflow = wp.to_torch(self._data.overflow)
        self._advance = self._graph(self._simulate)
        self._derive = self._graph(self._set_constants) if varied else None
        self._overflow.zero_()
        self._index: Any = SensorIndex(self.model)
        for name, columns in vars(self._index).items():  # a list would be copied to the device
            setattr(self._index, name, torch.tensor(columns, device=self.device))
        motors = Transmission.of(robot)
        matrix = motors.inverse if actuation == "torque" else motors.matrix
        self._to_motors = self._tensor(matrix.T)
        self._rest = self._tensor(nominal_qpos(robot))
        self._diverged = torch.zeros(num_robots, dtype=torch.bool, device=self.device)
        self._disturber: Any = None  # its arrays are tensors
        if disturbance is not None:
            robots = WarpModels(self, disturbance.config) if varied else None
            self._disturber = Disturber(
                disturbance, robot, self.model, actuation, num_robots, robots, self.qpos
            )
        self._place_at_rest(torch.ones_like(self._diverged))

    def _simulate(self) -> None:
        # MuJoCo's rollout keeps no warm start between control steps either.
        self._data.qacc_warmstart.zero_()
        for inputs in self._inputs:
            wp.copy(self._data.ctrl, cast(wp.array, inputs))
            mjw.step(self._models, self._data)

    def _set_constants(self) -> None:
        groups = mjw.SetConstGroup.FIXED | mjw.SetConstGroup.INERT0
        mjw.set_const(self._models, self._data, groups, restore=False)

    def _graph(self, work: Callable[[], None]) -> "wp.Graph":
        with wp.ScopedDevice(self._warp_device):
            work()  # loads the kernels
            with wp.ScopedCapture() as capture:
                work()
            wp.synchronize_device()
        return cast(wp.Graph, capture.graph)

    def _launch(self, graph: "wp.Graph") -> None:
        """Run a graph in the order of torch's own work on the device."""
        stream = wp.stream_from_torch(self.device) if self._warp_device.is_cuda else None
        wp.capture_launch(graph, stream)

    def field(self, name: str) -> torch.Tensor:
        """A varied field of the robots' models (N, ...); call :meth:`derive` after a change."""
        return wp.to_torch(getattr(self._models, name))

    def derive(self) -> None:
        """Compute what depends on varied masses and inertias, as ``mj_setConst`` does."""
        assert self._derive is not None, "nothing is varied"
        self._launch(self._derive)

    def _tensor(self, values: Any) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self.device).contiguous()

    def _place_at_rest(self, robots: torch.Tensor) -> None:
        """Put ``robots`` (N,), a mask, at rest in the nominal pose, with empty sensors."""
        mask = robots[:, None]
        self.qpos.copy_(self._rest.where(mask, self.qpos))
        self.qvel.masked_fill_(mask, 0.0)
        self._sensors.masked_fill_(mask, 0.0)

    def reset(self, index: torch.Tensor, qpos: torch.Tensor, qvel: torch.Tensor) -> None:
        """Place robots ``index`` (n,) at positions (n, 19) and velocities (n, 18)."""
        if self._disturber is not None:
            qpos = self._disturber.begin(index, qpos)
        self.qpos[index], self.qvel[index] = qpos, qvel
        self._sensors[index] = 0.0
        self._diverged[index] = False

    def step(self, inputs: torch.Tensor) -> None:
        """Simulate one ``period`` [s] with constant inputs (N, 12) [rad or m; N m or N]."""
        control = (inputs @ self._to_motors)[:, None].expand(-1, len(self._control), -1)
        if self._disturber is not None:
            force = self._disturber.push()
            if force is not None:
                self._applied[:, :2] = force
            control = self._disturber.drive(control)
        self._control.copy_(control.transpose(0, 1))
        self._launch(self._advance)
        values = (self.qpos, self.qvel, self._sensors, inputs)
        finite = torch.stack([x.isfinite().all(dim=1) for x in values]).all(dim=0)
        self._diverged.copy_(~finite | (self.qvel.abs() > SPEED_LIMIT).any(dim=1))
        self._overflow.masked_fill_(self._diverged, 0)
        self._place_at_rest(self._diverged)

    def check(self) -> None:
        """Look for overflows since the last call; this waits for the device.

        Raises:
            UserError: contacts or constraints of some robots were lost.
        """
        bits = (self._overflow & ~int(_LIMITS)).cpu()
        self._overflow.zero_()
        robots = torch.nonzero(bits).flatten().tolist()
        if robots:
            kinds = mjw.OverflowType(0)
            for robot in robots:
                kinds |= mjw.OverflowType(int(bits[robot]))
            named = ", ".join(map(str, robots[:8])) + (", …" if len(robots) > 8 else "")
            raise UserError(
                f"MuJoCo Warp: expected no overflow, found {kinds.name} of {len(robots)} of"
                f" {len(bits)} robots: {named}"
            )

    def read(self) -> RobotState:
        """Name the quantities of the current state."""
        return read_state(self.qpos, self.qvel, self._sensors, self._index, self._diverged)

    def measure(self, state: RobotState) -> RobotState:
        """The state as a controller receives it: with sensor noise."""
        return state if self._disturber is None else self._disturber.measure(state)

    def restart_disturbances(self) -> None:
        """Restart the sequence of disturbances."""
        if self._disturber is not None:
            self._disturber.restart()


def _device(name: str) -> "wp.Device":
    wp.config.log_level = wp.LOG_WARNING
    wp.init()
    try:
        return wp.get_device(name)
    except ValueError as error:
        devices = ", ".join(str(device) for device in wp.get_devices())
        raise UserError(
            f"device: expected one that Warp finds ({devices}), found {name}"
        ) from error


class WarpModels:
    """Models of the robots of a simulation, drawn again per robot and episode.

    Attributes:
        motor_gain: (N, 10) by which demanded torques are scaled [-].
    """

    def __init__(self, physics: WarpPhysics, config: DisturbanceConfig) -> None:
        self._physics, self._config, nominal = physics, config, physics.model
        self._fields = {name: physics.field(name) for name in VARIED_FIELDS}
        device = physics.device
        self._nominal = {
            name: torch.as_tensor(getattr(nominal, name), dtype=field.dtype).to(device)
            for name, field in self._fields.items()
        }
        self.motor_gain = torch.ones((physics.num_robots, len(names.MOTORS)), device=device)
        parameters = self._fields["actuator_gainprm"].shape[2]
        self._base = _ones_at([nominal.body(names.BASE).id], nominal.nbody).to(device)
        self._loop = _ones_at(GAIN_COLUMNS, parameters).to(device)
        self._resistance = _ones_at([RESISTANCE], parameters).to(device)
        feet = _ones_at(randomization.feet(nominal), nominal.ngeom)
        self._sliding = (feet[:, None] * _ones_at([SLIDING], 3) > 0).to(device)

    def draw(self, index: torch.Tensor, uniform: torch.Tensor) -> None:
        """Draw robots ``index`` (n,) again by numbers (N, COLUMNS) in [0, 1)."""
        new, nominal = randomization.drawn(self._config, uniform[index]), self._nominal
        mass, gain = new.mass[:, None], new.gain[:, :, None]
        scale = 1.0 + self._loop * (gain - 1.0) + self._resistance * (1.0 / gain - 1.0)
        friction = nominal["geom_friction"]
        if new.friction is not None:
            friction = torch.where(self._sliding, new.friction[:, None, None], friction)
        values = {
            "body_mass": mass * nominal["body_mass"] + self._base * new.payload[:, None],
            "body_inertia": mass[:, :, None] * nominal["body_inertia"],
            "body_ipos": nominal["body_ipos"] + self._base[:, None] * new.shift[:, None],
            "geom_friction": friction,
            "actuator_gainprm": nominal["actuator_gainprm"] * scale,
            "actuator_forcerange": nominal["actuator_forcerange"] * gain,
        }
        for name, value in values.items():
            self._fields[name][index] = value
        self.motor_gain[index] = new.gain
        self._physics.derive()

    @property
    def masses(self) -> torch.Tensor:
        """Masses of the robots (N,) [kg]."""
        return self._fields["body_mass"].sum(dim=1)


def _ones_at(index: Sequence[int] | np.ndarray, size: int) -> torch.Tensor:
    """Ones at ``index`` among zeros (size,)."""
    values = torch.zeros(size)
    values[torch.as_tensor(index)] = 1.0
    return values
