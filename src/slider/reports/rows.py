"""Rows of the reports' tables: names to numbers, NaN where there is none, and texts."""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np
import pandas as pd

from slider.evaluation.results import ERRORS, QUALITY, Evaluation
from slider.library.blend import GaitNumbers, gait_numbers
from slider.library.reader import STORE, GaitLibrary
from slider.reports.quantities import OURS

NAN = float("nan")
NAMED = ("controller", "label")
Row = dict[str, Any]
Reference = Callable[[float], GaitNumbers | None]


def write(rows: Sequence[Row], path: Path, columns: Sequence[str] = ()) -> None:
    """Write CSV, by default the columns of the first row; numbers keep 6 digits."""
    names = list(columns or rows[0])
    frame = pd.DataFrame.from_records(rows, columns=names)
    frame.to_csv(path, index=False, float_format="%.6g", lineterminator="\n")


def read(file: Path | IO[str]) -> list[Row]:
    """Rows of a published table: numbers, NaN for empty cells, and texts."""
    frame = pd.read_csv(file, keep_default_na=False, na_values=[""], float_precision="round_trip")
    return frame.to_dict("records")


def by(rows: Iterable[Row], *names: str) -> dict[Any, list[Row]]:
    """Rows by one of their values, or by several, in the order of the rows."""
    groups: dict[Hashable, list[Row]] = {}
    for row in rows:
        key = tuple(row[name] for name in names)
        groups.setdefault(key if len(names) > 1 else key[0], []).append(row)
    return groups


def distinct(rows: Iterable[Row], name: str) -> list[float]:
    """Different numbers of a column, ascending."""
    return sorted({row[name] for row in rows})


def evaluations(folders: Iterable[Path], labels: Mapping[str, str]) -> list[Evaluation]:
    """Evaluations in folders, each with its controller's label."""
    loaded = map(Evaluation.load, folders)
    return [replace(result, label=labels[result.controller]) for result in loaded]


def table_row(evaluation: Evaluation) -> Row:
    """Success, tracking and errors; spreads are standard deviations over trials."""
    row = named(evaluation) | {"source": OURS, "speed": evaluation.speed}
    return row | evaluation.robots.success() | evaluation.robots.accuracy()


def named(evaluation: Evaluation) -> Row:
    """Controller and label of a row."""
    return dict(zip(NAMED, (evaluation.controller, evaluation.label), strict=True))


def quality_row(evaluation: Evaluation, reference: Reference | None = None) -> Row:
    """How the robots that survive walk; NaN where none survived.

    Means over robots, but for extremes, which are those of all robots: ``penetration_max``,
    ``peak_effort``, ``peak_speed`` (largest) and ``leg_distance`` (least). ``heading`` is the mean
    of the robots' largest errors, ``heading_worst`` the largest of all. ``robots_touch`` and
    ``robots_cross`` are the shares of robots whose legs ever touch or cross. Given a ``reference``,
    the gait's own numbers are beside the controller's, as ``reference_NAME``; NaN without one.
    """
    row = named(evaluation) | {"speed": evaluation.speed}
    gait = reference(evaluation.speed) if reference and evaluation.speed is not None else None
    for name in ("mean_velocity", *QUALITY, *ERRORS):
        values = evaluation.robots.survivors(name)
        for column, number in _COLUMNS.get(name, {name: np.mean}).items():
            row[column] = float(number(values)) if len(values) else NAN
            if reference and column in GaitNumbers._fields:
                row[f"reference_{column}"] = NAN if gait is None else getattr(gait, column)
    return row


def _ever(shares: np.ndarray) -> float:
    """Share of robots with some of what these are shares of time of."""
    return float(np.mean(shares > 0))


# Quantity of a robot → columns, and how its values over robots become their number.
_COLUMNS: Mapping[str, Mapping[str, Callable[[np.ndarray], float]]] = {
    "heading": {"heading": np.mean, "heading_worst": np.max},
    "penetration_max": {"penetration_max": np.max},
    "peak_effort": {"peak_effort": np.max},
    "peak_speed": {"peak_speed": np.max},
    "leg_distance": {"leg_distance": np.min},
    "legs_touch": {"legs_touch": np.mean, "robots_touch": _ever},
    "legs_cross": {"legs_cross": np.mean, "robots_cross": _ever},
}


def reference_gaits(folders: Sequence[Path]) -> Reference:
    """Forward velocity → numbers of the gait of the library in the only folder, if there is one."""
    if not folders:
        return lambda speed: None
    library = GaitLibrary.load(folders[0] / STORE)
    return lambda speed: gait_numbers(library, speed)
