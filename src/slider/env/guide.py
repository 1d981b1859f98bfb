"""The gait library as a guide: the reference at a phase, or the nearest sample."""

import numpy as np

from slider.env.view import View
from slider.library.lookup import GaitTable
from slider.library.reader import GaitLibrary
from slider.robot.names import CHANNELS, JOINTS, NUM_CHANNELS, NUM_JOINTS, SIDES

_PASSIVE = np.array([("upper_foot" in name) for name in CHANNELS])
_HIP_YAWS = [JOINTS.index(f"{side}_hip_yaw") for side in SIDES]


def observed_channels(view: View) -> np.ndarray:
    """Ô of eq. 3: joint positions, joint velocities, forward and leftward velocity (N, 26)."""
    state = view.state
    return np.concatenate(
        [state.joint_positions, state.joint_velocities, state.heading_velocity], axis=1
    )


class Guide:
    """Reference samples for N robots.

    The gait in use follows the reference velocity: ``interpolated`` between those of the library,
    or the ``nearest`` of them. Within it the sample follows the clock (``at_phase``) or the state
    (``nearest_distance``).
    """

    def __init__(self, library: GaitLibrary, table: GaitTable, gait: str = "interpolated") -> None:
        self._library = library
        self._table = table
        self._nearest = gait == "nearest"
        samples = library.samples.astype(np.float32)
        self._samples = samples
        self._active = ~_PASSIVE
        self._norms = {
            False: (samples**2).sum(axis=2),
            True: (samples[:, :, self._active] ** 2).sum(axis=2),
        }

    def at_phase(self, view: View) -> np.ndarray:
        """Reference at the clock's phase: channels and base motion (N, 26 + 13).

        Where the clock is halted: standing on both feet, at rest.
        """
        command = view.reference_command
        if self._nearest:
            command = self._library.commands[self._library.nearest(command)]
        reference = self._table.at(command, view.phase)
        if view.halted.any():
            reference[view.halted] = self._table.standing
        return reference

    def turn(self, view: View) -> np.ndarray:
        """What a commanded yaw rate adds to the joints of the gait (N, 12) [rad].

        A library of gaits that turn has the yaw rate, or a part of it, in the gait itself. The
        stance foot stays while the base turns over it, so that the stance hip's yaw goes from
        +ψ̇ T/2 to −ψ̇ T/2 in a step of duration T; the swing leg goes back for the next step.
        """
        command, times = view.reference_command, self._table.times
        progress = (2.0 * view.phase) % 1.0
        missing = command[:, 2] - times.inside(command)[:, 2]
        stance = missing * times.at(command) * (0.5 - progress)
        left = np.where(view.phase < 0.5, stance, -stance)
        result = np.zeros((len(left), NUM_JOINTS))
        result[:, _HIP_YAWS] = np.stack([left, -left], axis=1)
        return result

    def states(self, command: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Physics states on the gaits: positions (n, 19) at x = y = 0, velocities (n, 18).

        A start has the commanded velocity, whichever gait guides: it is interpolated.
        """
        reference = self._table.at(command, phase)
        joints, base = reference[:, : 2 * NUM_JOINTS], reference[:, NUM_CHANNELS:]
        qpos = np.concatenate([base[:, :7], joints[:, :NUM_JOINTS]], axis=1)
        qpos[:, :2] = 0.0
        return qpos, np.concatenate([base[:, 7:13], joints[:, NUM_JOINTS:]], axis=1)

    def course(self, command: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Heading (n,) [rad] of the walks of :meth:`states`; their bases' yaw swings about it."""
        times = self._table.times
        return times.inside(command)[:, 2] * times.at(command) * (2.0 * phase - 0.5)

    def nearest_distance(self, view: View, masked: bool) -> np.ndarray:
        """‖Ô − Ĝ‖ (N,) to the nearest sample of the gait in use (eq. 3: the nearest gait).

        Args:
            view: N robots.
            masked: leave the passive channels out.
        """
        observed = observed_channels(view).astype(np.float32)
        samples, norms = self._samples_for(view, masked)
        if masked:
            observed, samples = observed[:, self._active], samples[:, :, self._active]
        # ‖o − g‖² = ‖o‖² − 2 o·g + ‖g‖², which needs no (N, 42, 26) difference.
        product = np.einsum("nk,nsk->ns", observed, samples)
        square = (observed**2).sum(axis=1)[:, None] - 2.0 * product + norms
        return np.sqrt(np.maximum(square.min(axis=1), 0.0)).astype(np.float64)

    def _samples_for(self, view: View, masked: bool) -> tuple[np.ndarray, np.ndarray]:
        """Samples (N, S, 26) of the robots' gaits and their squared norms (N, S)."""
        command = view.reference_command
        if self._nearest:
            gait = self._library.nearest(command)
            return self._samples[gait], self._norms[masked][gait]
        samples = self._table.channels(command).astype(np.float32)
        counted = samples[:, :, self._active] if masked else samples
        return samples, (counted**2).sum(axis=2)
