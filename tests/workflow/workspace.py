"""A copy of the repository in which tests run the real Snakemake."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pipeline.stages.entries import STAGES
from slider.artefacts.store import exclusive
from tests import shared

REPOSITORY = Path(__file__).parents[2]
COPIED = ("Snakefile", "pipeline", "profiles", "conf", "src")
TABLE = "reports/table1.csv"
PAGE = "reports/index.html"
QUIET = "tracking.enabled=false"
HOSTILE = 'it\'s a "gäit" $(touch pwned)'  # a folder that must be quoted wherever it is named
# Jobs of experiment=test: two gaits, two commands.
AFTER_STANDING = ["evaluation", "evaluation", "table1", "walking"]
EVERYTHING = sorted([*AFTER_STANDING, "gait", "gait", "library", "standing"])

# Stages in miniature, for tests that need many runs: the body of each stage's function.
BODIES = {
    "gait": """
    (out / "gait.txt").write_text(f"{speed(section)} {section['formulation']['nodes']}")
    job.volatile["solve_s"] = 0.1
    return {"converged": True}
""",
    "library": """
    text = "\\n".join((folder / "gait.txt").read_text() for folder in inputs["gaits"])
    (out / "library.txt").write_text(text)
    times = [facts["solve_s"] for facts in job.input_volatile["gaits"]]
    job.tracker.log_table({"solve_s": times}, "gaits")
    return {"gaits": len(inputs["gaits"])}
""",
    "standing": """
    (out / "policy.txt").write_text(str(section["train"]["iterations"]))
    return {}
""",
    "walking": """
    checkpoint = job.work / "checkpoint.txt"
    job.volatile["resumed"] = checkpoint.is_file()
    checkpoint.write_text("half way")
    (out / "half.txt").write_text("half")
    while (job.work.parents[3] / WAIT).exists():
        time.sleep(0.1)
    (out / "half.txt").unlink()
    iterations = section["train"]["iterations"]
    for step in range(iterations):
        job.tracker.log_metrics({"reward": step / 2}, step)
    library = (inputs["library"][0] / "library.txt").read_text()
    (out / "policy.txt").write_text(f"{iterations}\\n{library}")
    return {"reward": iterations / 2}
""",
    "evaluation": """
    policy = (inputs["walking"][0] / "policy.txt").read_text()
    (out / "records.txt").write_text(f"{section['speed']} {policy}")
    return {}
""",
    "table1": """
    records = [(folder / "records.txt").read_text() for folder in inputs["evaluations"]]
    for name in ("gait_quality.csv", "table1.md", "table1.tex"):
        (out / name).write_text("quality\\n")
    (out / "table1.csv").write_text("command\\n" + "\\n".join(records) + "\\n")
    return {}
""",
}
OTHER_BODY = """
    (out / "index.html").write_text(" ".join(sorted(inputs)))
    return {}
"""
WAIT = "wait"  # a file in the workspace, as long as which the dummy of a training goes on
HEADS = {
    "gait": """
from typing import TYPE_CHECKING
from slider.gait.tiny import speed
if TYPE_CHECKING:
    import casadi
""",
    "walking": f"""
