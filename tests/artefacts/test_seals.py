"""Seals: what was read is not read again until it may have changed."""

import os
import time
from pathlib import Path

import pytest
from slider.artefacts.seals import Seals

from slider.artefacts import seals
from slider.core import files


@pytest.fixture
def folder(tmp_path) -> Path:
    """An object of two files that has been lying there for a while."""
    folder = tmp_path / "object"
    (folder / "deep").mkdir(parents=True)
    for name in ("a.txt", "deep/b.txt"):
        (folder / name).write_text("0.0285")
    return folder


@pytest.fixture
def readings(monkeypatch) -> list[Path]:
    """Folders that were read."""
    found: list[Path] = []
    table = files.file_table

    def noted(folder: Path):
        found.append(folder)
        return table(folder)

    monkeypatch.setattr(files, "file_table", noted)
    return found


@pytest.fixture
def sealed(tmp_path, folder, monkeypatch) -> tuple[Seals, str]:
    monkeypatch.setattr(seals, "_TICK", -(10**9))  # as if all were old
    found, digest = Seals(tmp_path / "seals"), files.digest_table(files.file_table(folder))
    assert found.is_whole(digest, folder)
    return found, digest


def test_what_did_not_change_is_read_once(sealed, folder, readings):
    seals, digest = sealed
    assert seals.is_whole(digest, folder)
    assert readings == []
    seals.drop(digest)
    assert seals.is_whole(digest, folder)
    assert readings == [folder]


def changed_in_place(folder: Path) -> None:
    """Same size, same time of modification."""
    times = (folder / "a.txt").stat()
    time.sleep(0.02)
    (folder / "a.txt").write_text("0.0485")
    os.utime(folder / "a.txt", ns=(times.st_atime_ns, times.st_mtime_ns))


def replaced(folder: Path) -> None:
    (folder / "new").write_text("0.0485")
    (folder / "new").replace(folder / "deep" / "b.txt")


@pytest.mark.parametrize(
    "change",
    [
        changed_in_place,
        replaced,
        lambda folder: (folder / "a.txt").unlink(),
        lambda folder: (folder / "deep" / "more.txt").write_text(""),
        lambda folder: (folder / "deep" / "link").symlink_to("b.txt"),
    ],
)
def test_every_change_is_seen(sealed, folder, change):
    seals, digest = sealed
    change(folder)
    assert not seals.is_whole(digest, folder)


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_torn_seal_is_none(sealed, folder, tmp_path, readings, share):
    seals, digest = sealed
    readings.clear()
    (seal,) = (path for path in (tmp_path / "seals").rglob("*") if path.is_file())
    text = seal.read_text()
    seal.write_text(text[: int(share * len(text))])
    assert seals.is_whole(digest, folder)
    assert readings == [folder]


def test_what_is_as_young_as_its_reading_is_read_again(tmp_path, folder, readings):
    """It could change once more within the same tick and look the same."""
    digest = files.digest_table(files.file_table(folder))
    seals = Seals(tmp_path / "seals")
    readings.clear()
    assert seals.is_whole(digest, folder)
    assert seals.is_whole(digest, folder)
    assert readings == [folder, folder]


def test_without_a_place_for_seals_everything_is_read(sealed, folder, tmp_path):
    _, digest = sealed
    (tmp_path / "file").write_text("")
    seals = Seals(tmp_path / "file")
    assert seals.is_whole(digest, folder)
    changed_in_place(folder)
    assert not seals.is_whole(digest, folder)


def test_what_is_not_there_is_not_whole(tmp_path):
    nothing = files.digest_table({})
    assert not Seals(tmp_path / "seals").is_whole(nothing, tmp_path / "none")
