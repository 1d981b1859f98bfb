"""How much the gait changes from one velocity to the next."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Smoothness:
    """Jumps between neighbouring gaits, as shares of each channel's range over the library.

    Attributes:
        pairs: (P, 2) indices of neighbouring gaits.
        jumps: (P, C) greatest |difference| over the samples / range of the channel [-].
    """

    pairs: np.ndarray
    jumps: np.ndarray

    @property
    def largest(self) -> float:
        """Greatest jump of any pair and channel [-]; 0 where nothing has a neighbour."""
        return float(self.jumps.max(initial=0.0))

    @property
    def worst(self) -> tuple[int, int, int]:
        """First gait, second gait and channel of the greatest jump.

        Raises:
            ValueError: there are no neighbours.
        """
        if not len(self.pairs):
            raise ValueError("expected at least two neighbouring gaits, found none")
        pair, channel = np.unravel_index(self.jumps.argmax(), self.jumps.shape)
        first, second = self.pairs[pair]
        return int(first), int(second), int(channel)

    def per_gait(self, gaits: int) -> np.ndarray:
        """Greatest jump (G,) of each gait to any of its neighbours; 0 without one."""
        result = np.zeros(gaits)
        for pair, jump in zip(self.pairs, self.jumps.max(axis=1, initial=0.0), strict=True):
            result[pair] = np.maximum(result[pair], jump)
        return result


def smoothness(velocities: np.ndarray, samples: np.ndarray) -> Smoothness:
    """Measure the jumps between neighbours; a channel that never changes has none.

    Args:
        velocities: (G, 2) commanded vx, vy [m/s].
        samples: (G, S, C) channels; each is divided by its range over all gaits and samples, so
            that 0.1 means a tenth of everything that this channel does in the whole library.
    """
    pairs = neighbours(velocities)
    extent = np.ptp(samples, axis=(0, 1))
    scale = np.where(extent > 0, extent, np.inf)
    change = np.abs(samples[pairs[:, 1]] - samples[pairs[:, 0]]).max(axis=1)
    return Smoothness(pairs, change / scale)


def neighbours(velocities: np.ndarray) -> np.ndarray:
    """Pairs (P, 2) of gaits that follow one another in vx at one vy, or in vy at one vx.

    Between the two there is no further gait; a hole between them does not part them.
    """
    pairs = []
    for along, fixed in ((0, 1), (1, 0)):
        order = np.lexsort((velocities[:, along], velocities[:, fixed]))
        same = np.diff(velocities[order, fixed]) == 0
        pairs.append(np.stack([order[:-1], order[1:]], axis=1)[same])
    return np.concatenate(pairs)
