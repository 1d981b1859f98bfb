"""Typed settings of the seeds that evaluations draw from: what is reported, what is chosen by."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class SeedBlock:
    """Consecutive seeds, ``first`` and ``last`` included."""

    first: int
    last: int

    def __contains__(self, seed: int) -> bool:
        return self.first <= seed <= self.last

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


@dataclass(frozen=True, config=STRICT)
class SeedsConfig:
    """Blocks of seeds that are held apart, and the seed of ``development`` that checks use.

    Nothing is chosen by results from ``final``; reported numbers are.
    """

    final: SeedBlock
    development: SeedBlock
    selection: int