import time
WAIT = "{WAIT}"
""",
}


@dataclass(frozen=True)
class Workspace:
    """A folder with a copy of the pipeline, and what happens in it."""

    folder: Path

    def snakemake(self, *arguments: str, hydra: str = "", **environment: str):
        """Run Snakemake with overrides; never raises."""
        words = ["-m", "snakemake", "-j2", *arguments, "--config", f"hydra=experiment=test {hydra}"]
        return self.command(words, **environment)

    def start(self, *arguments: str, hydra: str = "", **environment: str):
        """Start Snakemake with overrides, in a process group of its own; do not wait for it."""
        words = ["-m", "snakemake", "-j2", *arguments, "--config", f"hydra=experiment=test {hydra}"]
        return subprocess.Popen(
            [sys.executable, *words],
            cwd=self.folder,
            env=self._environment(environment),
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def wait_for_job(self, stage: str) -> int:
        """Process of the job of a stage, in this folder, as soon as it computes."""
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline:
            recipes = {path.name for path in (self.artefacts / "work" / stage).glob("*")}
            for path in Path("/proc").glob("[0-9]*/cmdline"):
                words = _words(path)
                matches = words[0].endswith("python") and recipes & set(words)
                if matches and path.with_name("cwd").resolve().is_relative_to(self.folder):
                    return int(path.parent.name)
            time.sleep(0.1)  # a look at all processes is not free
        raise AssertionError(f"no job of stage {stage} appeared")

    def _environment(self, extra: dict[str, str]) -> dict[str, str]:
        return os.environ | {"PYTHONPATH": str(self.folder / "src")} | extra

    def command(self, arguments: list[str], **environment: str):
        """Run a Python module in the workspace; its own sources come first."""
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            env=self._environment(environment),
            capture_output=True,
            text=True,
            check=False,
        )

    def slider(self, *arguments: str):
        """Run the command ``slider``."""
        return self.command(["-m", "slider.cli", *arguments])

    def computed(self, hydra: str = "", target: str = TABLE, **environment: str) -> list[str]:
        """Run the pipeline, expect success, and list the stages that were really computed.

        ``target`` may be several ones with blanks between them.
        """
        before = self._computations()
        done = self.snakemake(*target.split(), hydra=f"{hydra} {QUIET}", **environment)
        assert done.returncode == 0, f"{done.returncode}: {done.stderr}"
        return self.stages(before)

    def stages(self, before: Mapping[Path, str] = MappingProxyType({})) -> list[str]:
        """Stages of all jobs that were computed since certain ones; without these, of all jobs."""
        jobs = self._computations().items()
        return sorted(path.parent.name for path, start in jobs if before.get(path) != start)

    def _computations(self) -> dict[Path, str]:
        facts = {path: json.loads(path.read_text()) for path in self.artefacts.glob("*/*.run.json")}
        return {path: found["started"] for path, found in facts.items() if found["computed"]}

    @property
    def artefacts(self) -> Path:
        return self.folder / "artefacts"

    @property
    def table(self) -> Path:
        return self.folder / TABLE

    def manifests(self, stage: str) -> list[dict[str, Any]]:
        """Manifests of a stage."""
        paths = [p for p in (self.artefacts / stage).glob("*.json") if ".run." not in p.name]
        return [json.loads(path.read_text()) for path in paths]

    def objects(self, stage: str) -> set[str]:
        """Objects that the manifests of a stage name."""
        return {manifest["result"]["object"] for manifest in self.manifests(stage)}

    def copy(self, folder: Path) -> "Workspace":
        """The same with all that it computed, in another folder."""
        shutil.copytree(self.folder, folder, symlinks=True)
        return Workspace(folder)

    def edit(self, path: str, old: str, new: str) -> None:
        """Replace text that must be there in a file."""
        file = self.folder / path
        text = file.read_text()
        assert old in text
        file.write_text(text.replace(old, new))


def _words(path: Path) -> list[str]:
    try:
        return path.read_text().split("\0")
    except OSError:  # the process has ended
        return [""]


def copy_repository(folder: Path) -> Workspace:
    """Copy what the pipeline consists of, not what it produced."""
    shutil.copytree(_compiled(), folder, symlinks=True, dirs_exist_ok=True)
    return Workspace(folder)


@cache
def _compiled() -> Path:
    """The pipeline with its bytecode, once per session: each copy would compile it anew.

    The test processes write beside the sources of the repository; nobody writes here.
    """
    done, folder = shared.folder() / "repository.done", shared.folder() / "repository"
    with exclusive(shared.folder(), "repository"):
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            _copy_sources(folder)
            compile_all = ["-m", "compileall", "-q", "--invalidation-mode", "checked-hash"]
            compiled = Workspace(folder).command([*compile_all, "src", "pipeline"])
            assert compiled.returncode == 0, compiled.stderr
            done.touch()
    return folder


def _copy_sources(folder: Path) -> None:
    for name in COPIED:
        source = REPOSITORY / name
        if source.is_dir():
            no_bytecode = shutil.ignore_patterns("__pycache__")
            shutil.copytree(source, folder / name, ignore=no_bytecode)
        else:
            shutil.copy(source, folder / name)


def finished(folder: Path) -> Workspace:
    """A tracked pipeline that ran from nothing to its table and its page, in a hostile folder.

    All who ask for it with the same folder share it, in whatever process they are: the first one
    runs it while the others wait. Copy it before you change it.
    """
    done, workspace = folder / "finished.done", Workspace(folder / HOSTILE)
    with exclusive(folder, "finished"):
        if not done.exists():
            shutil.rmtree(workspace.folder, ignore_errors=True)
            run = copy_repository(workspace.folder).snakemake(TABLE, PAGE)
            assert run.returncode == 0, run.stderr
            done.touch()
    return workspace


def with_dummies(workspace: Workspace) -> Workspace:
    """Put stages in miniature in the place of the real ones."""
    source = workspace.folder / "src"
    modules: dict[Path, str] = {}
    stages = {STAGES[stage].entry: stage for stage in sorted(STAGES, key=BODIES.__contains__)}
    for stage in reversed([name for name in STAGES if name in stages.values()]):  # imports first
        module, _, function = STAGES[stage].entry.partition(":")
        path = source / f"{module.replace('.', '/')}.py"
        body = BODIES.get(stage, OTHER_BODY)
        text = f"def {function}(section, inputs, out, job):{body}\n\n"
        modules[path] = HEADS.get(stage, "") + "\n\n" + text + modules.get(path, "")
    for path, text in modules.items():
        path.write_text(text)
    (source / "slider" / "gait" / "tiny.py").write_text(
        "def speed(section):\n    return sum(section['velocity'])\n"
    )
    return workspace


def dummies_that_ran(session: Path, folder: Path) -> Workspace:
    """A copy of a pipeline of dummies that ran from nothing to its table, once per session."""
    done, workspace = session / "dummies.done", Workspace(session / "dummies")
    with exclusive(session, "dummies"):
        if not done.exists():
            shutil.rmtree(workspace.folder, ignore_errors=True)
            assert with_dummies(copy_repository(workspace.folder)).computed() == EVERYTHING
            done.touch()
    return workspace.copy(folder)
