"""How much a policy may try around what it has learned."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NoiseBound:
    """Greatest standard deviation of the action noise over a training.

    Attributes:
        first, last: at the start and after the last update; between, geometric.
        start: share of the updates from which it falls.
        updates: of the training.
    """

    first: float
    last: float
    start: float
    updates: int

    def after(self, update: int) -> float:
        """The bound after so many updates."""
        begin = self.start * self.updates
        share = (update - begin) / max(self.updates - begin, 1.0)
        return self.first * (self.last / self.first) ** min(max(share, 0.0), 1.0)
