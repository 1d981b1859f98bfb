"""Results of evaluations: the files of a folder, read and written only here, and statistics."""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from slider.core import tables
from slider.env.metrics import ERRORS, QUALITY, TRACKING, Columns
from slider.library.blend import GaitStatistics, gait_statistics
from slider.library.reader import STORE, GaitLibrary

METADATA, ROBOTS, VELOCITY = "metadata.json", "robots.csv", "velocity.npy"
SEGMENTS, TRACES = "segments.csv", "traces.npy"
COLUMNS = ("trial", "robot", *TRACKING, *QUALITY, *ERRORS, "diverged")
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
class Evaluation:
    """All robots of one controller at one command, or in one case of a profile.

    Attributes:
        speed: commanded forward velocity [m/s]; None in a case.
        robots: a row per robot with ``COLUMNS``; NaN where it fell.
        velocity: (S, 2) mean and standard deviation over survivors of the forward velocity [m/s].
        segments: in a case a row per segment and robot with ``SEGMENT_COLUMNS``; ``survived`` is
            true for robots that were up until its end, even if they fell later.
        traces: in a case (S, 10), see :func:`slider.evaluation.segments.traces`.
        label: display name of the controller; not in the folder, since nothing depends on it.
    """

    controller: str
    speed: float | None
    robots: pd.DataFrame
    velocity: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.float32))
    case: str = ""
    segments: pd.DataFrame | None = None
    traces: np.ndarray | None = None
    label: str = ""

    def save(self, folder: Path) -> None:
        """Write the files of a folder."""
        metadata = {"controller": self.controller, "speed": self.speed}
        if self.case:
            metadata["case"] = self.case
        (folder / METADATA).write_text(json.dumps(metadata) + "\n", encoding="utf-8")
        tables.write(self.robots, folder / ROBOTS, digits=9)
        np.save(folder / VELOCITY, self.velocity)
        if self.segments is not None:
            tables.write(self.segments, folder / SEGMENTS, digits=9)
        if self.traces is not None:
            np.save(folder / TRACES, self.traces)

    @classmethod
    def load(cls, folder: Path, labels: Mapping[str, str] | None = None) -> "Evaluation":
        """Read the files of a folder back; ``labels`` of controllers, if known.

        Raises:
            UserError: a table has other columns.
        """
        about = json.loads((folder / METADATA).read_text(encoding="utf-8"))
        controller, segments = about["controller"], folder / SEGMENTS
        return cls(
            controller,
            about["speed"],
            tables.read(folder / ROBOTS, COLUMNS, ("survived", "tracked", "diverged")),
            np.load(folder / VELOCITY),
            about.get("case", ""),
            tables.read(segments, SEGMENT_COLUMNS, ("survived",)) if segments.is_file() else None,
            np.load(folder / TRACES) if (folder / TRACES).is_file() else None,
            labels[controller] if labels else "",
        )


def robots_frame(trials: int, count: int, metrics: Columns) -> pd.DataFrame:
    """Rows with the metrics of robots, which are ordered by trial."""
    return pd.DataFrame(places(trials, count) | metrics)[[*COLUMNS]]


def places(trials: int, count: int) -> dict[str, np.ndarray]:
    """Columns ``trial`` and ``robot``, its number within the trial."""
    trial, robot = np.divmod(np.arange(trials * count), count)
    return {"trial": trial, "robot": robot}


def compare(evaluations: Iterable[Evaluation], library: Sequence[Path] = ()) -> pd.DataFrame:
    """A row per evaluation: ``controller``, ``speed``, success, accuracy and quality.

    With the folder of a library also the statistics of its gait at that speed, as columns
    ``reference_NAME``.
    """
    gaits = GaitLibrary.load(library[0] / STORE) if library else None
    rows = []
    for one in evaluations:
        gait = None if gaits is None or one.speed is None else gait_statistics(gaits, one.speed)
        row = {"controller": one.controller, "speed": one.speed}
        rows.append(row | success(one.robots) | accuracy(one.robots) | quality(one.robots, gait))
    return pd.DataFrame(rows)


def success(robots: pd.DataFrame) -> dict[str, float]:
    """Share that did not fall (:mod:`slider.env.terminations`), spread, Wilson's 95 % interval."""
    low, high = wilson(int(robots["survived"].sum()), len(robots))
    rate = _mean("success_rate", robots, "survived")
    return rate | {"success_low": low, "success_high": high}


def accuracy(robots: pd.DataFrame) -> dict[str, float]:
    """Share that tracks the command; mean squared velocity errors of survivors [m²/s²].

    ``mse`` counts the start, ``mse_steady`` begins after the warm-up. Both are infinite where none
    survived, as in the paper.
    """
    alive = robots[robots["survived"]]
    return (
        _mean("tracking_rate", robots, "tracked")
        | _mean("mse", alive, "squared_error")
        | _mean("mse_steady", alive, "squared_error_steady")
    )


def _mean(name: str, robots: pd.DataFrame, column: str) -> dict[str, float]:
    """A mean over robots, and as ``NAME_std`` the standard deviation of the trials' means.

    The latter is NaN for fewer than two trials.
    """
    values = robots[column].to_numpy(float)
    mean = float(values.mean()) if len(values) else math.inf
    means = robots.groupby("trial")[column].mean().to_numpy()
    return {name: mean, f"{name}_std": float(np.std(means, ddof=1)) if len(means) > 1 else math.nan}


def quality(robots: pd.DataFrame, gait: GaitStatistics | None = None) -> dict[str, float]:
    """Gait quality of the robots that survive, and statistics of a ``gait``; NaN if none survived.

    Means over robots, except for the extremes over all robots: ``penetration_max``,
    ``peak_effort``, ``peak_speed`` (largest) and ``leg_distance`` (least). ``heading`` is the mean
    of the robots' largest errors, ``heading_worst`` the largest of all. ``robots_touch`` and
    ``robots_cross`` are the shares of robots whose legs ever touch or cross.
    """
    row, alive = {}, robots[robots["survived"]]
    for name in ("mean_velocity", *QUALITY, *ERRORS):
        for column, number in _NUMBERS.get(name, {name: np.mean}).items():
            row[column] = float(number(alive[name].to_numpy())) if len(alive) else math.nan
            if column in GaitStatistics._fields:
                row[f"reference_{column}"] = math.nan if gait is None else getattr(gait, column)
    return row


def means(robots: pd.DataFrame, names: Sequence[str]) -> dict[str, float]:
    """Means of columns over survivors; NaN without any."""
    return robots.loc[robots["survived"], [*names]].mean().to_dict()


def _ever(shares: np.ndarray) -> float:
    """Share of robots for which something occurs at all: a share of time above zero."""
    return float(np.mean(shares > 0))


# Quantity of a robot → columns, each with its statistic over robots.
_NUMBERS: Mapping[str, Mapping[str, Callable[[np.ndarray], float]]] = {
    "heading": {"heading": np.mean, "heading_worst": np.max},
    "penetration_max": {"penetration_max": np.max},
    "peak_effort": {"peak_effort": np.max},
    "peak_speed": {"peak_speed": np.max},
    "leg_distance": {"leg_distance": np.min},
    "legs_touch": {"legs_touch": np.mean, "robots_touch": _ever},
    "legs_cross": {"legs_cross": np.mean, "robots_cross": _ever},
}


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of the probability behind ``successes`` out of ``count``.

    Its ends are the p with |successes / count − p| = z √(p (1 − p) / count), z being ``Z``
    (E. B. Wilson, 1927). The draws are assumed to be independent.

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
