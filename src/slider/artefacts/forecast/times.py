"""How long jobs will take: as earlier ones of their kind and size, or as in a table that ships."""

import csv
import math
import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.artefacts.store import Store
from slider.core import files
from slider.core.threads import duration

START = 0.7
"""Seconds from Snakemake's decision to the first line of a job: a Python process."""
TABLE = "times.csv"
_IMPORTS = 1.5  # seconds of a job that do not depend on its size
_UNKNOWN = 5.0  # seconds of a job of a kind that the table lacks
_LATEST = 64  # remembered jobs of a stage
_ALIKE = 2.0  # jobs whose sizes differ by no more than this factor are compared
_TRAINING = ("train.robots", "train.steps_per_iteration", "train.iterations")
_EVALUATION = ("evaluation.trials", "evaluation.robots", "evaluation.duration")
_FACTORS = {
    "gait": ("formulation.nodes",),
    "gait_start": ("formulation.nodes",),
    "stability_gaits": ("commands",),
    "return_maps": ("commands",),
    "verification_gaits": ("commands",),
    "standing": _TRAINING,
    "walking": _TRAINING,
    "evaluation": _EVALUATION,
    "baseline": _EVALUATION,
    "sensitivity_policy": _EVALUATION,
    "gait_walks": ("steps",),
    "video": ("video.duration",),
}
"""Stage → values of its section that its time is in proportion to; of a list, its length."""


def kind(job: JobSpec) -> str:
    """Jobs of a kind take equally long but for their size.

    It is the stage, who is evaluated, and the device of a training that uses no processor.
    """
    device = job.section.get("train", {}).get("device", "cpu")
    of_device = None if device == "cpu" else device
    return " ".join(filter(None, (job.stage, job.section.get("controller"), of_device)))


def size(job: JobSpec) -> float:
    """Product of the values that the time of a job is in proportion to."""
    return math.prod(_number(job.section, key) for key in _FACTORS.get(job.stage, ()))


def _number(section: Mapping[str, Any], key: str) -> float:
    value: Any = section
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    if isinstance(value, list):
        return len(value)
    return value if isinstance(value, int | float) else 1.0


@dataclass(frozen=True)
class Row:
    """Mean seconds of the jobs of a kind and size."""

    kind: str
    size: float
    seconds: float

    def scaled(self, size: float) -> float:
        """Seconds of a job of another size; imports take as long for a small one.

        A job without work, such as a training of no iteration, says nothing of larger ones.
        """
        if not self.size:
            return self.seconds
        fixed = min(self.seconds, _IMPORTS)
        return fixed + (self.seconds - fixed) * size / self.size


@dataclass(frozen=True)
class Times:
    """Remembered rows and those of the table that ships."""

    remembered: Iterable[Row]
    shipped: Iterable[Row]

    def seconds(self, job: JobSpec, threads: int = 1) -> float:
        """Expected wall time of a job [s], start of its process included."""
        return START + duration(threads) * self._seconds(kind(job), size(job))

    def _seconds(self, name: str, own: float) -> float:
        """Of a job of a kind and size on one thread."""
        alike = [
            row.scaled(own)
            for row in self.remembered
            if row.kind == name and own / _ALIKE <= row.size <= own * _ALIKE
        ]
        if alike:
            return statistics.median(alike)
        rows = [row for row in self.shipped if row.kind == name] or [
            row for row in self.shipped if row.kind.split()[0] == name.split()[0]
        ]
        found = [row.scaled(own) for row in rows]
        return statistics.fmean(found) if found else _UNKNOWN


def times(store: Store, stages: Iterable[str]) -> Times:
    """What the store remembers of the latest jobs of some stages, and the table that ships."""
    return Times([row for stage in stages for row in _remembered(store, stage)], shipped())


def _remembered(store: Store, stage: str) -> Iterable[Row]:
    """What one thread would take, by the wall time, or the processor time where that is less.

    Other programs' load is not ours, nor that of jobs which left a second thread no core.
    """
    paths = store.sidecar_path(stage, "*")
    found = [(path.stat().st_mtime, path) for path in paths.parent.glob(paths.name)]
    for _, path in sorted(found, reverse=True)[:_LATEST]:
        try:
            facts = files.read_json(path)
            if facts["computed"]:
                took = min(facts["wall_s"] / duration(facts["threads"]), facts["cpu_s"])
                yield Row(facts["kind"], facts["size"], took)
        except (OSError, ValueError, KeyError, TypeError):
            continue  # of an earlier version, or damaged: it is no input of anything


def mean_rows(rows: Iterable[Row]) -> list[Row]:
    """One row per kind, of its largest size, longest total first."""
    by: dict[str, list[Row]] = {}
    for row in rows:
        by.setdefault(row.kind, []).append(row)
    means = []
    for name, same in by.items():
        largest = max(row.size for row in same)
        of_size = [row.seconds for row in same if row.size == largest]
        means.append((sum(of_size), Row(name, largest, round(statistics.fmean(of_size), 2))))
    return [row for _, row in sorted(means, key=lambda pair: -pair[0])]


def write(rows: Iterable[Row], path: Path) -> None:
    """Write rows as the table that ships."""
    lines = [f"{row.kind},{row.size:g},{row.seconds:g}" for row in rows]
    files.write_atomic(path, "\n".join(["kind,size,seconds", *lines]) + "\n")


def shipped() -> list[Row]:
    """The table that ships with the package."""
    with package_files("slider.artefacts.forecast").joinpath(TABLE).open() as file:
        return [
            Row(row["kind"], float(row["size"]), float(row["seconds"]))
            for row in csv.DictReader(file)
        ]
