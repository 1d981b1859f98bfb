"""Kept analyses: used for the same bytes only, made again whatever is in the file."""

from pathlib import Path

import pytest

from slider.artefacts.source import analyses
from slider.artefacts.source.analyses import Analyses
from slider.artefacts.source.syntax import Module


@pytest.fixture
def module(tmp_path: Path) -> Path:
    path = tmp_path / "module.py"
    path.write_text("import json\n")
    return path


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    return tmp_path / "__pycache__" / "analyses.json"


def read(kept: Path, module: Path) -> Module:
    """Analysis of a module by a process of its own."""
    own = Analyses(kept)
    found = own.read(module, "package.module")
    own.keep()
    return found


def forbid(monkeypatch: pytest.MonkeyPatch) -> None:
    def parse(*_: object) -> Module:
        raise AssertionError("expected the kept analysis")

    monkeypatch.setattr(analyses, "analyse", parse)


def test_the_same_bytes_are_parsed_once(kept: Path, module: Path, monkeypatch):
    first = read(kept, module)
    assert first.imports == ("json",)
    forbid(monkeypatch)
    assert read(kept, module) == first


def test_a_change_is_parsed_again_even_in_the_same_time_and_size(kept: Path, module: Path):
    first = read(kept, module)
    module.write_text("import math\n")
    second = read(kept, module)
    assert second.imports == ("math",)
    assert second.digest != first.digest


def test_a_package_of_the_same_bytes_is_another_module(kept: Path, tmp_path: Path):
    for name in ("module.py", "__init__.py"):
        (tmp_path / name).write_text("from . import other\n")
    assert read(kept, tmp_path / "module.py").imports == ("package", "package.other")
    found = read(kept, tmp_path / "__init__.py").imports
    assert found == ("package.module", "package.module.other")


@pytest.mark.parametrize("old", ["json", "}", "\n"])
def test_a_damaged_file_is_not_believed(kept: Path, module: Path, old: str):
    first = read(kept, module)
    text = kept.read_text()
    assert old in text
    kept.write_text(text.replace(old, "jsox", 1))
    assert read(kept, module) == first


def test_what_other_code_found_out_is_not_believed(kept: Path, module: Path, monkeypatch):
    read(kept, module)
    monkeypatch.setattr(analyses, "_MAKER", analyses.hashlib.sha256(b"other"))
    forbid(monkeypatch)
    with pytest.raises(AssertionError, match="kept analysis"):
        read(kept, module)


def test_without_a_place_for_the_file_all_is_parsed(module: Path):
    assert read(module / "analyses.json", module).imports == ("json",)
