"""The integrity index: what was read is not read again until it may have changed."""

import os
import time
from pathlib import Path

import pytest
from slider.artefacts.integrity import IntegrityIndex

from slider.artefacts import integrity
from slider.core import files


@pytest.fixture
def folder(tmp_path) -> Path:
    """An object of two files."""
    folder = tmp_path / "object"
    (folder / "deep").mkdir(parents=True)
    for name in ("a.txt", "deep/b.txt"):
        (folder / name).write_text("0.0285")
    return folder


@pytest.fixture
def readings(monkeypatch) -> list[Path]:
    """Folders that were read."""
    folders: list[Path] = []
    table = files.file_table

    def noted(folder: Path):
        folders.append(folder)
        return table(folder)

    monkeypatch.setattr(files, "file_table", noted)
    return folders


@pytest.fixture
def noted(tmp_path, folder, monkeypatch) -> tuple[IntegrityIndex, str]:
    """An index with an entry of the object."""
    monkeypatch.setattr(integrity, "_TICK", -(10**9))  # as if all were old
    index, digest = IntegrityIndex(tmp_path / "index"), files.digest_table(files.file_table(folder))
    assert index.is_whole(digest, folder)
    return index, digest


def test_what_did_not_change_is_read_once(noted, folder, readings):
    index, digest = noted
    assert index.is_whole(digest, folder)
    assert readings == []
    index.drop(digest)
    assert index.is_whole(digest, folder)
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
def test_every_change_is_seen(noted, folder, change):
    index, digest = noted
    change(folder)
    assert not index.is_whole(digest, folder)


def test_an_entry_that_is_torn_counts_as_none(noted, folder, readings):
    index, digest = noted
    (entry,) = (path for path in index.root.rglob("*") if path.is_file())
    entry.write_text(entry.read_text()[:10])
    assert index.is_whole(digest, folder)
    assert readings == [folder]


def test_what_is_as_young_as_its_reading_gets_no_entry(tmp_path, folder):
    """It could change once more within the same tick and look the same."""
    index = IntegrityIndex(tmp_path / "index")
    assert index.is_whole(files.digest_table(files.file_table(folder)), folder)
    assert not any(path.is_file() for path in index.root.rglob("*"))


def test_without_a_place_for_entries_everything_is_read(noted, folder, tmp_path):
    _, digest = noted
    (tmp_path / "file").write_text("")
    index = IntegrityIndex(tmp_path / "file")
    assert index.is_whole(digest, folder)
    changed_in_place(folder)
    assert not index.is_whole(digest, folder)
    assert not index.is_whole(files.digest_table({}), tmp_path / "none")
