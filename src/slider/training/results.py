"""Results of a training, read from its folder."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from slider.core import columns
from slider.core.columns import Columns

SELECTION, CURVE = "selection.csv", "learning_curve.csv"
CHECKS = ("success", "speed_error", "flight", "value")


@dataclass(frozen=True)
class Training:
    """A finished training.

    Attributes:
        checks: ``iteration`` and ``CHECKS`` of the periodic evaluations, see
            :class:`slider.training.selection.Score`; NaN where no robot survived.
        curve: ``iteration`` and every recorded ``group/name``; empty where none were recorded.
    """

    checks: Columns
    curve: Columns

    @classmethod
    def load(cls, folder: Path) -> "Training":
        """Read the files of a folder; a check without any survivor leaves columns out."""
        checks = columns.read(folder / SELECTION)
        nothing = np.full(len(checks["iteration"]), np.nan)
        checks = {name: checks.get(name, nothing) for name in ("iteration", *CHECKS)}
        path = folder / CURVE
        return cls(checks, columns.read(path) if path.is_file() else {})

    @property
    def kept(self) -> int:
        """Iteration of the exported policy: the last one with the least score."""
        value = self.checks["value"]
        return int(self.checks["iteration"][np.flatnonzero(value == value.min())[-1]])
