"""Where it all comes from: commit, configuration, recipes, versions, seeds, machine, times."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import yaml

from slider.reports.sections.sources import Sources
from slider.reports.table import Cell, Table, Tables, Text

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
class _Made:
    """A result: its origin, what differs between runs, and its object."""

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


def blocks(sources: Sources) -> Iterator[Text | Table | Tables | Details]:
    """Tables of stages, recipes, versions and seeds, and the resolved configuration."""
    stages = _by_stage(sources)
    yield Text(_TEXT.format(commit=_commit(sources.page)))
    yield _stages(stages, sources.page.get("pipeline_started"))
    machines = _machines(stages)
    yield Text(f"{'Machine' if len(machines) == 1 else 'Machines'}: {'; '.join(machines)}.")
    yield Tables([_seeds(sources.configuration), _versions(sources)])
    yield Details("Recipes, objects and commits of all jobs", _recipes(stages))
    configuration = dict(sources.configuration)
    text = yaml.safe_dump(configuration, sort_keys=False, allow_unicode=True)
    yield Details("Resolved configuration", text=text)


def _by_stage(sources: Sources) -> dict[str, list[_Made]]:
    """Every result that the page is made from, once, by its stage."""
    found: dict[str, _Made] = {}
    for name, origins in sources.origins.items():
        for origin, facts, folder in zip(
            origins, sources.times[name], sources.inputs[name], strict=True
        ):
            found[origin["recipe"]] = _Made(origin, facts, folder.name)
    order = in_order(made.origin["stage"] for made in found.values())
    return {
        stage: [made for made in found.values() if made.origin["stage"] == stage] for stage in order
    }


def in_order(stages: Iterable[str]) -> list[str]:
    """Different stages in the order in which they run, those without a title last."""
    present = set(stages)
    return [*(stage for stage in _STAGES if stage in present), *sorted(present - set(_STAGES))]


def stage_title(stage: str) -> str:
    """What people call a stage."""
    return _STAGES.get(stage, stage.replace("_", " "))


def _stages(stages: Mapping[str, list[_Made]], started: str | None) -> Table:
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
    rows = [_stage(stage_title(name), made, started) for name, made in stages.items()]
    return Table(columns, rows)


def _stage(name: str, made: list[_Made], started: str | None) -> list[Cell]:
    jobs = [item.facts for item in made]
    now = sum(_is_of(job, started) for job in jobs)
    resumed = sum(bool(job.get("resumed")) for job in jobs)
    wall, cpu = (sum(job.get(key, 0.0) for job in jobs) for key in ("wall_s", "cpu_s"))
    ended = max((job.get("ended", "") for job in jobs), default="")
    return [
        Cell(name, name),
        Cell(str(len(jobs)), len(jobs)),
        Cell(str(now), now),
        Cell(str(resumed), resumed),
        Cell(f"{wall:.1f}", wall),
        Cell(f"{cpu:.1f}", cpu),
        Cell(ended[:16].replace("T", "\u00a0") or _UNKNOWN, ended),
        Cell(_all(map(_commit, jobs))),
    ]


def _machines(stages: Mapping[str, list[_Made]]) -> list[str]:
    """Machines, each with the stages that it computed unless it computed all."""
    found: dict[str, list[str]] = {}
    for stage, results in stages.items():
        for machine in {made.facts.get("machine", _UNKNOWN) for made in results}:
            found.setdefault(machine, []).append(stage_title(stage))
    if len(found) == 1:
        return list(found)
    return [f"{machine} ({', '.join(names)})" for machine, names in sorted(found.items())]


def _is_of(job: Mapping[str, Any], started: str | None) -> bool:
    """Whether the pipeline run that builds the page computed this; else it was in the store."""
    here = started is not None and job.get("pipeline_started") == started
    return here and bool(job.get("computed"))


def _commit(facts: Mapping[str, Any]) -> str:
    """First digits of the commit, with a ``+`` where files differed from it."""
    if "commit" not in facts:
        return _UNKNOWN
    return facts["commit"][:8] + ("+" if facts["dirty"] == "true" else "")


def _all(texts: Iterable[str]) -> str:
    return ", ".join(sorted(set(texts)))


def _recipes(stages: Mapping[str, list[_Made]]) -> Table:
    rows = [
        [
            Cell(stage, stage),
            Cell(made.origin["label"], made.origin["label"]),
            Cell(made.origin["recipe"][:16], made.origin["recipe"]),
            Cell(made.object[:16], made.object),
            Cell(made.origin["source"][:12], made.origin["source"]),
            Cell(_commit(made.facts)),
        ]
        for stage, results in stages.items()
        for made in results
    ]
    return Table(["stage", "job", "recipe", "object", "source digest", "commit"], rows)


def _versions(sources: Sources) -> Table:
    found: dict[str, str] = {}
    for jobs in sources.origins.values():
        for job in jobs:
            found |= job["versions"]
    return Table(
        ["package", "version"],
        [[Cell(name, name), Cell(found[name], found[name])] for name in sorted(found)],
    )


def _seeds(configuration: Mapping[str, Any]) -> Table:
    rows = [
        [Cell(path, path), Cell(str(value), value)]
        for path, value in _leaves(configuration)
        if path.endswith(".seed")
    ]
    return Table(["seed", "value"], rows)


def _leaves(node: Any, prefix: str = "") -> list[tuple[str, Any]]:
    if not isinstance(node, Mapping):
        return [(prefix, node)]
    return [
        leaf
        for name, value in node.items()
        for leaf in _leaves(value, f"{prefix}.{name}" if prefix else str(name))
    ]
