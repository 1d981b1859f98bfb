"""A small pipeline of four stages, run as the Snakefile runs it, in processes that may fail."""

import os
import shutil
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pipeline.entry import one_line
from pipeline.targets import refresh_marker
from slider.artefacts import runner
from slider.artefacts.maintenance import drop_damaged
from slider.artefacts.plan import JobSpec, Plan, build_plan, plan_path, write_plan
from slider.artefacts.recipe import code_of
from slider.artefacts.store import Store
from slider.cli import main

MODULE = "stages_of_the_faults"
STAGES = """
def gait(section, inputs, out, job):
    (out / "gait.txt").write_text(str(section["speed"]))
    (out / "residuals").mkdir()
    (out / "residuals" / "all.txt").write_text("0.0")
    return {"speed": section["speed"]}


def library(section, inputs, out, job):
    text = [(folder / "gait.txt").read_text() for folder in inputs["gaits"]]
    (out / "library.txt").write_text(" ".join(text))
    return {}


def walking(section, inputs, out, job):
    checkpoint = job.work / "checkpoint.txt"
    checkpoint.write_text("half")
    (out / "policy.txt").write_text((inputs["library"][0] / "library.txt").read_text() + " walked")
    return {}


def table1(section, inputs, out, job):
    (out / "table1.csv").write_text((inputs["policy"][0] / "policy.txt").read_text() + "\\n")
    return {}
"""
TRUTH = "0.2 0.4 walked\n"


@dataclass(frozen=True)
class Ended:
    """How a process ended: its status, below zero after a signal, and what it said."""

    status: int
    said: str


@dataclass(frozen=True)
class Chain:
    """The pipeline below a folder, which need not exist yet."""

    folder: Path
    plan: Plan

    @property
    def report(self) -> Path:
        return self.folder / "reports" / "table1.csv"

    @property
    def store(self) -> Store:
        return Store(self.folder / "artefacts")

    @property
    def actions(self) -> dict[str, Callable[[], int]]:
        """What the Snakefile does, in its order."""
        path = plan_path(self.plan, self.store.root / "plans")
        run = ["run", "--plan", str(path), "--artefacts", str(self.store.root)]
        jobs = {
            job.label: lambda recipe=recipe: main([*run, recipe])
            for recipe, job in self.plan.jobs.items()
        }
        return {"plan": self.lay_out, **jobs, "publish": self.publish}

    def lay_out(self) -> int:
        with one_line():
            write_plan(self.plan, self.store.root / "plans")
            paths = [self.store.manifest_path(j.stage, j.recipe) for j in self.plan.jobs.values()]
            for line in drop_damaged(self.store, paths):
                print(line)
            refresh_marker(self.store, self.plan, "table1", [self.report])
        return 0

    def publish(self) -> int:
        recipe = self.plan.targets["table1"]
        manifest = self.store.manifest_path("table1", recipe)
        return main(
            ["publish", str(manifest), str(self.report), "--artefacts", str(self.store.root)]
        )

    def complete(self) -> Ended:
        """The same command again: what has no manifest is run, then the report is copied."""
        for name, action in self.actions.items():
            job = next((job for job in self.plan.jobs.values() if job.label == name), None)
            if job and self.store.manifest_path(job.stage, job.recipe).is_file():
                continue
            ended = process(action)
            if ended.status:
                return ended
        return Ended(0, "")

    @property
    def care(self) -> dict[str, Callable[[], int]]:
        """What looks after a store."""
        store = ["store", "--artefacts", str(self.store.root)]
        return {
            "verify": lambda: main([*store, "verify"]),
            "gc": lambda: main([*store, "gc", "--keep", "1"]),
        }

    def verify(self) -> Ended:
        return process(self.care["verify"])

    def content(self) -> dict[Path, bytes]:
        """Objects, manifests, index and plans; not what is noted beside them."""
        root = self.store.root
        paths = (root / name for name in ("objects", "index", "plans", "gait", "table1"))
        found = (path for folder in paths for path in folder.rglob("*") if path.is_file())
        return {path: path.read_bytes() for path in found if not path.name.endswith(".run.json")}

    def copy(self, folder: Path) -> "Chain":
        if self.folder.exists():
            shutil.copytree(self.folder, folder)
        return Chain(folder, self.plan)


@contextmanager
def chain(folder: Path) -> Iterator[Chain]:
    """An empty pipeline, whose stages can be imported as long as it lives."""
    source = folder / "source"
    source.mkdir(parents=True)
    (source / f"{MODULE}.py").write_text(STAGES)
    sys.path.insert(0, str(source))
    kept, runner.SOURCE_ROOT = runner.SOURCE_ROOT, source
    try:
        yield Chain(folder / "chain", _plan(source))
    finally:
        sys.path.remove(str(source))
        runner.SOURCE_ROOT = kept


def _plan(source: Path) -> Plan:
    def job(stage: str, label: str, section: dict, inputs: dict | None = None) -> JobSpec:
        return JobSpec(stage, label, code_of(f"{MODULE}:{stage}", source), section, inputs or {})

    gaits = [job("gait", f"gait {speed}", {"speed": speed}) for speed in (0.2, 0.4)]
    library = job("library", "library", {}, {"gaits": gaits})
    walking = job("walking", "walking", {}, {"library": [library]})
    return build_plan({"table1": job("table1", "table", {}, {"policy": [walking]})})


def process(action: Callable[[], int], *before: Callable[[], object]) -> Ended:
    """Run an action in a process of its own, after what is to go wrong in it."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        for descriptor in (1, 2):
            os.dup2(writing, descriptor)
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115 - a pipe, whatever it was before
        status = 70
        try:
            for prepare in before:
                prepare()
            status = action()
        except SystemExit as end:
            status = int(end.code or 0)
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading, errors="replace") as pipe:
        said = pipe.read()
    return Ended(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said)
