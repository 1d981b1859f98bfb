"""``make`` in any folder, with any override: what it runs, noted by a Python that does no more."""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from slider.core.machine import cores
from tests.workflow.workspace import HOSTILE

ROOT = Path(__file__).parents[1]
NOTES = """#!/bin/sh
case "$*" in *"open("*|*"cores()"*) exec "{python}" "$@";; esac
for word in "$@"; do printf '%s\\n' "$word"; done > words.txt
cat words.txt >> all.txt
env | grep -E "^PIP_(USER|TARGET|PREFIX)=" > pip.txt
true
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A clone with a Python that writes its arguments down, a line each."""
    clone = tmp_path / HOSTILE
    (clone / ".venv/bin").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, clone / name)
    python = clone / ".venv/bin/python"
    python.write_text(NOTES.replace("{python}", sys.executable))
    python.chmod(0o755)
    (clone / ".venv/place").write_text(str(clone), encoding="utf-8")
    return clone


def call(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    env = {name: v for name, v in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.run(["make", *arguments], cwd=folder, env=env, capture_output=True, text=True)


def make(folder: Path, *arguments: str) -> list[str]:
    """Words of the last command that Python got."""
    done = call(folder, *arguments)
    assert done.returncode == 0, done.stderr
    return (folder / "words.txt").read_text().splitlines()


@pytest.mark.parametrize(
    "overrides",
    ["", "experiment=smoke", "study.ablation.run=['a b',\"c\"]  seeds=$(touch pwned) `x`"],
)
def test_overrides_arrive_as_they_are_typed(folder, overrides):
    typed = overrides.replace("$", "$$")  # make's own sign
    words = make(folder, "table1", "CORES=3", f"HYDRA={typed}")
    assert words[2:] == ["snakemake", "-j3", "reports/table1.csv", "--config", f"hydra={overrides}"]
    assert not list(folder.rglob("pwned"))


def test_cores_are_those_of_this_machine_whatever_openmp_may_use(folder, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "16")
    assert make(folder, "table1")[3] == f"-j{cores()}"


def test_table_1_installs_no_tools_and_tests_add_them_in_either_order(folder, monkeypatch):
    """Into the environment, whatever pip does elsewhere."""
    for name in ("PIP_USER", "PIP_TARGET", "PIP_PREFIX"):
        monkeypatch.setenv(name, "1")
    make(folder, "table1")
    assert (folder / "pip.txt").read_text() == "PIP_USER=0\n"
    installed = (folder / "all.txt").read_text()
    assert "\n-e\n.\n" in installed
    assert ".[test]" not in installed
    assert make(folder, "install")[-1] == ".[test]"
    (folder / "words.txt").unlink()
    make(folder, "table1")
    assert (folder / "all.txt").read_text().count("\ninstall\n") == 2  # nothing was done again


@pytest.mark.parametrize("target", ["test", "faults"])
def test_who_tests_gets_the_tools_first(folder, target):
    assert make(folder, target)[:3] == ["-I", "-m", "pytest"]
    assert ".[test]" in (folder / "all.txt").read_text().splitlines()


SETUP = """#!/bin/sh
case "$*" in
  "-I -m venv .venv") mkdir -p .venv/bin && cp made-by-venv .venv/bin/python;;
  *) exec "{python}" "$@";;
esac
"""


@pytest.fixture
def maker(folder: Path) -> str:
    """A Python whose ``-m venv`` gives the environment the Python that notes its arguments."""
    shutil.copy2(folder / ".venv/bin/python", folder / "made-by-venv")
    maker = folder / "python"
    maker.write_text(SETUP.format(python=sys.executable))
    maker.chmod(0o755)
    return "PYTHON=./python"


def test_a_copied_or_moved_environment_is_made_anew(folder, maker):
    make(folder, "table1", maker)
    (folder / ".venv/left").touch()
    make(folder, "table1", maker)
    assert (folder / ".venv/left").exists()
    copy = shutil.copytree(folder, folder.with_name("copy"))
    for elsewhere in (copy, folder.rename(folder.with_name("moved"))):
        make(elsewhere, "table1", maker)
        assert not (elsewhere / ".venv/left").exists()
        assert (elsewhere / ".venv/place").read_text() == str(elsewhere)


@pytest.mark.parametrize(
    ("name", "text"),
    [("bin/python", "#!/bin/sh\nexit 1\n"), ("bin/python", "no program"), ("place", "")],
)
def test_a_broken_environment_or_one_that_was_begun_is_made_anew(folder, maker, name, text):
    (folder / ".venv" / name).write_text(text)
    assert make(folder, "table1", maker)[2] == "snakemake"


@pytest.mark.parametrize("kind", ["own", "linked"])
def test_an_environment_of_somebody_else_stays(folder, maker, kind):
    (folder / ".venv/place").unlink()
    (folder / ".venv").rename(folder / "elsewhere")
    if kind == "own":
        (folder / "elsewhere").rename(folder / ".venv")
    else:
        (folder / ".venv").symlink_to("elsewhere")
    done = call(folder, "table1", maker)
    assert done.returncode
    assert "expected no .venv or one that make made, found another: move it away" in done.stderr
    assert (folder / ".venv/bin/python").exists()


def test_the_supported_pythons_are_the_same_everywhere():
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["requires-python"]
    assert needs == ">=3.11,<3.14"
    for name in ("README.md", "docs/tutorial.md"):
        assert "Python 3.11 to 3.13" in (ROOT / name).read_text()


@pytest.mark.parametrize("version", [(3, 10, 2), (3, 14, 0)])
def test_another_python_is_one_line_and_leaves_no_environment(folder, version):
    old, found = folder / "old", ".".join(map(str, version))
    check = f"import sys; sys.version_info = {version}; sys.version = '{found} x'"
    old.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{check}; $(echo "$3" | tail -c +12)"\n')
    old.chmod(0o755)
    shutil.rmtree(folder / ".venv")
    done = call(folder, "table1", "PYTHON=./old")
    assert done.returncode
    assert f"expected Python 3.11 to 3.13, found {found}" in done.stderr
    assert not (folder / ".venv").exists()
