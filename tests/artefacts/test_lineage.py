"""Why jobs must run, and what two plans differ by, on a small real store."""

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from slider.artefacts import runner
from slider.artefacts.lineage import LOST, NEVER, count, differences, find_target, pending
from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_paths, write_plan
from slider.artefacts.recipe import code_of, sources_of
from slider.artefacts.runner import Runner
from slider.artefacts.store import Store
from slider.cli import main
from slider.core.errors import UserError

FILES = {
    "solve.py": "def cost(mass):\n    return mass // 10\n",
    "gait.py": """
import os
from PACKAGE.solve import cost


def run(section, inputs, out, job):
    (out / "gait.txt").write_text(f"{cost(section['robot']['mass'])} {section['velocity']}")
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
        gaits = [self._job("gait", shared | {"velocity": [vx, 0.0, 0.0]}) for vx in values["grid"]]
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
        label = f"gait {section['velocity'][0]:.2f} m/s" if stage == "gait" else f"the {stage}"
        return JobSpec(stage, label, code, section, inputs)

    def lay_out(self, plan: Plan, store: Store | None = None) -> Plan:
        """Write a plan as the latest one."""
        store = store or self.store
        path = write_plan(plan, store.root / "plans")
        times = [other.stat().st_mtime for other in path.parent.glob("*.json")]
        os.utime(path, (max(times) + 1,) * 2)
        return plan

    def compute(self, plan: Plan, store: Store | None = None) -> Plan:
        """Lay a plan out and compute its table."""
        self.lay_out(plan, store)
        table = plan.jobs[plan.targets["table1"]]
        for job in build_plan({"table1": table}).jobs.values():
            Runner(store or self.store).run(job)
        return plan

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


def lines(world: World, old: Plan, new: Plan, *stores: Store) -> list[str]:
    sides = stores or (world.store, world.store)
    causes = differences(old, new, "table1", (sides[0], sides[1]))
    return [f"{count(jobs[0].stage, len(jobs))}: {cause}" for cause, jobs in causes.items()]


def why(world: World, plan: Plan) -> list[str]:
    world.lay_out(plan)
    jobs = pending(plan, "table1", world.store)
    return [f"{job.label}: {'; '.join(reasons)}" for job, reasons in jobs]


def test_keys_are_named_as_people_set_them_and_with_the_jobs_that_read_them(world):
    heavy = {"mass": 14.5, "links": {"foot": 0.07}}
    old, new = world.plan(), world.plan(robot=heavy, trials=3)
    assert lines(world, old, old) == []
    assert lines(world, old, new) == [
        "gait × 2: robot.mass 14.0 → 14.5",
        "table: evaluation.trials 10 → 3",
    ]


@pytest.mark.parametrize(
    ("robot", "text"),
    [
        ({"mass": 14.0, "links": {}}, "robot.links.foot 0.07 → none"),
        ({"mass": 14, "links": {"foot": 0.07}}, "robot.mass 14.0 → 14"),
        (
            {"links": {"foot": 0.07}, "mass": 14.0},
            'robot.order ["mass", "links"] → ["links", "mass"]',
        ),
        ({"mass": None, "links": {"foot": 0.07}}, "robot.mass 14.0 → null"),
    ],
)
def test_every_kind_of_change_of_a_section_has_a_cause(world, robot, text):
    assert lines(world, world.plan(), world.plan(robot=robot)) == [f"gait × 2: {text}"]


def test_modules_and_packages_are_named(world):
    old = world.plan(versions={"python": "3.11", "numpy": "2.0.0"})
    world.edit("solve.py", "# a comment\ndef cost(mass):\n    return mass // 10\n")
    assert lines(world, old, world.plan(versions={"python": "3.11", "numpy": "2.0.0"})) == []
    world.edit("solve.py", "def cost(mass):\n    return mass // 10 + 1\n")
    new = world.plan(versions={"python": "3.11", "numpy": "2.1.0", "scipy": "1.0"})
    assert lines(world, old, new) == [
        f"gait × 2: source {world.package}.solve changed",
        "gait × 2: package numpy 2.0.0 → 2.1.0",
        "gait × 2: package scipy none → 1.0",
    ]


def test_inputs_that_come_and_go_are_named(world):
    assert lines(world, world.plan(), world.plan(grid=[0.0, 0.1, 0.2])) == [
        "gait × 2: input gait added",
        "gait: input gait removed",
    ]


def test_other_bytes_of_one_recipe_are_followed_to_where_they_begin(world, monkeypatch, tmp_path):
    plan, there = world.plan(), Store(tmp_path / "elsewhere")
    world.compute(plan)
    world.compute(plan, there)
    assert lines(world, plan, plan, world.store, there) == []
    other = Store(tmp_path / "third")
    monkeypatch.setenv("TEST_BITS", "of another processor")
    world.compute(plan, other)
    assert lines(world, plan, plan, world.store, other) == [
        "gait × 2: other bytes of the same recipe"
    ]


def test_why_names_the_first_cause_and_then_the_inputs(world):
    plan = world.plan()
    gaits = ["gait 0.00 m/s", "gait 0.50 m/s"]
    assert why(world, plan) == [f"{n}: {NEVER}" for n in (*gaits, "the library", "the table")]
    world.compute(plan)
    assert why(world, plan) == []
    heavy = world.plan(robot={"mass": 19.0, "links": {"foot": 0.07}})
    assert why(world, heavy) == [
        *(f"{name}: robot.mass 14.0 → 19.0" for name in gaits),
        "the library: input gait",
        "the table: input library",
    ]
    assert why(world, world.plan(trials=3)) == ["the table: evaluation.trials 10 → 3"]


def test_a_damaged_object_is_why(world):
    plan = world.compute(world.plan())
    gait = next(iter(plan.jobs.values()))
    world.store.drop_object(
        world.store.read_manifest("table", plan.targets["table1"]).result.object
    )
    assert why(world, plan) == [f"the table: {LOST}"]
    world.store.drop_object(world.store.read_manifest("gait", gait.recipe).result.object)
    assert why(world, plan)[-1] == f"the table: {LOST}"


@pytest.mark.parametrize("text", ["table1", "reports/table1.csv", "artefacts/table1.json"])
def test_a_report_leads_to_its_target(world, text):
    assert find_target(text, world.plan()) == "table1"


def test_an_unknown_target_has_a_suggestion(world):
    with pytest.raises(UserError, match="found 'tabel1'; did you mean table1"):
        find_target("tabel1", world.plan())
    with pytest.raises(UserError, match="targets: library, table1, report"):
        find_target("x", world.plan())


def test_the_commands(world, capsys):
    store = ["--artefacts", str(world.store.root)]
    assert main(["why", "table1", *store]) == 1
    assert "run `snakemake -n`" in capsys.readouterr().err
    first = world.compute(world.plan())
    assert main(["diff", "previous", "latest", *store]) == 1
    assert "expected a plan 'previous'" in capsys.readouterr().err
    world.lay_out(world.plan(trials=3))
    assert main(["why", "table1", *store]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "table1: 1 to compute",
        "  table: evaluation.trials 10 → 3",
    ]
    assert main(["diff", "previous", "latest", *store]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "table1: 1 cause of a difference",
        "  table: evaluation.trials 10 → 3",
    ]
    world.lay_out(first)
    path = plan_paths(world.store.root / "plans")[0]
    assert main(["diff", path.stem[:12], str(world.store.root), *store]) == 0
    assert capsys.readouterr().out == "table1: the same\n"
