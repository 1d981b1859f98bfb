"""Lineage in words."""

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from slider.artefacts.lineage.ancestry import Step, steps
from slider.artefacts.lineage.causes import Cause
from slider.artefacts.lineage.compare import Difference
from slider.artefacts.lineage.pending import Pending
from slider.artefacts.lineage.targets import SHORT, Found
from slider.artefacts.plan import JobSpec

_WIDTH = 80  # characters of the values of a table
_MODULES = 3  # of one stage


def shown(found: Found) -> Iterator[str]:
    """What a result is, how it was computed, and the tree of what it was made from."""
    code = found.job.code
    modules = f", {len(code.parts)} modules and files" if code.parts else ""
    yield f"{found.name}: {found.job.label}"
    yield from _rows(
        {
            "recipe": found.job.recipe,
            "object": _object(found),
            **_noted(found.facts),
            "source": f"{code.entry}, {code.source[:SHORT]}{modules}",
            "packages": ", ".join(f"{name} {version}" for name, version in code.versions.items()),
        }
    )
    if found.job.section:
        yield "configuration"
        yield from _rows({name: _values(value) for name, value in found.job.section.items()})
    yield "made from"
    yield from _tree(steps(found))


def _rows(rows: Mapping[str, str]) -> Iterator[str]:
    width = max(map(len, rows))
    yield from (f"  {name:<{width}}  {value}" for name, value in rows.items() if value)


def _object(one: Found) -> str:
    if one.manifest is None:
        return "none: not computed"
    result = one.manifest.result
    resumed = ", of a resumed training" if result.resumed else ""
    number = _plural(len(result.files), "file")
    return f"{result.object}, {number}, {result.size / 1e3:.1f} kB{resumed}"


def _noted(facts: Mapping[str, Any]) -> dict[str, str]:
    commit = str(facts.get("commit", ""))[:SHORT]
    threads = facts.get("threads")
    times = [_minute(facts.get("ended")), _duration(facts.get("wall_s"))]
    return {
        "computed": " in ".join(filter(None, times)),
        "machine": str(facts.get("machine", ""))
        + (f", {_plural(threads, 'thread')}" if threads else ""),
        "commit": commit + (" with changes" if facts.get("dirty") == "true" else ""),
        "overrides": str(facts.get("overrides", "")),
        "reused from": str(facts.get("reused_from", "")),
    }


def _values(value: Any) -> str:
    """Values of a part of the configuration, as many as a line holds."""
    leaves = list(_leaves(value))
    text = ", ".join(f"{name} {leaf}".strip() for name, leaf in leaves)
    if len(text) <= _WIDTH:
        return text
    return f"{text[:_WIDTH].rpartition(', ')[0] or text[:_WIDTH]}, … ({len(leaves)} values)"


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping) and value:
        for name, item in value.items():
            yield from _leaves(item, f"{path}.{name}".lstrip("."))
    else:
        yield path, value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _tree(top: Step) -> Iterator[str]:
    rows = [("", "recipe", "object", "computed", "took", ""), *_branches(top, "", "")]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  " + "  ".join(map(str.ljust, row, widths)).rstrip()


def _branches(step: Step, first: str, rest: str) -> Iterator[tuple[str, ...]]:
    yield (f"{first}{_count(step.stage, len(step.made))}", *_cells(step))
    for number, inner in enumerate(step.inputs, 1):
        last = number == len(step.inputs)
        yield from _branches(inner, rest + "└ " * last + "├ " * (not last), rest + "│ "[last] + " ")


def _cells(step: Step) -> tuple[str, ...]:
    facts = [one.facts for one in step.made]
    ended = max((str(fact.get("ended", "")) for fact in facts), default="")
    took = sum(fact.get("wall_s", 0.0) for fact in facts)
    notes = {
        "as above": step.known,
        "not computed": sum(one.manifest is None for one in step.made),
        "reused": sum(fact.get("computed") is False for fact in facts),
        "resumed": sum(bool(one.manifest and one.manifest.result.resumed) for one in step.made),
    }
    commits = {str(fact["commit"])[:SHORT] for fact in facts if "commit" in fact}
    at = [f"{len(commits)} commits"] if len(commits) > 1 else [f"at {c}" for c in commits]
    many = len(step.made) > 1
    said = [_count(name, n) if many and n is not True else name for name, n in notes.items() if n]
    return *_digests(step), _minute(ended), _duration(took), ", ".join([*at, *said])


def _digests(step: Step) -> tuple[str, str]:
    if len(step.made) > 1:
        objects = {one.object for one in step.made} - {None}
        return f"{len(step.made)} recipes", f"{len(objects)} objects"
    one = step.made[0]
    return one.job.recipe[:SHORT], (one.object or "")[:SHORT]


def differing(differences: Sequence[Difference]) -> Iterator[str]:
    """A line per cause, with the stages that depend on it."""
    merged: dict[tuple[str, ...], list[Cause]] = {}
    for difference in differences:
        merged.setdefault(tuple(_stages(difference.jobs)), []).append(difference.cause)
    for stages, causes in merged.items():
        for text in _texts(causes):
            yield f"  {', '.join(stages)}: {text}"


def waiting(jobs: Sequence[Pending]) -> Iterator[str]:
    """A line per stage and reason."""
    counts: Counter[tuple[str, str]] = Counter()
    for one in jobs:
        inputs = f"input{'s' * (len(one.inputs) > 1)} {', '.join(one.inputs)}"
        reasons = [*_texts(one.causes), *([inputs] if one.inputs else [])]
        text = one.state or "; ".join(reasons) or "its inputs in another order"
        counts[one.job.stage, text + " (reused: content known)" * one.reused] += 1
    yield from (f"  {_count(stage, n)}: {text}" for (stage, text), n in counts.items())


def _texts(causes: Iterable[Cause]) -> Iterator[str]:
    """Causes in words; of many modules the first few."""
    causes = list(causes)
    modules = [cause for cause in causes if cause.kind == "source" and cause.name]
    yield from (str(cause) for cause in causes if cause not in modules)
    if len(modules) <= _MODULES:
        yield from map(str, modules)
    elif modules:
        names = ", ".join(cause.name for cause in modules[:_MODULES])
        yield f"source modules {names} and {len(modules) - _MODULES} more changed"


def _stages(jobs: Iterable[JobSpec]) -> list[str]:
    return [_count(stage, n) for stage, n in Counter(job.stage for job in jobs).items()]


def _count(name: str, number: int) -> str:
    return f"{name} × {number}" if number > 1 else name


def _plural(number: int, name: str) -> str:
    return f"{number} {name}{'s' * (number != 1)}"


def _minute(time: Any) -> str:
    return f"{str(time)[:16].replace('T', ' ')} UTC" if time else ""


def _duration(seconds: Any) -> str:
    if not seconds:
        return ""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min {rest} s"
