"""How much the gait changes from one command to the next."""

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


def smoothness(commands: np.ndarray, samples: np.ndarray) -> Smoothness:
    """Measure the jumps between neighbours; a channel that never changes has none.

    Args:
        commands: (G, 3) vx, vy [m/s], yaw rate [rad/s].
        samples: (G, S, C) channels; each is divided by its range over all gaits and samples, so
            that 0.1 means a tenth of everything that this channel does in the whole library.
    """
    pairs = neighbours(commands)
    extent = np.ptp(samples, axis=(0, 1))
    scale = np.where(extent > 0, extent, np.inf)
    change = np.abs(samples[pairs[:, 1]] - samples[pairs[:, 0]]).max(axis=1)
    return Smoothness(pairs, change / scale)


def neighbours(commands: np.ndarray) -> np.ndarray:
    """Pairs (P, 2) of gaits that follow one another along one axis of the command.

    Between the two there is no further gait; a hole between them does not part them.
    """
    pairs = []
    for along, *fixed in ((0, 1, 2), (1, 0, 2), (2, 0, 1)):
        order = np.lexsort(commands.T[[along, *fixed]])
        same = (np.diff(commands[order][:, fixed], axis=0) == 0).all(axis=1)
        pairs.append(np.stack([order[:-1], order[1:]], axis=1)[same])
    return np.concatenate(pairs)
