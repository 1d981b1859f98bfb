"""Results of a training, read from its folder."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from slider.core import tables

SELECTION, CURVE = "selection.csv", "learning_curve.csv"
CHECKS = ("success", "tracked", "speed_error", "flight", "value")


@dataclass(frozen=True)
class Training:
    """A finished training.

    Attributes:
        checks: ``iteration`` and ``CHECKS`` of the periodic evaluations, see
            :class:`slider.training.selection.Score`; NaN where no robot survived.
        curve: ``iteration`` and every recorded ``group/name``; empty where none were recorded.
    """

    checks: pd.DataFrame
    curve: pd.DataFrame

    @classmethod
    def load(cls, folder: Path) -> "Training":
        """Read the files of a folder; a check without any survivor leaves columns out."""
        checks = tables.read(folder / SELECTION).reindex(columns=["iteration", *CHECKS])
        path = folder / CURVE
        return cls(checks, tables.read(path) if path.is_file() else pd.DataFrame())

    @property
    def kept(self) -> int:
        """Iteration of the exported policy: the last one with the least score."""
        value = self.checks["value"]
        return int(self.checks["iteration"][value == value.min()].iloc[-1])
