"""A copy of the repository in which tests run the real Snakemake."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pipeline.stages.entries import STAGES
from tests import shared

REPOSITORY = Path(__file__).parents[2]
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
    (out / "gait.txt").write_text(f"{sum(section['velocity'])} {section['formulation']['nodes']}")
    return {"converged": True}
""",
    "library": """
    text = "\\n".join((folder / "gait.txt").read_text() for folder in inputs["gaits"])
    (out / "library.txt").write_text(text)
    return {"gaits": len(inputs["gaits"])}
""",
    "walking": """
    import time
    checkpoint = job.work / "checkpoint.txt"
    job.metadata["resumed"] = checkpoint.is_file()
    checkpoint.write_text("half way")
    (out / "half.txt").write_text("half")
    while (job.work.parents[3] / "wait").exists():
        time.sleep(0.1)
    (out / "half.txt").unlink()
    library = (inputs["library"][0] / "library.txt").read_text()
    (out / "policy.txt").write_text(f"{section['train']['iterations']}\\n{library}")
    return {}
""",
    "evaluation": """
    policy = (inputs["walking"][0] / "policy.txt").read_text()
    (out / "records.txt").write_text(f"{section['case']['segments'][0]['vx']} {policy}")
    return {}
""",
    "table1": """
    records = [(folder / "records.txt").read_text() for folder in inputs["evaluations"]]
    for name in ("gait_quality.csv", "gait_quality.md", "table1.md", "table1.tex", "tradeoff.svg"):
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


@dataclass(frozen=True)
class Workspace:
    """A folder with a copy of the pipeline, and what happens in it."""

    folder: Path

    def snakemake(self, *arguments: str, hydra: str = "", **environment: str):
        """Run Snakemake with overrides; never raises."""
        return self.command(_snakemake(arguments, hydra), **environment)

    def start(self, *arguments: str, hydra: str = "", **environment: str):
        """Start Snakemake with overrides, in a process group of its own; do not wait for it."""
        return subprocess.Popen(
            [sys.executable, *_snakemake(arguments, hydra)],
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


def _snakemake(arguments: Iterable[str], hydra: str) -> list[str]:
    return ["-m", "snakemake", "-j2", *arguments, "--config", f"hydra=experiment=test {hydra}"]


def _words(path: Path) -> list[str]:
    try:
        return path.read_text().split("\0")
    except OSError:  # the process has ended
        return [""]


def copy_repository(folder: Path) -> Workspace:
    """Copy what the pipeline consists of, not what it produced."""
    shutil.copytree(_compiled(), folder, symlinks=True, dirs_exist_ok=True)
    return Workspace(folder)


@shared.shared
def _compiled() -> Path:
    """The pipeline with its bytecode, once per session: each copy would compile it anew.

    The test processes write beside the sources of the repository; nobody writes here.
    """
    folder = shared.new_folder()
    for name in ("pipeline", "profiles", "conf", "src"):
        no_bytecode = shutil.ignore_patterns("__pycache__")
        shutil.copytree(REPOSITORY / name, folder / name, ignore=no_bytecode)
    shutil.copy(REPOSITORY / "Snakefile", folder)
    words = ["-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "src", "pipeline"]
    compiled = Workspace(folder).command(words)
    assert compiled.returncode == 0, compiled.stderr
    return folder


@shared.shared
def finished() -> Workspace:
    """A tracked pipeline that ran from nothing to its table and its page, in a hostile folder.

    All tests share it. Copy it before you change it.
    """
    workspace = copy_repository(shared.new_folder() / HOSTILE)
    done = workspace.snakemake(TABLE, PAGE)
    assert done.returncode == 0, done.stderr
    return workspace


def with_dummies(workspace: Workspace) -> Workspace:
    """Put stages in miniature in the place of the real ones."""
    modules: dict[Path, str] = {}
    stages = {STAGES[stage].entry: stage for stage in sorted(STAGES, key=BODIES.__contains__)}
    for entry, stage in stages.items():
        module, _, function = entry.partition(":")
        path = workspace.folder / f"src/{module.replace('.', '/')}.py"
        text = f"def {function}(section, inputs, out, job):{BODIES.get(stage, OTHER_BODY)}\n\n"
        modules[path] = modules.get(path, "") + text
    for path, text in modules.items():
        path.write_text(text)
    return workspace


@shared.shared
def dummies_that_ran() -> Workspace:
    """A pipeline of dummies that ran from nothing to its table. Copy it before you change it."""
    workspace = with_dummies(copy_repository(shared.new_folder()))
    assert workspace.computed() == EVERYTHING
    return workspace
