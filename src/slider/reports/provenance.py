"""Provenance of the results: commit, configuration, recipes, versions, seeds, machine, times."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from slider.core.tables import Table

_TEXT = (
    "This page was built from commit `{commit}` (a + stands for uncommitted changes). Times are "
    "those of the jobs that computed the results, summed over jobs. The commit of a result that "
    "was in the store already may be an older one: same recipe, same result. A recipe is the "
    "digest of a job's configuration, source, package versions and inputs."
)
_UNKNOWN = "not\u00a0recorded"
_NOTHING = {"machine": _UNKNOWN, "wall_s": 0.0, "cpu_s": 0.0, "ended": ""}
_STAGES = {  # in the order in which they run; others follow
    "gait": "gaits",
    "library": "gait library",
    "standing": "standing",
    "walking": "walking",
    "evaluation": "evaluation of the policy",
    "baseline": "evaluation of the baselines",
    "table1": "table 1",
}


Recorded = tuple[Mapping[str, Any], Mapping[str, Any], Path]
"""Of a result: its origin (stage, label, recipe, source digest, versions), its run metadata (times,
machine, commit), and its object's folder."""


def blocks(
    configuration: Mapping[str, Any], jobs: Sequence[Recorded], page: Mapping[str, Any]
) -> Iterator[str | Table]:
    """Tables of stages, recipes and versions, and the resolved configuration.

    ``jobs`` are the results on the page; ``page`` has the commit of the run that builds it.
    """
    versions = {name: text for job in jobs for name, text in job[0]["versions"].items()}
    table = _table(jobs)
    yield _TEXT.format(commit=_commit(page))
    yield _stages(table)
    columns = ["stage", "label", "recipe", "object", "source", "commit", "machine"]
    written = yaml.safe_dump(dict(configuration), sort_keys=False, allow_unicode=True)
    for title, text in (
        ("Versions of packages", yaml.safe_dump(versions)),
        ("Recipes, objects and commits of all jobs", table[columns].to_csv(index=False)),
        ("Resolved configuration", written),
    ):
        yield f"## {title}\n\n````\n{text}````"


def _table(jobs: Sequence[Recorded]) -> pd.DataFrame:
    """A row per result, each once, by stage."""
    rows = [
        {**_NOTHING, **metadata, **origin, "object": folder.name, "commit": _commit(metadata)}
        for origin, metadata, folder in jobs
    ]
    table = pd.DataFrame(rows).drop_duplicates("recipe")
    order = in_order(table["stage"])
    return table.sort_values("stage", key=lambda names: names.map(order.index), kind="stable")


def in_order(stages: Iterable[str]) -> list[str]:
    """Distinct stages in the order in which they run, those without a title last."""
    present = set(stages)
    return [*(stage for stage in _STAGES if stage in present), *sorted(present - set(_STAGES))]


def stage_title(stage: str) -> str:
    """Title of a stage."""
    return _STAGES.get(stage, stage.replace("_", " "))


def _stages(table: pd.DataFrame) -> Table:
    body = []
    for stage, jobs in table.groupby("stage", sort=False):
        times = (f"{jobs[name].sum():.1f}" for name in ("wall_s", "cpu_s"))
        ended = jobs["ended"].max()[:16].replace("T", "\u00a0") or _UNKNOWN
        commits = ", ".join(sorted(jobs["commit"].unique()))
        body.append([stage_title(str(stage)), str(len(jobs)), *times, ended, commits])
    heads = ["stage", "jobs", "wall time [s]", "CPU time [s]", "finished (UTC)", "commit"]
    return Table(heads, body)


def _commit(metadata: Mapping[str, Any]) -> str:
    """First digits of the commit, with a ``+`` where files differed from it."""
    if "commit" not in metadata:
        return _UNKNOWN
    return metadata["commit"][:8] + ("+" if metadata.get("dirty") == "true" else "")
