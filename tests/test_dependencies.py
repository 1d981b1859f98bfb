"""What pyproject.toml declares is what is imported, and constraints.txt pins it."""

import re
import sys
import tomllib
from functools import cache
from importlib import metadata
from itertools import chain
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from pipeline.stages import table1_jobs
from pipeline.stages.entries import STAGES
from slider.artefacts.plan import build_plan
from slider.artefacts.recipe import closure, distribution
from tests.config.composed import composed
from tests.test_layers import imports

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = {name: list(map(Requirement, r)) for name, r in PROJECT["optional-dependencies"].items()}
REQUIRED = list(map(Requirement, PROJECT["dependencies"]))
OURS = {"slider", "pipeline", "tests"}


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def names(requirements: list[Requirement]) -> set[str]:
    return {normal(requirement.name) for requirement in requirements}


def imported(*folders: str) -> set[str]:
    """Top-level third-party packages that the Python files of some folders import."""
    paths = (path for folder in folders for path in (ROOT / folder).rglob("*.py"))
    found = {name.partition(".")[0] for path in paths for name in imports(path)}
    return found - OURS - sys.stdlib_module_names


packages = cache(metadata.packages_distributions)


def providers(package: str) -> set[str]:
    """Distributions with a package: several share a name space such as ``mlflow``."""
    known = packages().get(package) or {"pydrake": ["drake"]}.get(package)  # not of the tests
    found = None if known else distribution(package)
    return set(map(normal, known or ([found.name] if found else [])))


@pytest.mark.parametrize(
    ("folders", "extras"),
    [
        (("src", "pipeline"), ("verify", "remote", "gpu", "drake", "gymnasium")),
        (("tests",), ("test",)),
    ],
)
def test_what_is_imported_is_declared(folders, extras):
    declared = names(REQUIRED).union(*(names(EXTRAS[extra]) for extra in extras))
    assert {name for name in imported(*folders) if not providers(name) & declared} == set()


def test_table_1_needs_no_extra():
    """`make table1` installs none."""
    jobs = build_plan(table1_jobs(composed())).jobs.values()
    stages = {job.stage for job in jobs}
    modules = [STAGES[stage].entry.partition(":")[0] for stage in stages]
    used = imported("pipeline").union(*(closure(m, ROOT / "src")[1] for m in modules))
    assert {"torch", "casadi", "snakemake"} <= used
    assert {name for name in used if not providers(name) & names(REQUIRED)} == set()


def test_what_is_declared_is_imported():
    used = set().union(*map(providers, imported("src", "pipeline")))
    assert names(REQUIRED) - used == set()
    assert names(EXTRAS["verify"]) - used == set()


def test_each_requirement_has_a_pin():
    """Which lies in its range: else ``make`` cannot install it."""
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {normal(line.partition("==")[0]) for line in lines if "==" in line}
    assert names([*REQUIRED, *chain(*EXTRAS.values())]) <= pinned
