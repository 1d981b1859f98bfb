"""A small real store: two gaits, a library of them, a table, and a page with the configuration."""

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from slider.artefacts import runner
from slider.artefacts.lineage.targets import Found
from slider.artefacts.plan import JobSpec, Plan, build_plan, write_plan
from slider.artefacts.recipe import code_of, sources_of
from slider.artefacts.runner import Runner
from slider.artefacts.store import Store

FILES = {
    "solve.py": "def cost(mass):\n    return mass // 10\n",
    "gait.py": """
import os
from PACKAGE.solve import cost


def run(section, inputs, out, job):
    (out / "gait.txt").write_text(f"{cost(section['robot']['mass'])} {section['command']}")
    (out / "bits.txt").write_text(os.environ.get("TEST_BITS", ""))
    return {}
""",
    "library.py": """
def run(section, inputs, out, job):
    text = [(folder / "gait.txt").read_text() for folder in inputs["gaits"]]
    (out / "library.txt").write_text("\\n".join(text))
    return {"gaits": len(text)}
""",
    "table.py": """
def run(section, inputs, out, job):
    library = inputs["library"][0] / "library.txt"
    (out / "table.csv").write_text(f"{section['trials']}\\n{library.read_text()}")
    return {}
""",
}
DEFAULT = {"robot": {"mass": 14.0, "links": {"foot": 0.07}}, "trials": 10, "grid": [0.0, 0.5]}


@dataclass(frozen=True)
class World:
    """Stages of a package of their own, and a store of their results."""

    root: Path
    package: str
    store: Store

    def plan(self, versions: Mapping[str, str] | None = None, **changes: Any) -> Plan:
        """Jobs of a configuration; ``versions`` are other ones of the packages of a gait."""
        values = DEFAULT | changes
        shared = {"robot": values["robot"]}
        gaits = [self._job("gait", shared | {"command": [vx, 0.0, 0.0]}) for vx in values["grid"]]
        if versions:
            gaits = [replace(gait, code=replace(gait.code, versions=versions)) for gait in gaits]
        library = self._job("library", {}, gaits=gaits)
        table = self._job("table", {"trials": values["trials"]}, library=[library])
        keys = {"robot": values["robot"], "evaluation": {"trials": values["trials"]}}
        keys["gait"] = {"grid": values["grid"]}
        page = self._job("table", {"configuration": keys})
        return build_plan({"library": library, "table1": table, "report": page})

    def _job(self, stage: str, section: Mapping[str, Any], **inputs: Sequence[JobSpec]) -> JobSpec:
        code = code_of(f"{self.package}.{stage}:run", self.root)
        label = f"gait {section['command'][0]:.2f} m/s" if stage == "gait" else f"the {stage}"
        return JobSpec(stage, label, code, section, inputs)

    def lay_out(self, plan: Plan, store: Store | None = None) -> Plan:
        """Write a plan as the latest one."""
        store = store or self.store
        path = write_plan(plan, store.root / "plans")
        times = [other.stat().st_mtime for other in path.parent.glob("*.json")]
        os.utime(path, (max(times) + 1,) * 2)
        return plan

    def compute(self, plan: Plan, store: Store | None = None) -> Found:
        """Lay a plan out and compute its table."""
        self.lay_out(plan, store)
        found = self.found(plan, "table1", store)
        for job in build_plan({"table1": found.job}).jobs.values():
            Runner(store or self.store).run(job)
        return found

    def found(self, plan: Plan, target: str = "table1", store: Store | None = None) -> Found:
        """A target of a plan."""
        return Found(store or self.store, plan, plan.jobs[plan.targets[target]])

    def edit(self, name: str, text: str) -> None:
        """Change a module."""
        (self.root / self.package / name).write_text(text.replace("PACKAGE", self.package))
        code_of.cache_clear()
        sources_of.cache_clear()
        for module in [name for name in sys.modules if name.startswith(self.package)]:
            del sys.modules[module]


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> World:
    package = f"lineage_{abs(hash(str(tmp_path)))}"
    root = tmp_path / "source"
    (root / package).mkdir(parents=True)
    made = World(root, package, Store(tmp_path / "artefacts"))
    for name, text in ({"__init__.py": ""} | FILES).items():
        made.edit(name, text)
    monkeypatch.syspath_prepend(root)
    monkeypatch.setattr(runner, "SOURCE_ROOT", root)
    return made
