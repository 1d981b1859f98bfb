"""Where it all comes from: commit, configuration, recipes, versions, seeds, machine, times."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import pandas as pd
import yaml

from slider.reports.table import Cell, Table, Text, grid

_TEXT = (
    "This page was built from commit `{commit}` (a + stands for uncommitted changes). Times are "
    "those of the jobs that computed the results, summed over jobs. “Computed now” counts the jobs "
    "of the pipeline run that built this page; what is missing there was in the store already and "
    "cost nothing, so its commit may be an older one: same recipe, same result. A recipe is the "
    "digest of a job's configuration, source, package versions and inputs."
)
_UNKNOWN = "not\u00a0recorded"
_STAGES = {  # in the order in which they run; others follow
    "gait": "gaits",
    "library": "gait library",
    "standing": "standing",
    "walking": "walking",
    "evaluation": "evaluation of the policy",
    "baseline": "evaluation of the baselines",
    "table1": "table 1",
    "speeds": "protocols of constant commands",
    "segments": "protocols of changing commands",
    "cases": "protocols of several cases",
    "study": "studies",
    "verification_gaits": "verification, per gait",
    "verification": "verification, verdict",
    "video": "videos",
}


@dataclass(frozen=True)
class Made:
    """A result.

    Attributes:
        origin: stage, label, recipe, source digest, versions.
        facts: times, machine and commit of the run that computed it.
        object: name of its folder in the store.
    """

    origin: Mapping[str, Any]
    facts: Mapping[str, Any]
    object: str


@dataclass(frozen=True)
class Details:
    """A table or a text that opens by a click."""

    kind: ClassVar = "details"
    summary: str
    table: Table | None = None
    text: str = ""


def blocks(
    configuration: Mapping[str, Any],
    results: Mapping[str, Sequence[Made]],
    page: Mapping[str, Any],
) -> Iterator[Text | Table | Details]:
    """Tables of stages, recipes, versions and seeds, and the resolved configuration.

    Args:
        configuration: the resolved one, as plain values.
        results: input of the page → its results.
        page: commit and start of the pipeline run that builds the page.
    """
    stages = _by_stage(results)
    yield Text(_TEXT.format(commit=_commit(page)))
    yield _stages(stages, page.get("pipeline_started"))
    machines = _machines(stages)
    yield Text(f"{'Machine' if len(machines) == 1 else 'Machines'}: {'; '.join(machines)}.")
    yield _seeds(configuration)
    yield Details("Versions of packages", _versions(stages))
    yield Details("Recipes, objects and commits of all jobs", _recipes(stages))
    text = yaml.safe_dump(dict(configuration), sort_keys=False, allow_unicode=True)
    yield Details("Resolved configuration", text=str(text))


def _by_stage(results: Mapping[str, Sequence[Made]]) -> dict[str, list[Made]]:
    """Each result once, by its stage."""
    once = {made.origin["recipe"]: made for items in results.values() for made in items}
    stages = {made.origin["stage"]: [] for made in once.values()}
    for made in once.values():
        stages[made.origin["stage"]].append(made)
    return {stage: stages[stage] for stage in in_order(stages)}


def in_order(stages: Iterable[str]) -> list[str]:
    """Different stages in the order in which they run, those without a title last."""
    present = set(stages)
    return [*(stage for stage in _STAGES if stage in present), *sorted(present - set(_STAGES))]


def stage_title(stage: str) -> str:
    """What people call a stage."""
    return _STAGES.get(stage, stage.replace("_", " "))


def _stages(stages: Mapping[str, list[Made]], started: str | None) -> Table:
    columns = [
        "stage",
        "jobs",
        "computed now",
        "resumed",
        "wall time [s]",
        "CPU time [s]",
        "finished (UTC)",
        "commit",
    ]
    rows = [_stage(stage_title(name), results, started) for name, results in stages.items()]
    return Table(columns, rows)


def _stage(name: str, results: list[Made], started: str | None) -> list[Cell]:
    jobs = [made.facts for made in results]
    now = sum(_is_of(job, started) for job in jobs)
    resumed = sum(bool(job.get("resumed")) for job in jobs)
    wall, cpu = (sum(job.get(key, 0.0) for job in jobs) for key in ("wall_s", "cpu_s"))
    ended = max((job.get("ended", "") for job in jobs), default="")
    return [
        Cell(name),
        Cell(str(len(jobs)), len(jobs)),
        Cell(str(now), now),
        Cell(str(resumed), resumed),
        Cell(f"{wall:.1f}", wall),
        Cell(f"{cpu:.1f}", cpu),
        Cell(ended[:16].replace("T", "\u00a0") or _UNKNOWN),
        Cell(", ".join(sorted(set(map(_commit, jobs))))),
    ]


def _machines(stages: Mapping[str, list[Made]]) -> list[str]:
    """Machines, each with the stages that it computed unless it computed all."""
    machines: dict[str, list[str]] = {}
    for stage, results in stages.items():
        for machine in {made.facts.get("machine", _UNKNOWN) for made in results}:
            machines.setdefault(machine, []).append(stage_title(stage))
    if len(machines) == 1:
        return list(machines)
    return [f"{machine} ({', '.join(names)})" for machine, names in sorted(machines.items())]


def _is_of(job: Mapping[str, Any], started: str | None) -> bool:
    """Whether the pipeline run that builds the page computed this; else it was in the store."""
    here = started is not None and job.get("pipeline_started") == started
    return here and bool(job.get("computed"))


def _commit(facts: Mapping[str, Any]) -> str:
    """First digits of the commit, with a ``+`` where files differed from it."""
    if "commit" not in facts:
        return _UNKNOWN
    return facts["commit"][:8] + ("+" if facts["dirty"] == "true" else "")


def _recipes(stages: Mapping[str, list[Made]]) -> Table:
    rows = [
        [
            stage,
            made.origin["label"],
            made.origin["recipe"][:16],
            made.object[:16],
            made.origin["source"][:12],
            _commit(made.facts),
        ]
        for stage, results in stages.items()
        for made in results
    ]
    return grid(["stage", "job", "recipe", "object", "source digest", "commit"], rows)


def _versions(stages: Mapping[str, list[Made]]) -> Table:
    versions: dict[str, str] = {}
    for results in stages.values():
        for made in results:
            versions |= made.origin["versions"]
    return grid(["package", "version"], sorted(versions.items()))


def _seeds(configuration: Mapping[str, Any]) -> Table:
    leaves = pd.json_normalize(dict(configuration)).iloc[0]
    seeds = leaves[[name for name in leaves.index if name.endswith(".seed")]]
    return grid(["seed", "value"], [[name, str(value)] for name, value in seeds.items()])
