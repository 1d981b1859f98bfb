"""Results of an evaluation, and the files of its folder, read and written only here."""

import json
import math
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from slider.core import columns
from slider.core.columns import Columns
from slider.env.metrics import EstimateError, GaitQuality, Tracking

METADATA, ROBOTS, VELOCITY = "metadata.json", "robots.csv", "velocity.npy"
SEGMENTS, TRACES = "segments.csv", "traces.npy"
QUALITY = tuple(item.name for item in fields(GaitQuality))
ERRORS = tuple(item.name for item in fields(EstimateError))
COLUMNS = (
    *("trial", "robot", *(item.name for item in fields(Tracking)), *QUALITY, *ERRORS),
    "diverged",
)
AXES = ("vx", "vy", "yaw_rate")
# Of a robot in the settled part of a segment; NaN where it fell before the segment's end.
MEASURES = (
    *AXES,  # means [m/s, rad/s]
    *(f"{axis}_error" for axis in AXES),  # |mean − command| [m/s, rad/s]
    "vx_mse",  # mean of (vx − command)² [m²/s²]
    "heading_error",  # largest |yaw − commanded yaw| [rad]
    "touchdown_rate",  # of both feet [1/s]
    "displacement",  # of the base, from first to last moment [m]
    "fastest",  # largest |mean (vx, vy)| over any second of it [m/s]
)
Z = 1.959963984540054  # 97.5 % quantile of the normal distribution
SEGMENT_COLUMNS = ("trial", "robot", "segment", "survived", *MEASURES)


@dataclass(frozen=True)
class Robots:
    """Records of N robots in columns (N,): ``trial``, ``survived``, … ; NaN where a robot fell."""

    columns: Columns

    @property
    def survived(self) -> np.ndarray:
        """Whether a robot survived (N,)."""
        return self.columns["survived"]

    def survivors(self, name: str) -> np.ndarray:
        """A column of the robots that survived."""
        return self.columns[name][self.survived]

    def mean(self, name: str) -> float:
        """Mean of a column over survivors; NaN without any."""
        values = self.survivors(name)
        return float(values.mean()) if len(values) else float("nan")

    def success(self) -> dict[str, float]:
        """Share without a termination (``env.termination``), its spread, Wilson's 95 % interval."""
        low, high = wilson(int(self.survived.sum()), len(self.survived))
        row = self._mean("success_rate", "survived", slice(None))
        return row | {"success_low": low, "success_high": high}

    def accuracy(self) -> dict[str, float]:
        """Share that tracks the command; mean squared velocity errors of survivors [m²/s²].

        ``mse`` counts the start, ``mse_steady`` begins after the warm-up. Both are infinite where
        none survived, as in the paper.
        """
        return (
            self._mean("tracking_rate", "tracked", slice(None))
            | self._mean("mse", "squared_error", self.survived)
            | self._mean("mse_steady", "squared_error_steady", self.survived)
        )

    def _mean(self, name: str, column: str, robots: np.ndarray | slice) -> dict[str, float]:
        """A mean over robots, and as ``NAME_std`` the standard deviation of the trials' means.

        The latter is NaN for fewer than two trials.
        """
        values, trial = self.columns[column][robots], self.columns["trial"][robots]
        mean = float(values.mean()) if len(values) else float("inf")
        means = [values[trial == t].mean() for t in np.unique(trial)]
        spread = float(np.std(means, ddof=1)) if len(means) > 1 else float("nan")
        return {name: mean, f"{name}_std": spread}


@dataclass(frozen=True)
class Evaluation:
    """All robots of one controller at one command, or in one case of a profile.

    Attributes:
        speed: commanded forward velocity [m/s]; None in a case.
        robots: columns ``COLUMNS``.
        velocity: (S, 2) mean and standard deviation over survivors of the forward velocity [m/s].
        segments: in a case the robots of each segment, columns ``SEGMENT_COLUMNS``; ``survived``
            is true for robots that stood until its end, even if they fell later.
        traces: in a case (S, 10), see :func:`slider.evaluation.segments.traces`.
        label: display name of the controller; not in the folder, since nothing depends on it.
    """

    controller: str
    speed: float | None
    robots: Robots
    velocity: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.float32))
    case: str = ""
    segments: tuple[Robots, ...] = ()
    traces: np.ndarray | None = None
    label: str = ""

    def save(self, folder: Path) -> None:
        """Write the files of a folder."""
        metadata = {"controller": self.controller, "speed": self.speed}
        if self.case:
            metadata["case"] = self.case
        (folder / METADATA).write_text(json.dumps(metadata) + "\n", encoding="utf-8")
        columns.write(self.robots.columns, folder / ROBOTS)
        np.save(folder / VELOCITY, self.velocity)
        if self.segments:
            parts = [segment.columns for segment in self.segments]
            joined = {n: np.concatenate([part[n] for part in parts]) for n in SEGMENT_COLUMNS}
            columns.write(joined, folder / SEGMENTS)
        if self.traces is not None:
            np.save(folder / TRACES, self.traces)

    @classmethod
    def load(cls, folder: Path) -> "Evaluation":
        """Read the files of a folder back.

        Raises:
            UserError: a table has other columns.
        """
        metadata = json.loads((folder / METADATA).read_text(encoding="utf-8"))
        flags = ("survived", "tracked", "diverged")
        segments = ()
        if (folder / SEGMENTS).is_file():
            table = columns.read(folder / SEGMENTS, SEGMENT_COLUMNS, ("survived",))
            index = table["segment"]
            parts = [{n: v[index == i] for n, v in table.items()} for i in np.unique(index)]
            segments = tuple(map(Robots, parts))
        return cls(
            metadata["controller"],
            metadata["speed"],
            Robots(columns.read(folder / ROBOTS, COLUMNS, flags)),
            np.load(folder / VELOCITY),
            metadata.get("case", ""),
            segments,
            np.load(folder / TRACES) if (folder / TRACES).is_file() else None,
        )


def robots(
    trials: int, count: int, diverged: np.ndarray, *metrics: Tracking | GaitQuality | EstimateError
) -> Robots:
    """Robots from their metrics; those of a trial stand next to each other."""
    columns = places(trials, count)
    for one in metrics:
        columns |= vars(one)
    return Robots(columns | {"diverged": diverged})


def places(trials: int, count: int) -> Columns:
    """Columns ``trial`` and ``robot``, its number within the trial."""
    trial, robot = np.divmod(np.arange(trials * count), count)
    return {"trial": trial, "robot": robot}


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of the probability behind ``successes`` out of ``count``.

    Its ends are the p with |successes / count − p| = z √(p (1 − p) / count), z being ``Z``
    (E. B. Wilson, 1927). The draws are taken as independent.

    Raises:
        ValueError: the count is not positive, or smaller than the successes.
    """
    if not 0 <= successes <= count or count == 0:
        raise ValueError(f"expected 0 to {count} of at least 1, found {successes}")
    return _lower(successes, count), 1.0 - _lower(count - successes, count)


def _lower(successes: int, count: int) -> float:
    """Lower end; exactly 0 for no success."""
    spread = Z * math.sqrt(Z**2 + 4 * successes * (1 - successes / count))
    return (2 * successes + Z**2 - spread) / (2 * (count + Z**2))
