"""Checks 5 and 10: gaits of reflected commands, and of neighbouring commands."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider.robot.names import CHANNELS, MIRROR_PERMUTATION, MIRROR_SIGN, NUM_JOINTS
from slider.verification.stored import StoredGait

SPACING = 0.05  # jumps are per this change of the command [m/s, rad/s]
_SAME = 1e-9  # commands are rounded to 1e-10


@dataclass(frozen=True)
class Pair:
    """Two neighbouring gaits, by index, and the scaled jump between them per 0.05 m/s [-]."""

    first: int
    second: int
    samples: float
    coefficients: float


def mirror(gaits: Sequence[StoredGait]) -> list[dict[str, float]]:
    """Distance of each gait from the reflection of its partner; nothing without one.

    The partner's vy and yaw rate have the other sign.

    Two optima of nearly one cost may exist, so that the difference in cost is what counts.
    """
    found: list[dict[str, float]] = []
    for gait in gaits:
        image = gait.commands * [1.0, -1.0, -1.0]
        partner = next((g for g in gaits if _is_at(g, image)), None)
        found.append({} if partner is None else _distance(gait, partner))
    return found


def _is_at(gait: StoredGait, command: np.ndarray) -> bool:
    return bool(np.abs(gait.commands - command).max() < _SAME)


def _distance(gait: StoredGait, partner: StoredGait) -> dict[str, float]:
    jump = np.abs(gait.samples - reflected(partner.samples))[:, :NUM_JOINTS]
    mean = (gait.cost + partner.cost) / 2
    return {
        "mirror_distance": float(jump.max()),
        "mirror_cost": float(abs(gait.cost - partner.cost) / mean),
    }


def reflected(samples: np.ndarray) -> np.ndarray:
    """Samples (S, 26) as seen in the sagittal mirror, left stance first again."""
    order, sign = np.array(MIRROR_PERMUTATION), np.array(MIRROR_SIGN)
    position, velocity = samples[:, :NUM_JOINTS], samples[:, NUM_JOINTS : 2 * NUM_JOINTS]
    base = samples[:, 2 * NUM_JOINTS :] * [1.0, -1.0]
    image = np.concatenate([position[:, order] * sign, velocity[:, order] * sign, base], axis=1)
    return np.roll(image, len(samples) // 2, axis=0)


def smoothness(gaits: Sequence[StoredGait], reach: float) -> list[Pair]:
    """Jumps between neighbouring gaits, at most ``reach`` apart along an axis of the command.

    A channel's scale is its range over the whole library, that of a coefficient its joint's.
    """
    samples = np.stack([gait.samples for gait in gaits])
    coefficients = np.stack([gait.coefficients for gait in gaits])
    moving = np.array(["upper_foot" not in name for name in CHANNELS])
    channel = np.ptp(samples[..., moving], axis=(0, 1))
    joint = np.ptp(coefficients, axis=(0, 1, 3))[:, None]
    pairs = []
    for i, j in neighbours(np.stack([gait.commands for gait in gaits]), reach):
        per = SPACING / float(np.abs(gaits[i].commands - gaits[j].commands).sum())
        jump = (samples[i] - samples[j])[:, moving]
        bend = coefficients[i] - coefficients[j]
        pairs.append(Pair(i, j, per * _share(jump, channel), per * _share(bend, joint)))
    return pairs


def _share(jump: np.ndarray, scale: np.ndarray) -> float:
    """Greatest part of the range; a channel that never moves does not jump."""
    scale = np.broadcast_to(scale, jump.shape)
    moves = scale > 0
    return float((np.abs(jump[moves]) / scale[moves]).max()) if moves.any() else 0.0


def neighbours(commands: np.ndarray, reach: float) -> list[tuple[int, int]]:
    """Pairs of commands (G, 3) that differ in one component and have none between."""
    pairs = []
    for axis in range(commands.shape[1]):
        for i, command in enumerate(commands):
            away = commands[:, axis] - command[axis]
            beside = np.abs(np.delete(commands - command, axis, axis=1)).max(axis=1)
            ahead = (beside < _SAME) & (away > _SAME)
            if ahead.any():
                j = int(np.argmin(np.where(ahead, away, np.inf)))
                if away[j] <= reach + _SAME:
                    pairs.append((i, j))
    return pairs


def jumps_of(pairs: Sequence[Pair], index: int) -> dict[str, float]:
    """The greater jump to any neighbour of a gait; nothing where it has none."""
    own = [pair for pair in pairs if index in (pair.first, pair.second)]
    if not own:
        return {}
    return {
        "jump_samples": max(pair.samples for pair in own),
        "jump_coefficients": max(pair.coefficients for pair in own),
    }
