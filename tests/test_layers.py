"""What holds for every module: data flows one way, and no text is in the encoding of a locale."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from pipeline.stages.entries import STAGES
from slider.artefacts.recipe import closure

SOURCE = Path(__file__).parents[1] / "src"
ORDER = (
    *("robot", "gait", "library", "hzd", "verification", "env", "control", "training"),
    *("evaluation", "reports", "play", "composition", "gym", "commands"),
)
GROUND = {"core", "config", "artefacts", "tracking"}
ALLOWED = {
    "core": {"core"},
    "config": {"core", "config"},
    "artefacts": {"core", "artefacts"},
    "tracking": {"core", "artefacts", "tracking"},
} | {name: {*GROUND, *ORDER[: index + 1]} for index, name in enumerate(ORDER)}
MODULES = sorted(path for path in (SOURCE / "slider").rglob("*.py"))
PIPELINE = sorted((SOURCE.parent / "pipeline").rglob("*.py"))


@cache
def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "absolute imports only"
            # `from slider.robot import names` imports the module slider.robot.names.
            found.add(node.module)
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_modules_import_only_to_their_left():
    found = []
    for path in MODULES:
        name = path.relative_to(SOURCE / "slider").as_posix()
        package = name.partition("/")[0].removesuffix(".py")
        if package not in ALLOWED:
            assert name in ("__init__.py", "cli.py"), f"{name} has no place in the order"
            continue
        targets = (target.split(".") for target in imports(path))
        of_slider = {parts[1] for parts in targets if parts[0] == "slider" and len(parts) > 1}
        found += [f"{name} imports slider.{other}" for other in of_slider - ALLOWED[package]]
    assert found == []


def test_only_the_composition_knows_hydra_and_nothing_knows_snakemake():
    for path in MODULES:
        packages = {target.partition(".")[0] for target in imports(path)}
        assert not packages & {"snakemake", "pipeline"}, path
        name = path.relative_to(SOURCE / "slider").as_posix()
        if not name.startswith("composition/") and name != "commands/config.py":
            assert not packages & {"hydra", "omegaconf"}, path


def test_text_files_have_an_encoding():
    for path in (*MODULES, *PIPELINE):
        nodes = ast.walk(ast.parse(path.read_bytes()))
        calls = [node for node in nodes if isinstance(node, ast.Call)]
        found = [call.lineno for call in calls if takes_the_encoding_of_the_locale(call)]
        assert found == [], path


def takes_the_encoding_of_the_locale(call: ast.Call) -> bool:
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    if any(keyword.arg == "encoding" for keyword in call.keywords):
        return False
    if name in ("read_text", "write_text"):
        return len(call.args) == (name == "write_text")
    of_a_path = isinstance(call.func, ast.Attribute) and name == "open"
    modes = [m.value for m in call.args[not of_a_path :][:1] if isinstance(m, ast.Constant)]
    return name in ("open", "fdopen") and any(re.fullmatch("[rwaxt+]+", str(m)) for m in modes)


@pytest.mark.parametrize("stage", STAGES)
def test_stages_import_neither_hydra_nor_mlflow_nor_the_machinery(stage):
    parts, third_party = closure(STAGES[stage].entry.partition(":")[0], SOURCE)
    assert not {"hydra", "mlflow", "snakemake"} & {*third_party}
    assert stage != "gait" or not {"torch", "mujoco", "scipy"} & {*third_party}
    assert not {"slider.artefacts.runner", "slider.artefacts.store"} & parts.keys()
    assert "slider.config.reference" not in parts  # to reword errors recomputes nothing
    assert "slider.config.validation" not in parts
