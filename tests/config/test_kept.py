"""Kept compositions: used for the same files and overrides only, made again whatever is kept."""

from pathlib import Path

import pytest

from slider.config import kept, untyped
from slider.config.kept import composed
from slider.core.errors import UserError


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(kept, "_KEPT", tmp_path / "__pycache__")
    return tmp_path / "__pycache__"


@pytest.fixture
def conf(tmp_path: Path) -> Path:
    (tmp_path / "conf").mkdir()
    (tmp_path / "conf" / "config.yaml").write_text("value: 1\nothers: [1.0, null, true]\n")
    return tmp_path / "conf"


def forbid(monkeypatch: pytest.MonkeyPatch) -> None:
    def compose(*_: object) -> None:
        raise AssertionError("expected the kept composition")

    monkeypatch.setattr(untyped, "compose_untyped", compose)


def test_the_same_is_composed_once(conf: Path, monkeypatch):
    first = composed(["value=2"], conf)
    assert repr(first) == "{'value': 2, 'others': [1.0, None, True]}"
    forbid(monkeypatch)
    assert repr(composed(["value=2"], conf)) == repr(first)
    with pytest.raises(AssertionError, match="kept composition"):
        composed(["value=3"], conf)


def test_a_change_is_composed_again_even_in_the_same_size(conf: Path):
    assert composed([], conf)["value"] == 1
    (conf / "config.yaml").write_text("value: 2\nothers: [1.0, null, true]\n")
    assert composed([], conf)["value"] == 2


def test_a_new_file_is_seen(conf: Path):
    (conf / "config.yaml").write_text("defaults: [optional group: more]\n")
    assert composed([], conf) == {}
    (conf / "group").mkdir()
    (conf / "group" / "more.yaml").write_text("a: 1\n")
    assert composed([], conf) == {"group": {"a": 1}}


@pytest.mark.parametrize("old", ["1", "}", "\n"])
def test_a_damaged_file_is_not_believed(conf: Path, folder: Path, old: str):
    first = composed([], conf)
    (path,) = folder.iterdir()
    path.write_text(path.read_text().replace(old, "7", 1))
    assert composed([], conf) == first


def test_what_reads_the_environment_is_not_kept(conf: Path, monkeypatch):
    for text in ("value: ${oc.env:SPEED}\n", "value: ${joined:${oc.env:SPEED}}\n"):
        (conf / "config.yaml").write_text(text)
        found = []
        for speed in ("1", "2"):
            monkeypatch.setenv("SPEED", speed)
            found.append(composed([], conf))
        assert found[0] != found[1]
    (conf / "config.yaml").write_text("value: 1\n")
    assert composed(["value=${oc.env:SPEED}"], conf) == {"value": "2"}
    monkeypatch.setenv("SPEED", "3")
    assert composed(["value=${oc.env:SPEED}"], conf) == {"value": "3"}


def test_what_other_code_made_is_not_believed(conf: Path, monkeypatch):
    composed([], conf)
    monkeypatch.setattr(kept, "version", lambda name: "0")
    forbid(monkeypatch)
    with pytest.raises(AssertionError, match="kept composition"):
        composed([], conf)


def test_a_mistake_is_found_each_time(conf: Path):
    for _ in range(2):
        with pytest.raises(UserError, match="unknown configuration key 'valu'"):
            composed(["valu=2"], conf)


def test_the_oldest_go(conf: Path, folder: Path, monkeypatch):
    monkeypatch.setattr(kept, "_MOST", 2)
    for value in (2, 3, 4):
        composed([f"value={value}"], conf)
    assert len([*folder.iterdir()]) == 2


def test_without_a_place_for_files_all_is_composed(conf: Path, monkeypatch):
    monkeypatch.setattr(kept, "_KEPT", conf / "config.yaml")
    assert composed([], conf)["value"] == 1
