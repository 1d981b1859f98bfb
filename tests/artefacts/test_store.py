"""The store: publication, manifests, verification, collection."""

import errno
import json
import os
import time
from dataclasses import replace
from pathlib import Path

import pytest

from slider.artefacts import store as store_module
from slider.artefacts.maintenance import (
    Removed,
    collect,
    date_now,
    drop_damaged,
    summarise,
    verify,
)
from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.plan import JobSpec, build_plan, read_plan, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError

CODE = Code("slider.none:run", "abc", {"python": "3.11"})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "artefacts")


def publish(store: Store, content: str, name: str = "deep/data.txt"):
    with store.temporary("test") as out:
        (out / name).parent.mkdir(exist_ok=True, parents=True)
        (out / name).write_text(content)
        return store.publish(out, {"n": 1})


def add(store: Store, spec: JobSpec, content: str, inputs: tuple[Manifest, ...] = ()) -> Manifest:
    """Store a result with its manifest and index entry."""
    recipes = {"inputs": [one.recipe for one in inputs]}
    objects = {"inputs": [one.result.object for one in inputs]}
    manifest = Manifest("gait", spec.recipe, recipes, publish(store, content), objects)
    store.remember(spec.recipe, manifest)
    store.write_manifest(manifest)
    return manifest


def damage(store: Store, digest: str) -> None:
    path = store.object_folder(digest) / "deep" / "data.txt"
    path.chmod(0o644)
    path.write_text("B" * len(path.read_text()))  # same size


def spec(value: int) -> JobSpec:
    return JobSpec("gait", f"job {value}", CODE, {"value": value})


def test_same_content_is_one_read_only_object_wherever_it_was_made(store):
    first, second = publish(store, "A"), publish(store, "A")
    assert first == second
    assert publish(store, "A", "other.txt").object != first.object
    assert len(list((store.root / "objects").glob("*/*"))) == 2
    assert not list((store.root / "tmp").iterdir())
    path = store.object_folder(first.object) / "deep" / "data.txt"
    assert path.stat().st_mode & 0o222 == 0


def test_publishing_replaces_a_damaged_object(store):
    result = publish(store, "A")
    assert store.is_whole(result.object)
    damage(store, result.object)
    assert not store.is_whole(result.object)
    publish(store, "A")
    assert store.is_whole(result.object)


def test_links_are_refused(store):
    with store.temporary("test") as out:
        (out / "link").symlink_to("/etc/passwd")
        with pytest.raises(ValueError, match=r"^expected files and folders, found another kind: "):
            store.publish(out, {})


