"""Forecast of a job's duration: proportional to its size, at the rate of earlier jobs of its kind.

For a kind that this store has not computed yet, the rate is that of a table in the package.
"""

import csv
import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from importlib.resources import files as package_files

from slider.artefacts.plan import JobSpec
from slider.artefacts.store import Store
from slider.core.files import flatten

START = 0.7
"""Seconds from Snakemake's decision to the first line of a job: a Python process."""
TABLE = "times.csv"
_UNKNOWN = 5.0  # seconds of a job of an unknown kind
_TRAINING = ("train.robots", "train.steps_per_iteration", "train.iterations")
_EVALUATION = ("evaluation.trials", "evaluation.robots", "evaluation.duration")
_GAUGE = tuple(f"protocol.{name}" for name in ("trials", "speeds", "robots", "duration"))
_FACTORS = {
    **dict.fromkeys(("gait", "gait_start"), ("formulation.nodes",)),
    **dict.fromkeys(("stability_gaits", "verification_gaits"), ("velocities",)),
    **dict.fromkeys(("standing", "walking"), _TRAINING),
    **dict.fromkeys(("evaluation", "baseline", "drake_evaluation"), _EVALUATION),
    "gauge_axis": (*_GAUGE, "values", "directions"),
    "gait_walks": ("steps",),
    "video": ("video.duration",),
}
"""Stage → values of its section that its time is proportional to; a list counts by its length."""
Rates = Mapping[str, Sequence[float]]
"""Kind → seconds per size of its jobs."""


def kind(job: JobSpec) -> str:
    """Stage of a job, followed by the controller that it evaluates, if any."""
    return " ".join(filter(None, (job.stage, job.section.get("controller"))))


def size(job: JobSpec) -> float:
    """Product of the values that the time of a job is proportional to."""
    values = flatten(job.section)
    found = (values.get(key) for key in _FACTORS.get(job.stage, ()))
    factors = (len(value) if isinstance(value, list) else value for value in found)
    return math.prod(factor for factor in factors if isinstance(factor, int | float))


def computed(store: Store, stages: Iterable[str]) -> dict[str, list[tuple[float, float]]]:
    """CPU time [s] and time per size of the computed jobs of some stages, by kind."""
    jobs: dict[str, list[tuple[float, float]]] = {}
    for stage in stages:
        for path in store.root.glob(f"{stage}/*.run.json"):
            with suppress(KeyError, TypeError):
                metadata = store.metadata(stage, path.name.partition(".")[0])
                if metadata["computed"] and metadata["size"]:
                    spent = metadata["cpu_s"]
                    rate = min(metadata["wall_s"], spent) / metadata["size"]
                    jobs.setdefault(metadata["kind"], []).append((spent, rate))
    return jobs


def known_rates(store: Store, stages: Iterable[str]) -> Rates:
    """Times per size [s] of the jobs of some stages, by kind.

    A kind without computed jobs has the rate of the table that ``slider store times`` writes.
    """
    with package_files("slider.artefacts").joinpath(TABLE).open(encoding="utf-8") as file:
        rates = {row["kind"]: [float(row["rate"])] for row in csv.DictReader(file)}
    jobs = computed(store, stages)
    return rates | {kind: [rate for _, rate in earlier] for kind, earlier in jobs.items()}


def expected(job: JobSpec, rates: Rates) -> float:
    """Expected wall time of a job [s], including the start of its process."""
    earlier = rates.get(kind(job))
    return START + (statistics.median(earlier) * size(job) if earlier else _UNKNOWN)
