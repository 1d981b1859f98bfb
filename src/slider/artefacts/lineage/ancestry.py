"""A result and all that it was made from, jobs of one stage together."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from slider.artefacts.lineage.targets import Found
from slider.artefacts.plan import build_plan


@dataclass(frozen=True)
class Step:
    """Jobs of one stage that are inputs of the same jobs, and the steps before them.

    ``known`` says that an earlier step of the tree has the same jobs, with what is before them.
    """

    made: Sequence[Found]
    inputs: Sequence["Step"] = ()
    known: bool = False

    @property
    def stage(self) -> str:
        """The stage of its jobs."""
        return self.made[0].job.stage


def steps(found: Found) -> Step:
    """Tree of the stages behind a result."""
    return _step([found], set())


def _step(made: Sequence[Found], seen: set[frozenset[str]]) -> Step:
    recipes = frozenset(one.job.recipe for one in made)
    if recipes in seen:
        return Step(made, known=True)
    seen.add(recipes)
    groups: dict[str, dict[str, Found]] = {}
    for one in made:
        for item in one.inputs:
            groups.setdefault(item.job.stage, {})[item.job.recipe] = item
    return Step(made, [_step([*group.values()], seen) for group in groups.values()])


def everything(found: Found) -> dict[str, Any]:
    """All that is known of a result, and its ancestors by recipe, as plain values."""
    result = found.manifest.result if found.manifest else None
    code = asdict(found.job.code)
    ancestors = build_plan({found.name: found.job}).jobs.values()
    return {
        "name": found.name,
        **_plain(found),
        "files": result.files if result else {},
        "summary": result.summary if result else {},
        "configuration": dict(found.job.section),
        "modules": code.pop("parts") or None,
        "code": code,
        "jobs": {job.recipe: _plain(Found(found.store, found.plan, job)) for job in ancestors},
    }


def _plain(one: Found) -> dict[str, Any]:
    return {
        **one.job.names,
        "object": one.object,
        "resumed": bool(one.manifest and one.manifest.result.resumed),
        "noted": one.facts,
        "inputs": one.job.input_recipes,
    }