def test_full_disk_leaves_nothing_visible(store, monkeypatch):
    def no_space(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    for call in ("rename", "fsync"):
        monkeypatch.setattr(os, call, no_space)
    with pytest.raises(OSError, match="No space left on device"):
        publish(store, "A")
    with pytest.raises(OSError, match="No space left on device"):
        files.write_json(store.root / "x.json", {})
    assert not [path for path in store.root.rglob("*") if path.is_file()]


def test_manifest_round_trip_holds_nothing_volatile(store):
    manifest = add(store, spec(1), "A")
    path = store.manifest_path("gait", manifest.recipe)
    assert parse_manifest(path) == manifest
    volatile = {"schema", "stage", "recipe", "inputs", "input_objects", "key", "digest"}
    assert json.loads(path.read_text()).keys() == volatile | {"object", "files", "summary"}
    files.write_json(path, {"mse": float("inf"), "n": (1, 2)})
    assert files.read_json(path) == {"mse": "inf", "n": [1, 2]}


BROKEN = {
    "bytes": b"\xff\xfe",
    "no mapping": b"[]",
    "files": {"files": []},
    "size": {"files": {"deep/data.txt": {"sha256": "0", "size": "1"}}},
    "file": {"files": {"deep/data.txt": 3}},
    "object": {"object": 3},
    "other object": {"object": "0" * 64},
    "summary": {"summary": "fine"},
    "inputs": {"inputs": []},
    "input": {"inputs": {"gaits": 3}},
    "recipe of an input": {"inputs": {"gaits": [3]}},
    "input objects": {"input_objects": {"gaits": None}},
    "resumed": {"resumed": "no"},
    "stage": {"stage": 3},
}


CASES = [("summary of another", {"summary": {"n": 2}}, False)]
CASES += [(name, change, signed) for name, change in BROKEN.items() for signed in (False, True)]


@pytest.mark.parametrize(("name", "change", "signed"), CASES)
def test_what_is_no_manifest_is_one_line_and_counts_as_absent(store, name, change, signed):
    """Also where its own digest was written anew."""
    recipe = add(store, spec(1), "A").recipe
    path, entry = store.manifest_path("gait", recipe), store.index_path(recipe)
    for broken in (path, entry):
        if isinstance(change, bytes):
            broken.write_bytes(change)
            continue
        values = files.read_json(broken) | change
        others = {name: value for name, value in values.items() if name != "digest"}
        values |= {"digest": files.digest_value(others)} if signed else {}
        broken.write_text(json.dumps(values))
    with pytest.raises(UserError, match="expected a manifest, found something else in"):
        parse_manifest(path)
    assert store.known(recipe) is None
    assert summarise(store) == []
    removed = verify(store)
    names = {one.relative_to(store.root).as_posix() for one in (path, entry)}
    assert (set(removed.unreadable), removed.objects, removed.manifests) == (names, [], [])
    assert verify(store) == Removed([], [])


def test_entries_under_the_name_of_another_are_dropped(store):
    """Two index entries and two manifests were swapped."""
    manifests = [add(store, spec(value), str(value)) for value in (1, 2)]
    paths = [store.manifest_path("gait", one.recipe) for one in manifests]
    entries = [store.index_path(one.recipe) for one in manifests]
    for first, second in (paths, entries):
        text = first.read_text()
        first.write_text(second.read_text())
        second.write_text(text)
    for manifest, path in zip(manifests, paths, strict=True):
        assert store.known(manifest.recipe) is None
        assert store.whole("gait", manifest.recipe) is None
        with pytest.raises(UserError, match="expected a manifest, found that of another job in"):
            parse_manifest(path)
    assert len(verify(store).unreadable) == 4
    assert verify(store) == Removed([], [])


def test_a_manifest_whose_object_is_gone_is_dropped_and_forgotten(store):
    manifest = add(store, spec(1), "A")
    path = store.manifest_path("gait", manifest.recipe)
    assert store.known(manifest.recipe) == manifest
    assert store.drop_dangling([path]) == []
    store.drop_object(manifest.result.object)
    assert store.known(manifest.recipe) is None
    assert store.drop_dangling([path]) == [path]
    path.write_text("{")
    assert store.drop_dangling([path]) == [path]
    assert not path.exists()


def test_verify_reads_every_byte(store, monkeypatch):
    """A disk changed content below the file system: inode, size and times are as before."""
    manifest = add(store, spec(1), "A")
    digest = manifest.result.object
    monkeypatch.setattr(store_module, "_TICK", -(10**9))
    monkeypatch.setattr(store_module, "_look", lambda folder: ("as before", 0))
    assert verify(store) == Removed([], [])
    damage(store, digest)
    assert store.is_whole(digest)
    assert verify(store).objects == [digest]
    assert verify(store) == Removed([], [])


def test_verify_drops_what_is_corrupt_and_all_that_came_from_it(store):
    first = add(store, spec(0), "A")
    second = add(store, spec(1), "B", (first,))
    third = add(store, spec(2), "C", (second,))
    other = add(store, spec(9), "other")
    damage(store, first.result.object)
    removed = verify(store)
    assert removed.objects == [first.result.object]
    assert removed.manifests == [f"gait/{first.recipe}.json"]
    assert set(removed.derived) == {f"gait/{one.recipe}.json" for one in (second, third)}
    assert [path.stem for path in store.manifests()] == [other.recipe]
    assert [path.stem for path in store.index()] == [other.recipe]
    assert verify(store) == Removed([], [])


def test_a_manifest_remembers_its_inputs_without_the_way_to_them(store):
    """The manifest in between is gone: the objects that were read say enough."""
    first = add(store, spec(0), "A")
    second = add(store, spec(1), "B", (first,))
    add(store, spec(2), "C", (second,))
    store.write_manifest(replace(second, inputs={"inputs": ["0" * 64]}))
    store.manifest_path("gait", first.recipe).unlink()
    store.index_path(first.recipe).unlink()
    damage(store, first.result.object)
    assert len(verify(store).derived) == 2


def test_what_came_from_checked_inputs_outlives_a_later_damage(store):
    first = add(store, spec(0), "A")
    second = add(store, spec(1), "B", (first,))
    damage(store, first.result.object)
    manifests = [store.manifest_path("gait", one.recipe) for one in (first, second)]
    removed = drop_damaged(store, manifests)
    assert removed.objects == [first.result.object]
    assert store.known(first.recipe) is None
    assert [path.is_file() for path in manifests] == [False, True]
    assert drop_damaged(store, manifests) == Removed([], [])


def test_collect_keeps_what_the_latest_plans_reach(store):
    old, new = spec(1), spec(2)
    lost, kept = (add(store, job, job.label).result.object for job in (old, new))
    for age, job in ((100, old), (0, new)):
        path = write_plan(build_plan({"table1": job}), store.root / "plans")
        os.utime(path, (1e9 - age, 1e9 - age))
    (store.root / "tmp" / "killed").mkdir(parents=True)
    (store.root / "gait" / ".x.json.1.part").write_text("")
    assert collect(store, keep=2).objects == []
    assert not (store.root / "tmp").exists()
    assert not list(store.root.rglob(files.TEMPORARY_PATTERN))
    removed = collect(store, keep=1, dry_run=True)
    assert removed.objects == [lost]
    assert store.is_whole(lost)
    assert collect(store, keep=1) == removed
    assert not store.object_folder(lost).exists()
    assert store.is_whole(kept)
    assert [kind.manifests for kind in summarise(store)] == [1]
    assert store.known(old.recipe) is None
    with pytest.raises(UserError, match=r"^--keep: expected at least 1 plan, found 0$"):
        collect(store, keep=0)
    path.write_bytes(b"\xff")
    with pytest.raises(UserError, match="expected a plan, found none at"):
        collect(store, keep=1)


def test_only_what_is_from_the_future_is_dated(tmp_path):
    store, late, early = Store(tmp_path), tmp_path / "late.json", tmp_path / "early.json"
    now = time.time()
    for path, moment in ((late, now + 3600), (early, now - 3600)):
        path.write_text("{}")
        os.utime(path, (moment, moment))
    assert date_now(store, [late, early, tmp_path / "absent.json"]) == 1
    assert abs(late.stat().st_mtime - now) < 60
    assert abs(early.stat().st_mtime - now + 3600) < 1


def test_plan_round_trip(tmp_path):
    gaits = [spec(1), spec(2)]
    top = JobSpec("library", "all", CODE, {"v": [1, 2]}, {"gaits": gaits})
    plan = build_plan({"table1": top})
    path = write_plan(plan, tmp_path)
    assert read_plan(path) == plan
    assert [job.label for job in plan.jobs.values()] == ["job 1", "job 2", "all"]
    path.write_text(path.read_text().replace('"v"', '"w"'))
    with pytest.raises(UserError, match=f"^expected a plan, found none at {path}$"):
        read_plan(path)
