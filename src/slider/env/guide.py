"""The gait library as a guide: the reference at a phase, or the nearest sample."""

import numpy as np
import torch

from slider.config.robot import Geometry
from slider.core.arrays import Array, tensors
from slider.env.height_field import adapt_to_terrain
from slider.env.interface import FLOAT64
from slider.env.state import View
from slider.library.lookup import GaitTable
from slider.library.reader import GaitLibrary
from slider.robot.names import LAST_JOINTS, LEG_SIZE, NUM_CHANNELS, NUM_JOINTS, SIDES

_WEIGHTS = {
    **{"hip_yaw": 2.0, "hip_roll": 2.0, "hip_pitch": 1.0},
    **{"slide": 40.0, "ankle": 0.5, "ankle_roll": 0.5},
}
_KNEE_WEIGHT = 1.0
_ACTIVE = np.setdiff1d(np.arange(NUM_CHANNELS), [*LAST_JOINTS, *np.add(LAST_JOINTS, NUM_JOINTS)])


def joint_weights(geometry: Geometry) -> np.ndarray:
    """Weights (12,) of squared deviations from the guide [1/rad² or 1/m²].

    A slide's metre counts as several radians. Passive joints have weight 0.
    """
    knee = {} if geometry.knee is None else {"slide": _KNEE_WEIGHT}
    weights = [(_WEIGHTS | knee).get(name, 0.0) for name in geometry.leg_joints]
    return np.array(weights * len(SIDES))


def observed_channels(view: View) -> Array:
    """Ô of eq. 3: joint positions, joint velocities, forward and leftward velocity (N, 26)."""
    state = view.state
    return torch.cat([state.joint_positions, state.joint_velocities, state.heading_velocity], dim=1)


class Guide:
    """Reference samples for N robots; ``weights`` (12,) multiply squared joint errors.

    The gait in use follows the reference velocity: ``interpolated`` between those of the library,
    or the ``nearest`` of them. Within it the sample follows the clock (``at_phase``) or the state
    (``nearest_distance``).
    """

    def __init__(
        self,
        library: GaitLibrary,
        table: GaitTable,
        geometry: Geometry,
        gait: str = "interpolated",
        like: torch.Tensor = FLOAT64,
    ) -> None:
        self._library, self._arrays, self._nearest = library, table, gait == "nearest"
        self._gait, self._like, self._geometry = gait, like, geometry
        self.weights = like.new_tensor(joint_weights(geometry))
        self._table = tensors(table, like)
        samples = library.arrays["samples"]
        self._samples = torch.asarray(samples, dtype=torch.float32, device=like.device)
        self._active = torch.asarray(_ACTIVE, device=like.device)
        self._velocities = torch.asarray(library.velocities, dtype=like.dtype, device=like.device)
        self._norms = {
            False: (self._samples**2).sum(dim=2),
            True: (self._samples[:, :, self._active] ** 2).sum(dim=2),
        }

    def on(self, like: torch.Tensor) -> "Guide":
        """The same guide in the precision and on the device of ``like``."""
        if (like.device, like.dtype) == (self._like.device, self._like.dtype):
            return self
        return Guide(self._library, self._arrays, self._geometry, self._gait, like)

    def at_phase(self, view: View) -> Array:
        """Reference at the clock's phase: channels and base motion (N, 26 + 13).

        Where the clock is halted: standing on both feet, at rest. On uneven ground the legs are
        adapted (:func:`slider.env.height_field.adapt_to_terrain`).
        """
        command = view.gait_velocity
        if self._nearest:
            command = self._velocities[self._nearest_gait(command)]
        reference = self._table.at(command, view.phase)
        reference = self._table.standing.where(view.halted[:, None], reference)
        state = view.state
        if not state.ground.flat:
            feet, joints = state.foot_positions[..., :2], reference[:, :NUM_JOINTS]
            change = adapt_to_terrain(state.ground, feet, state.yaw, self._geometry, joints)
            reference[:, :NUM_JOINTS] += change
        return reference

    def _nearest_gait(self, command: Array) -> Array:
        """Index (N,) of the gait nearest to each command (N, 3)."""
        away = command[:, None] - self._velocities
        return (away**2).sum(dim=2).argmin(dim=1)

    def turn(self, view: View) -> Array:
        """Joint offsets (N, 12) [rad] for the part of a commanded yaw rate that the gait lacks.

        In a library with turning gaits, the gait itself has all or part of the yaw rate. The
        base turns over the stance foot, so that the stance hip's yaw goes from +ψ̇ T/2 to −ψ̇ T/2
        in a step of duration T; the swing leg moves back for the next step.
        """
        command, times = view.gait_velocity, self._table.times
        progress = (2.0 * view.phase) % 1.0
        missing = command[:, 2] - times.inside(command)[:, 2]
        share = (0.5 - progress) / self._geometry.axes.yaw_direction[2]
        stance = missing * times.at(command) * share
        left = stance.where(view.phase < 0.5, -stance)
        result = left.new_zeros(len(left), NUM_JOINTS)
        yaw = self._geometry.leg_joints.index("hip_yaw")
        result[:, yaw], result[:, LEG_SIZE + yaw] = left, -left
        return result

    def states(self, command: Array, phase: Array) -> tuple[Array, Array]:
        """Physics states on the gaits: positions (n, 19) at x = y = 0, velocities (n, 18).

        They are interpolated at the commanded velocity, even if the guide is the nearest gait.
        """
        reference = self._table.at(command, phase)
        joints, base = reference[:, : 2 * NUM_JOINTS], reference[:, NUM_CHANNELS:]
        qpos = torch.cat([base[:, :7], joints[:, :NUM_JOINTS]], dim=1)
        qpos[:, :2] = 0.0
        return qpos, torch.cat([base[:, 7:13], joints[:, NUM_JOINTS:]], dim=1)

    def course(self, command: Array, phase: Array) -> Array:
        """Heading (n,) [rad] of the walks of :meth:`states`, about which the yaw oscillates."""
        times = self._table.times
        return times.inside(command)[:, 2] * times.at(command) * (2.0 * phase - 0.5)

    def nearest_distance(self, view: View, masked: bool) -> Array:
        """‖Ô − Ĝ‖ (N,) to the nearest sample of the gait in use (eq. 3: the nearest gait).

        ``masked`` omits the passive channels.
        """
        command = view.gait_velocity
        if self._nearest:
            gait = self._nearest_gait(command)
            samples, norms = self._samples[gait], self._norms[masked][gait]
        else:
            samples = self._table.channels(command).to(torch.float32)
            norms = ((samples[:, :, self._active] if masked else samples) ** 2).sum(dim=2)
        observed = observed_channels(view).to(torch.float32)
        if masked:
            observed, samples = observed[:, self._active], samples[:, :, self._active]
        # ‖o − g‖² = ‖o‖² − 2 o·g + ‖g‖², which needs no (N, 42, 26) difference.
        product = torch.einsum("nk,nsk->ns", observed, samples)
        square = (observed**2).sum(dim=1)[:, None] - 2.0 * product + norms
        return square.amin(dim=1).clip(min=0.0).sqrt().to(view.state.yaw.dtype)
