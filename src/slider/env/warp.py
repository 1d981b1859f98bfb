"""MuJoCo Warp: the physics of many robots on a device, with the interface of ``BatchedPhysics``.

All arrays are float32 torch tensors that share Warp's memory. A control step is one graph: CUDA
runs it without the host, and Warp's CPU device replays it in a thirtieth of the time that launching
its kernels one by one takes. Nothing in a step waits for the device.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from collections.abc import Callable
from functools import partial, reduce
from operator import or_
from typing import Any, cast

import torch

from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError, require
from slider.env.disturbance import Disturbance, DisturbanceModel, build_plant
from slider.env.randomization import VARIED_FIELDS, Fields, vary
from slider.env.state import SPEED_LIMIT, RobotState, SensorIndex, read_state
from slider.robot.mjcf import SimulationOptions, nominal_qpos
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
# Solver and line search stop at their iteration limits, as MuJoCo's own do, without a warning.
_LIMITS = mjw.OverflowType.ITERATIONS | mjw.OverflowType.LS_ITERATIONS


class WarpPhysics:
    """Steps ``num_robots`` robots with servos on flat ground, disturbed as in ``BatchedPhysics``.

    Evaluation needs contacts and loads of every simulation step and runs on MuJoCo itself. The
    kernels are compiled, which takes half a minute unless Warp's cache has them.

    Args:
        device: its name in Warp and torch, such as ``cpu`` or ``cuda:0``.
    Other arguments are those of ``BatchedPhysics``.

    Attributes:
        qpos, qvel: (N, 19), (N, 18) positions and velocities, shared with the simulation.
        model: of the nominal robot.
        device: device of the tensors.
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
    ) -> None:
        options = SimulationOptions.of(config)
        self.robot, self.num_robots = robot, num_robots
        self.period = config.substeps * config.timestep
        self.model = build_plant(robot, options, None)
        varied = disturbance is not None and vary(disturbance.config)
        self._warp_device = _device(device)
        self.device = torch.device(wp.device_to_torch(self._warp_device))
        sizes = dict.fromkeys((*VARIED_FIELDS, *_DERIVED), num_robots) if varied else {}
        with wp.ScopedDevice(self._warp_device):
            self._models = mjw.put_model(self.model, sizes)
            self._models.opt.warn_overflow = 0  # see check
            self._data = mjw.make_data(self.model, num_robots, nconmax=CONTACTS, njmax=ROWS)
            control = wp.zeros((config.substeps, num_robots, self.model.nu), dtype=float)
        self._inputs = [control[i] for i in range(config.substeps)]
        self._control = wp.to_torch(control)  # (steps, N, inputs)
        self.qpos, self.qvel = wp.to_torch(self._data.qpos), wp.to_torch(self._data.qvel)
        self._applied = wp.to_torch(self._data.qfrc_applied)
        self._sensors = wp.to_torch(self._data.sensordata)  # one simulation step older
        self._overflow = wp.to_torch(self._data.overflow)
        self._advance = self._graph(self._simulate)
        groups = mjw.SetConstGroup.FIXED | mjw.SetConstGroup.INERT0
        derive = partial(mjw.set_const, self._models, self._data, groups, restore=False)
        self._derive = self._graph(derive) if varied else None
        self._overflow.zero_()
        self._index: Any = SensorIndex(self.model)
        for name, columns in vars(self._index).items():  # a list would be copied to the device
            setattr(self._index, name, torch.tensor(columns, device=self.device))
        self._to_motors = self._tensor(Transmission.of(robot).matrix.T)
        self._rest = self._tensor(nominal_qpos(robot))
        self._diverged = torch.zeros(num_robots, dtype=torch.bool, device=self.device)
        self._disturber: Any = None  # its arrays are tensors
        if disturbance is not None:
            write = self.set_fields if varied else None
            self._disturber = DisturbanceModel(
                disturbance, robot, self.model, "position", num_robots, write, self.qpos
            )
        self._place_at_rest(torch.ones_like(self._diverged))

    def _simulate(self) -> None:
        # MuJoCo's rollout keeps no warm start between control steps either.
        self._data.qacc_warmstart.zero_()
        for inputs in self._inputs:
            wp.copy(self._data.ctrl, cast(wp.array, inputs))
            mjw.step(self._models, self._data)

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
        """A varied field of the robots' models (N, ...)."""
        return wp.to_torch(getattr(self._models, name))

    def set_fields(self, index: torch.Tensor, fields: Fields) -> None:
        """Write fields (n, ...) of the models of robots (n,), and update derived constants.

        This is what ``mj_setConst`` does for MuJoCo.
        """
        for name, values in fields.items():
            self.field(name)[index] = values
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
        bits = (self._overflow & ~int(_LIMITS)).cpu().tolist()
        self._overflow.zero_()
        robots = [robot for robot, kinds in enumerate(bits) if kinds]
        kinds = mjw.OverflowType(reduce(or_, bits))
        names = ", ".join(map(str, robots[:8])) + ", …" * (len(robots) > 8)
        found = f"{kinds.name} of {len(robots)} of {len(bits)} robots: {names}"
        require(not robots, "MuJoCo Warp", "no overflow", found)

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
