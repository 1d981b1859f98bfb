"""What differs between two jobs: a configuration key, a source module, a package, an input."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from slider.artefacts.plan import JobSpec, Plan
from slider.artefacts.recipe import Code
from slider.core.files import canonical

_ABSENT = object()
_WIDTH = 40  # characters of a value
Leaf = tuple[tuple[str, ...], Any, Any]
"""Path of a value that differs, before, after."""


@dataclass(frozen=True)
class Cause:
    """One difference of two jobs.

    Attributes:
        kind: configuration, source, package, input, stage or circumstance.
        name: key, module, package, stage or fact; of a source whose modules nobody noted, nothing.
        old: before, in canonical JSON; nothing where it was not there.
        new: after.
    """

    kind: str
    name: str
    old: str | None
    new: str | None

    def __str__(self) -> str:
        if self.kind == "source":
            return self._source()
        if self.kind == "input":
            return "new input" if self.old is None else "input no more"
        if self.kind == "circumstance" and not self.name:
            return "other bytes of the same recipe, and nothing noted differs"
        what = f"package {self.name}" if self.kind == "package" else self.name
        return f"{what} {_brief(self.old)} → {_brief(self.new)}".lstrip()

    def _source(self) -> str:
        if not self.name:
            return "source changed"
        what = "source file" if "/" in self.name else "source module"
        verb = "added" if self.old is None else "removed" if self.new is None else "changed"
        return f"{what} {self.name} {verb}"


def _brief(text: str | None) -> str:
    if text is None:
        return "none"
    plain = text.strip('"')
    if len(plain) <= _WIDTH:
        return plain
    found = json.loads(text)
    return f"{len(found)} values" if isinstance(found, list) else f"{plain[: _WIDTH - 1]}…"


class Comparison:
    """How jobs of one plan differ from those of another.

    Args:
        old, new: the plans. Sections have names of their own; the configuration that the page
            shows, a job of either plan, gives the keys that people set.
    """

    def __init__(self, old: Plan, new: Plan) -> None:
        before, after = _configuration(old), _configuration(new)
        self._keys = list(_leaves(before, after)) if before and after else []
        self._used: set[str] = set()

    def own(self, old: JobSpec, new: JobSpec) -> list[Cause]:
        """Differences of two jobs but for their inputs: first keys, then modules and packages."""
        if old.stage != new.stage:
            return [Cause("stage", "", old.stage, new.stage)]
        return [
            *(
                _configured(self._key(new.stage, leaf), leaf)
                for leaf in _leaves(old.section, new.section)
            ),
            *_source(old.code, new.code),
            *_changes("package", old.code.versions, new.code.versions),
        ]

    def shaping(self) -> list[Cause]:
        """Keys that differ and that no job seen so far holds: they tell which jobs there are."""
        keys = ((".".join(leaf[0]), leaf) for leaf in self._keys)
        return [_configured(name, leaf) for name, leaf in keys if name not in self._used]

    def _key(self, stage: str, leaf: Leaf) -> str:
        """The key with the same last name and the same two values that is most like the path."""
        path, *values = leaf
        same = [p for p, *found in self._keys if p[-1] == path[-1] and found == values]
        near = {*path, *stage.split("_")}
        best = max(same, key=lambda p: len(near.intersection(p)) - len(p) / 100, default=path)
        self._used |= {".".join(best)} if same else set()
        return ".".join(best)


def _configured(name: str, leaf: Leaf) -> Cause:
    return Cause("configuration", name, _text(leaf[1]), _text(leaf[2]))


def _source(old: Code, new: Code) -> list[Cause]:
    if old.entry != new.entry:
        return [Cause("source", new.entry, old.entry, new.entry)]
    if old.source == new.source:
        return []
    known = list(_changes("source", old.parts, new.parts)) if old.parts and new.parts else []
    return known or [Cause("source", "", old.source, new.source)]


def _changes(kind: str, old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[Cause]:
    for name in sorted({*old, *new}):
        if old.get(name) != new.get(name):
            yield Cause(kind, name, old.get(name), new.get(name))


def pairs(old: JobSpec, new: JobSpec) -> Iterator[tuple[JobSpec | None, JobSpec | None]]:
    """Inputs of two jobs that belong together; one that the other job lacks stands alone.

    Equal recipes come first, then equal labels in their order, then what is alone in its group.
    """
    for name in dict.fromkeys([*old.inputs, *new.inputs]):
        yield from _matched(old.inputs.get(name, ()), new.inputs.get(name, ()))


def _matched(
    old: Sequence[JobSpec], new: Sequence[JobSpec]
) -> Iterator[tuple[JobSpec | None, JobSpec | None]]:
    left, right = list(old), list(new)
    alone = len(old) == len(new) == 1
    for key in ("recipe", "stage label", "stage" if alone else "stage label"):
        get = attrgetter(*key.split())
        waiting: dict[Any, list[JobSpec]] = {}
        for job in left:
            waiting.setdefault(get(job), []).append(job)
        rest = []
        for job in right:
            same = waiting.get(get(job))
            if same:
                yield same.pop(0), job
            else:
                rest.append(job)
        left, right = [job for jobs in waiting.values() for job in jobs], rest
    yield from ((job, None) for job in left)
    yield from ((None, job) for job in right)


def _configuration(plan: Plan) -> Mapping[str, Any]:
    recipe = plan.targets.get("report")
    return plan.jobs[recipe].section.get("configuration", {}) if recipe else {}


def _leaves(old: Any, new: Any, path: tuple[str, ...] = ()) -> Iterator[Leaf]:
    """Values that differ, in the order of the second tree; lists of tables by their place."""
    if canonical(old) == canonical(new):
        return
    before, after = _table(old), _table(new)
    if before is None or after is None:
        yield path, old, new
        return
    names = [*after, *(name for name in before if name not in after)]
    for name in names:
        if name not in before or name not in after:
            yield (*path, name), before.get(name, _ABSENT), after.get(name, _ABSENT)
        else:
            yield from _leaves(before[name], after[name], (*path, name))
    if {*before} == {*after} and [*before] != [*after]:  # the order of terms has a meaning
        yield (*path, "order"), [*before], [*after]


def _table(value: Any) -> dict[str, Any] | None:
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        return {str(place): item for place, item in enumerate(value)}
    return None


def _text(value: Any) -> str | None:
    return None if value is _ABSENT else canonical(value)
