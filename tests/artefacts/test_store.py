"""The store: publication, manifests, content that is read once, locks between processes."""

import errno
import multiprocessing
import os
import shutil
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from slider.artefacts.maintenance import Removed, summarise, verify
from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.store import Timeout, exclusive, nobody_else
from slider.core.errors import UserError
from tests.artefacts.samples import GAITS, compute, damage, data, forge


@pytest.fixture
def manifest(store) -> Manifest:
    return compute(store, GAITS[0])


def test_same_content_is_one_read_only_object_whoever_computed_it(store):
    first, second = compute(store, GAITS[0]), compute(store, GAITS[0])
    assert first == second
    assert compute(store, GAITS[1]).result.object != first.result.object
    assert len(store.objects()) == 2
    assert not list((store.root / "objects" / "tmp").iterdir())
    assert data(store, first).stat().st_mode & 0o222 == 0


def test_who_may_write_beside_an_object_may_remove_it(store, monkeypatch):
    """Several users of one store repair and clean up, with the umask of the how-to."""
    kept = os.umask(0o002)
    try:
        digest = compute(store, GAITS[0]).result.object
    finally:
        os.umask(kept)
    assert store.object_folder(digest).stat().st_mode & 0o777 == 0o775
    refused = PermissionError(errno.EACCES, "Permission denied")
    monkeypatch.setattr(os, "rmdir", Mock(side_effect=refused))
    line = f"^expected to remove .*/objects/{digest[:2]}/{digest}, found: Permission denied$"
    with pytest.raises(UserError, match=line):
        store.drop_object(digest)


BROKEN = {
    "bytes": b"\xff\xfe",
    "no mapping": b"[]",
    "no result": {"result": "fine"},
    "recipe of an input": {"inputs": {"gaits": [3]}},
    "input objects": {"input_objects": {"gaits": None}},
    "more": {"more": 1},
}


@pytest.mark.parametrize(("name", "signed"), [("more", False), *((name, True) for name in BROKEN)])
def test_what_is_no_manifest_is_one_line_and_counts_as_absent(store, manifest, name, signed):
    """Also where its own digest fits to it."""
    path, (entry,) = store.manifest_path("gait", manifest.recipe), store.index()
    for broken in (path, entry):
        if isinstance(change := BROKEN[name], bytes):
            broken.write_bytes(change)
        else:
            forge(broken, signed, **change)
    with pytest.raises(UserError, match="expected a manifest, found something else in"):
        parse_manifest(path)
    assert store.find(entry.stem) is None
    assert summarise(store) == {}
    assert len(verify(store).unreadable) == 2
    assert verify(store) == Removed([], [])


def test_entries_under_the_name_of_another_are_dropped(store):
    compute(store, GAITS[0])
    compute(store, GAITS[1])
    for first, second in (store.manifests(), store.index()):
        first.replace(second)
    assert store.find(second.stem) is None
    (path,) = store.manifests()
    assert store.verify("gait", path.stem) is None
    with pytest.raises(UserError, match="expected a manifest, found that of another job in"):
        parse_manifest(path)
    assert len(verify(store).unreadable) == 2
    assert verify(store) == Removed([], [])


def replaced(path: Path) -> None:
    (path.parent / "new").write_text("B" * path.stat().st_size)
    (path.parent / "new").replace(path)


CHANGES = [
    damage,
    replaced,
    Path.unlink,
    lambda path: (path.parent / "link").symlink_to("data.txt"),
    lambda path: shutil.rmtree(path.parents[1]),
]


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_object_is_forgotten_until_it_is_published_again(store, manifest, change):
    (entry,) = store.index()
    change(data(store, manifest))
    assert store.find(entry.stem) is None
    compute(store, GAITS[0])
    assert store.find(entry.stem) == manifest
    change(data(store, manifest))
    assert verify(store).manifests == [f"gait/{manifest.recipe}.json"]
    assert store.manifests() == []


def test_a_name_is_held_until_its_process_ends_however_it_does(tmp_path: Path):
    fork = multiprocessing.get_context("fork")
    held = fork.Event()

    def hold() -> None:
        with exclusive(tmp_path, "x"):
            held.set()
            time.sleep(60)

    holder = fork.Process(target=hold)
    holder.start()
    assert held.wait(60)
    with pytest.raises(Timeout), exclusive(tmp_path, "x", timeout=0):
        pass
    message = f"^expected no running job in {tmp_path.parent}, found one$"
    with exclusive(tmp_path, "y"), pytest.raises(UserError, match=message):
        nobody_else(tmp_path).__enter__()
    holder.kill()
    holder.join()
    with nobody_else(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["all.lock"]
    with exclusive(tmp_path, "x"):
        pass


@pytest.mark.parametrize("name", ["locks", "locks/all.lock"])
def test_something_else_in_the_place_of_a_lock_is_one_line(tmp_path: Path, name: str):
    (tmp_path / "locks").touch() if name == "locks" else (tmp_path / name).mkdir(parents=True)
    for attempt in (exclusive(tmp_path / "locks", "x"), nobody_else(tmp_path / "locks")):
        with pytest.raises(UserError, match=r"expected a lock file at .*\.lock, found: "), attempt:
            pass
