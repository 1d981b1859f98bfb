"""``make`` in any folder, with any override: what it runs, noted by a Python that does no more."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.workflow.workspace import HOSTILE

ROOT = Path(__file__).parents[1]
NOTES = """#!/bin/sh
for word in "$@"; do printf '%s\\n' "$word"; done > words.txt
cat words.txt >> all.txt
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A clone with a Python that writes its arguments down, a line each."""
    clone = tmp_path / HOSTILE
    (clone / ".venv/bin").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, clone / name)
    python = clone / ".venv/bin/python"
    python.write_text(NOTES)
    python.chmod(0o755)
    return clone


def make(folder: Path, *arguments: str) -> list[str]:
    """Words of the last command that Python got."""
    environment = {name: v for name, v in os.environ.items() if not name.startswith("MAKE")}
    done = subprocess.run(
        ["make", *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return (folder / "words.txt").read_text().splitlines()


@pytest.mark.parametrize(
    "overrides",
    ["", "experiment=smoke", "study.ablation.run=['a b',\"c\"]  seeds=$(touch pwned) `x`"],
)
def test_overrides_arrive_as_they_are_typed(folder, overrides):
    typed = overrides.replace("$", "$$")  # make's own sign
    words = make(folder, "table1", "CORES=3", f"HYDRA={typed}")
    assert words[:4] == ["-m", "snakemake", "-j3", "reports/table1.csv"]
    assert words[4:] == ["--config", f"hydra={overrides}"]
    assert not list(folder.rglob("pwned"))


def test_table_1_installs_no_tools_and_tests_add_them_in_either_order(folder):
    make(folder, "table1")
    installed = (folder / "all.txt").read_text()
    assert "\n-e\n.\n" in installed
    assert ".[test]" not in installed
    assert make(folder, "install")[-1] == ".[test]"
    (folder / "words.txt").unlink()
    make(folder, "table1")
    assert (folder / "all.txt").read_text().count("\ninstall\n") == 2  # nothing was done again


def test_the_tools_bring_what_table_1_needs(folder):
    assert make(folder, "install")[-1] == ".[test]"
    assert (folder / "all.txt").read_text().count("\ninstall\n") == 2
    assert make(folder, "table1")[1] == "snakemake"
    assert (folder / "all.txt").read_text().count("\ninstall\n") == 2


@pytest.mark.parametrize("target", ["test", "faults"])
def test_who_tests_gets_the_tools_first(folder, target):
    assert make(folder, target)[:2] == ["-m", "pytest"]
    assert ".[test]" in (folder / "all.txt").read_text().splitlines()
