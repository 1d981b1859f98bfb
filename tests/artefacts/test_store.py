"""The store: publication, manifests, content that is read once, locks between processes."""

import multiprocessing
import os
import shutil
import time
from pathlib import Path

import pytest

from slider.artefacts.maintenance import verify
from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.store import Timeout, exclusive, exclusive_store
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


def test_who_may_write_beside_an_object_may_remove_it(store):
    """Several users of one store repair and clean up, with the umask of the how-to."""
    kept = os.umask(0o002)
    try:
        digest = compute(store, GAITS[0]).result.object
    finally:
        os.umask(kept)
    assert store.object_folder(digest).stat().st_mode & 0o777 == 0o775


BROKEN = {
    "bytes": b"\xff\xfe",
    "no mapping": b"[]",
    "no result": {"result": "fine"},
    "recipe of an input": {"inputs": {"gaits": [3]}},
    "input objects": {"input_objects": {"gaits": None}},
    "more": {"more": 1},
}


def entry_of(store) -> Path:
    """The only entry of the index."""
    (path,) = store.root.glob("index/*/*.json")
    return path


@pytest.mark.parametrize(("name", "signed"), [("more", False), *((name, True) for name in BROKEN)])
def test_what_is_no_manifest_is_one_line_and_counts_as_absent(store, manifest, name, signed):
    """Also where its own digest fits to it."""
    path, entry = store.manifest_path("gait", manifest.recipe), entry_of(store)
    for broken in (path, entry):
        if isinstance(change := BROKEN[name], bytes):
            broken.write_bytes(change)
        else:
            forge(broken, signed, **change)
    with pytest.raises(UserError, match="expected a manifest, found something else in"):
        parse_manifest(path)
    assert store.find(entry.stem) is None
    assert len(verify(store)) == 1
    assert verify(store) == []


def test_a_manifest_under_the_name_of_another_is_dropped(store):
    compute(store, GAITS[0])
    compute(store, GAITS[1])
    first, second = store.manifests()
    first.replace(second)
    assert store.verify("gait", second.stem) is None
    with pytest.raises(UserError, match="expected a manifest, found that of another job in"):
        parse_manifest(second)
    assert len(verify(store)) == 1
    assert verify(store) == []


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
    key = entry_of(store).stem
    change(data(store, manifest))
    assert store.find(key) is None
    compute(store, GAITS[0])
    assert store.find(key) == manifest
    change(data(store, manifest))
    assert len(verify(store)) == 1
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
        exclusive_store(tmp_path).__enter__()
    holder.kill()
    holder.join()
    with exclusive_store(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["all.lock"]
    with exclusive(tmp_path, "x"):
        pass
