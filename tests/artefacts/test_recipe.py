"""Recipes: what counts as a change of a stage's code, and the versions of packages."""

import shutil
import uuid
from importlib import metadata
from pathlib import Path

import pytest

from slider.artefacts.recipe import NOT_INSTALLED, closure, code_of, versions
from slider.core.errors import UserError

FILES = {
    "slider/__init__.py": "",
    "slider/gait/__init__.py": "",
    "slider/gait/stage.py": '''"""A stage."""
import numpy as np
from slider.gait import solve


def run():
    """Run."""
    from slider.robot.names import JOINTS  # inside a function
    return solve.solve(JOINTS)
''',
    "slider/gait/solve.py": "import json\nfrom ..robot import names\n\ndef solve(x): return x\n",
    "slider/robot/__init__.py": "",
    "slider/robot/names.py": 'class Link:\n    mass: float\n    """mass"""\n\nJOINTS = (1, 2)\n',
    "slider/env/__init__.py": "",
    "slider/env/other.py": "import torch\n",
}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def digest(root: Path) -> str:
    copy = root / str(uuid.uuid4())  # what was read once is not read again
    shutil.copytree(root / "slider", copy / "slider")
    return code_of("slider.gait.stage:run", copy).source


def test_follows_all_imports_and_nothing_else(root):
    parts, third_party = closure("slider.gait.stage", root)
    modules = ("slider", "slider.gait", "slider.gait.solve", "slider.gait.stage")
    assert (*parts,) == (*modules, "slider.robot", "slider.robot.names")
    assert third_party == ("numpy",)


@pytest.mark.parametrize(
    ("name", "old", "new", "counts"),
    [
        ("gait/stage.py", "inside a function", "another comment", False),
        ("gait/stage.py", '"""Run."""', '"""Do something else,\n\n    at length.\n    """', False),
        ("gait/stage.py", '"""A stage."""', "# no docstring", False),
        ("gait/solve.py", "return x", "return (x)  # parentheses and\n\n", False),
        ("robot/names.py", '"""mass"""', '"""what a body weighs"""', False),
        ("env/other.py", "import torch", "import casadi", False),
        ("robot/names.py", "(1, 2)", "(1, 3)", True),
        ("robot/__init__.py", "", "import math\n", True),
        ("gait/__init__.py", "", "X = 1\n", True),
        ("gait/table.csv", "", "1,2\n", True),
        ("gait/data/table.csv", "", "1,2\n", True),
        ("gait/table-LAPTOP.csv", "", "1,2\n", False),  # of others, beside the source
        ("gait/.table.csv", "", "1,2\n", False),
        ("gait/data (1)/table.csv", "", "1,2\n", False),
    ],
)
def test_what_runs_counts_and_nothing_else(root, name, old, new, counts):
    before, path = digest(root), root / "slider" / name
    path.parent.mkdir(exist_ok=True)
    text = path.read_text() if old else ""
    assert old in text
    path.write_text(text.replace(old, new))
    assert (digest(root) != before) == counts


@pytest.mark.parametrize(
    "block",
    [
        "try:\n pass\nexcept OSError:\n import casadi",
        "try:\n pass\nfinally:\n import casadi",
        "for _ in ():\n while True:\n  with open(''):\n   import casadi",
        "match 1:\n case 2:\n  import casadi",
        "class A:\n async def f(self):\n  import casadi",
    ],
)
def test_finds_imports_in_every_kind_of_block(root, block):
    (root / "slider/robot/names.py").write_text(f"{block}\n")
    assert closure("slider.gait.stage", root)[1] == ("casadi", "numpy")


def test_names_the_missing_module_and_the_line_that_does_not_parse(root):
    with pytest.raises(UserError, match=r"slider\.gait\.nothing"):
        closure("slider.gait.nothing", root)
    (root / "slider/robot/names.py").write_text("JOINTS =\n")
    with pytest.raises(UserError, match=r"slider\.robot\.names, line 1"):
        digest(root)


def test_version_by_package_name_even_where_the_distribution_is_called_otherwise():
    """Pinocchio lies below a prefix; some packages are optional."""
    names = {"casadi": "casadi", "rsl_rl": "rsl-rl-lib", "yaml": "PyYAML", "pinocchio": "pin"}
    expected = {package: metadata.version(name) for package, name in names.items()}
    expected |= {"no_such_package": NOT_INSTALLED}
    assert expected.items() <= versions((*expected,)).items()


def test_package_without_distribution_is_refused(tmp_path, monkeypatch):
    (tmp_path / "orphan.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(UserError, match="expected an installed distribution with package orphan"):
        versions(("orphan",))
