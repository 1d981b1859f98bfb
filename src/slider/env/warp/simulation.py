"""Many copies of a MuJoCo model on a device, as torch tensors that share Warp's memory.

A control step is one graph: CUDA runs it without the host, and Warp's CPU device replays it in a
thirtieth of the time that launching its kernels one by one takes.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from collections.abc import Callable, Collection
from typing import cast

import mujoco
import torch

from slider.core.errors import UserError

try:
    import mujoco_warp as mjw
    import warp as wp
except ModuleNotFoundError as error:
    found = "expected MuJoCo Warp, found none: pip install -e '.[gpu]' -c constraints.txt"
    raise UserError(found) from error

CONTACTS = 16  # per robot, on average over all: a robot that stands has 4
ROWS = 64  # of constraints per robot: 16 in stance, 26 where robots lie on the ground and kick
_DERIVED = ("body_subtreemass", "body_invweight0", "dof_invweight0", "tendon_invweight0")
# Solver and line search stop at their limit as MuJoCo's own do, which says nothing either.
_LIMITS = mjw.OverflowType.ITERATIONS | mjw.OverflowType.LS_ITERATIONS


class Simulation:
    """``count`` copies of ``model``, stepped together.

    Attributes:
        qpos, qvel: (N, nq), (N, nv) generalised positions and velocities.
        sensors: (N, sensors), one simulation step older.
        control: (steps, N, inputs), what the next :meth:`step` applies in each simulation step.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        count: int,
        steps: int,
        device: str = "cpu",
        varied: Collection[str] = (),
        rows: int = ROWS,
    ) -> None:
        """Compile the kernels, which takes half a minute unless the cache has them.

        Args:
            model: of all robots.
            count: number of robots N.
            steps: simulation steps in a control step.
            device: Warp's and torch's name of it, such as ``cpu`` or ``cuda:0``.
            varied: fields of the model that robots have of their own; see :meth:`field`.
            rows: of constraints that a robot may have.
        """
        self._device = _device(device)
        self._torch = torch.device(wp.device_to_torch(self._device))
        sizes = dict.fromkeys((*varied, *_DERIVED), count) if varied else {}
        with wp.ScopedDevice(self._device):
            self._model = mjw.put_model(model, sizes)
            self._model.opt.warn_overflow = 0  # see check
            self._data = mjw.make_data(model, count, nconmax=CONTACTS, njmax=rows)
            control = wp.zeros((steps, count, model.nu), dtype=float)
        self._inputs = [control[i] for i in range(steps)]
        self.control = wp.to_torch(control)
        self.qpos, self.qvel = wp.to_torch(self._data.qpos), wp.to_torch(self._data.qvel)
        self.sensors = wp.to_torch(self._data.sensordata)
        self._overflow = wp.to_torch(self._data.overflow)
        self._advance = self._graph(self._simulate)
        self._derive = self._graph(self._set_constants) if varied else None
        self.sensors.zero_()
        self._overflow.zero_()

    @property
    def device(self) -> torch.device:
        """Where the tensors are."""
        return self._torch

    def field(self, name: str) -> torch.Tensor:
        """A ``varied`` field of the model (N, ...); call :meth:`derive` after a change."""
        return wp.to_torch(getattr(self._model, name))

    def step(self) -> None:
        """Simulate one control step."""
        self._launch(self._advance)

    def derive(self) -> None:
        """Make what follows from varied masses and inertias follow, as ``mj_setConst`` does."""
        assert self._derive is not None, "nothing is varied"
        self._launch(self._derive)

    def clear_errors(self, robots: torch.Tensor) -> None:
        """Forget the overflows of ``robots`` (N,), which blew up."""
        self._overflow.masked_fill_(robots, 0)

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

    def _simulate(self) -> None:
        # MuJoCo's rollout keeps no warm start between control steps either.
        self._data.qacc_warmstart.zero_()
        for inputs in self._inputs:
            wp.copy(self._data.ctrl, cast(wp.array, inputs))
            mjw.step(self._model, self._data)

    def _set_constants(self) -> None:
        groups = mjw.SetConstGroup.FIXED | mjw.SetConstGroup.INERT0
        mjw.set_const(self._model, self._data, groups, restore=False)

    def _graph(self, work: Callable[[], None]) -> "wp.Graph":
        with wp.ScopedDevice(self._device):
            work()  # loads the kernels
            with wp.ScopedCapture() as capture:
                work()
            wp.synchronize_device()
        return cast(wp.Graph, capture.graph)

    def _launch(self, graph: "wp.Graph") -> None:
        """Run a graph in the order of torch's own work on the device."""
        stream = wp.stream_from_torch(self._torch) if self._device.is_cuda else None
        wp.capture_launch(graph, stream)


def _device(name: str) -> "wp.Device":
    wp.config.log_level = wp.LOG_WARNING
    wp.init()
    try:
        return wp.get_device(name)
    except ValueError as error:
        known = ", ".join(str(device) for device in wp.get_devices())
        raise UserError(f"device: expected one that Warp finds ({known}), found {name}") from error
