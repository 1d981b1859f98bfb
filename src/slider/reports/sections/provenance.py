"""Where it all comes from: configuration, recipes, versions, seeds, machine, times."""

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from slider.reports.page import Cell, Section, Table
from slider.reports.sections.sources import Sources


def section(sources: Sources) -> Section:
    """Tables of stages, recipes, versions and seeds, and the resolved configuration."""
    stages = [name for name in sources.origins if name in sources.times]
    values = {
        "stages": _stages(sources, stages),
        "recipes": _recipes(sources, stages),
        "versions": _versions(sources),
        "seeds": _seeds(sources.configuration),
        "configuration": yaml.safe_dump(
            dict(sources.configuration), sort_keys=False, allow_unicode=True
        ),
    }
    return Section("Provenance", "provenance.html", values)


def _stages(sources: Sources, names: Sequence[str]) -> Table:
    columns = [
        "stage",
        "jobs",
        "reused from the store",
        "resumed",
        "wall time [s]",
        "CPU time [s]",
        "finished",
        "machine",
    ]
    rows = [_stage(name, sources.times[name]) for name in names]
    return Table(columns, rows)


def _stage(name: str, jobs: Sequence[Mapping[str, Any]]) -> list[Cell]:
    reused = sum(not job.get("computed", True) for job in jobs)
    resumed = sum(bool(job.get("resumed")) for job in jobs)
    wall, cpu = (sum(job.get(key, 0.0) for job in jobs) for key in ("wall_s", "cpu_s"))
    ended = max((job.get("ended", "") for job in jobs), default="")
    machines = sorted({job["machine"] for job in jobs if "machine" in job})
    return [
        Cell(name, name),
        Cell(str(len(jobs)), len(jobs)),
        Cell(str(reused), reused),
        Cell(str(resumed), resumed),
        Cell(f"{wall:.1f}", wall),
        Cell(f"{cpu:.1f}", cpu),
        Cell(ended[:19].replace("T", " ") or "unknown", ended),
        Cell("; ".join(machines) or "not recorded"),
    ]


def _recipes(sources: Sources, names: Sequence[str]) -> Table:
    rows = [
        [
            Cell(name, name),
            Cell(job["label"], job["label"]),
            Cell(job["recipe"][:16], job["recipe"]),
            Cell(folder.name[:16], folder.name),
            Cell(job["source"][:12], job["source"]),
        ]
        for name in names
        for job, folder in zip(sources.origins[name], sources.inputs[name], strict=True)
    ]
    return Table(["stage", "job", "recipe", "object", "source digest"], rows)


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
