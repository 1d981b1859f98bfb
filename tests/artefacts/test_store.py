"""The store: publication, manifests, verification and collection."""

import errno
import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from slider.artefacts.maintenance import Removed, collect, drop_damaged, summarise, verify
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


def add(store: Store, spec: JobSpec, content: str):
    result = publish(store, content)
    manifest = Manifest(spec.stage, spec.recipe, {}, result)
    store.remember(spec.recipe, manifest)
    store.write_manifest(manifest)
    return result


def damage(store: Store, digest: str) -> None:
    path = store.object_folder(digest) / "deep" / "data.txt"
    path.chmod(0o644)
    path.write_text("B" * len(path.read_text()))  # same size


def spec(value: int) -> JobSpec:
    return JobSpec("gait", f"job {value}", CODE, {"value": value})


def test_same_content_is_one_object_wherever_it_was_made(store):
    first, second = publish(store, "A"), publish(store, "A")
    assert first == second
    assert publish(store, "A", "other.txt").object != first.object
    assert len(list((store.root / "objects").glob("*/*"))) == 2
    assert not list((store.root / "tmp").iterdir())


def test_object_is_read_only_and_keeps_its_name(store):
    result = publish(store, "A")
    path = store.object_folder(result.object) / "deep" / "data.txt"
    assert path.stat().st_mode & 0o222 == 0
    assert store.is_whole(result.object)
    damage(store, result.object)
    assert not store.is_whole(result.object)


def test_publishing_replaces_a_damaged_object(store):
    result = publish(store, "A")
    damage(store, result.object)
    publish(store, "A")
    assert store.is_whole(result.object)


def test_links_are_refused(store):
    with store.temporary("test") as out:
        (out / "link").symlink_to("/etc/passwd")
        with pytest.raises(
            ValueError, match=r"^expected files and folders, found another kind: .*/link$"
        ):
            store.publish(out, {})


def test_full_disk_leaves_nothing_visible(store, monkeypatch):
    def no_space(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "rename", no_space)
    with pytest.raises(OSError, match="No space left on device"):
        publish(store, "A")
    assert not list((store.root / "objects").glob("*/*"))
    assert not list((store.root / "tmp").iterdir())
    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(OSError, match="No space left on device"):
        files.write_atomic(store.root / "x.json", "{}")
    assert not (store.root / "x.json").exists()
    assert not list(store.root.glob(files.TEMPORARY_PATTERN))


def test_manifest_round_trip_holds_nothing_volatile(store):
    job = spec(1)
    result = add(store, job, "A")
    path = store.manifest_path("gait", job.recipe)
    assert parse_manifest(path) == Manifest("gait", job.recipe, {}, result)
    assert list(json.loads(path.read_text())) == [
        "schema",
        "stage",
        "recipe",
        "inputs",
        "input_objects",
        "object",
        "files",
        "summary",
    ]


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
    "no files": {"files": []},
    "stage": {"stage": 3},
}


@pytest.mark.parametrize("change", BROKEN.values(), ids=list(BROKEN))
def test_what_is_no_manifest_is_one_line_and_counts_as_absent(store, change):
    job = spec(1)
    add(store, job, "A")
    path, entry = store.manifest_path("gait", job.recipe), store.index_path(job.recipe)
    for broken in (path, entry):
        text = json.dumps(files.read_json(broken) | change) if isinstance(change, dict) else ""
        broken.write_bytes(text.encode() or change)
    with pytest.raises(UserError, match="expected a manifest, found something else in"):
        parse_manifest(path)
    assert store.known(job.recipe) is None
    assert summarise(store) == []
    removed = verify(store)
    assert set(removed.unreadable) == {_name(store, path) for path in (path, entry)}
    assert (removed.objects, removed.manifests) == ([], [])
    assert not entry.exists()
    assert verify(store) == Removed([], [])


def _name(store: Store, path: Path) -> str:
    return path.relative_to(store.root).as_posix()


def test_infinities_are_written_as_standard_json(tmp_path):
    files.write_json(tmp_path / "x.json", {"mse": float("inf"), "n": (1, 2)})
    assert files.read_json(tmp_path / "x.json") == {"mse": "inf", "n": [1, 2]}


def test_manifest_without_its_object_is_dropped(store):
    job = spec(1)
    result = add(store, job, "A")
    path = store.manifest_path("gait", job.recipe)
    assert store.drop_dangling([path]) == []
    store.drop_object(result.object)
    assert store.drop_dangling([path]) == [path]
    assert not path.exists()
    path.write_text("{")
    assert store.drop_dangling([path]) == [path]


def test_index_forgets_an_object_that_is_gone(store):
    job = spec(1)
    result = add(store, job, "A")
    assert store.known(job.recipe) == Manifest("gait", job.recipe, {}, result)
    store.drop_object(result.object)
    assert store.known(job.recipe) is None
    assert store.known("0" * 64) is None


def test_verify_drops_exactly_what_is_corrupt(store):
    good, bad = spec(1), spec(2)
    kept, lost = add(store, good, "A"), add(store, bad, "B")
    path = store.object_folder(lost.object) / "deep" / "data.txt"
    path.chmod(0o644)
    path.write_text("X")
    removed = verify(store)
    assert removed.objects == [lost.object]
    assert removed.manifests == [f"gait/{bad.recipe}.json"]
    assert store.known(bad.recipe) is None
    assert store.known(good.recipe) is not None
    assert store.is_whole(kept.object)
    assert verify(store).objects == []


def chain(store: Store) -> list[Manifest]:
    """Manifests of three jobs, each made of the one before; the last one's index entry, too."""
    made: list[Manifest] = []
    for value, content in enumerate("ABC"):
        before = made[-1:]
        inputs = {"made_of": [one.recipe for one in before]}
        objects = {"made_of": [one.result.object for one in before]}
        result = publish(store, content)
        made.append(Manifest("gait", spec(value).recipe, inputs, result, objects))
        store.write_manifest(made[-1])
        store.remember(made[-1].recipe, made[-1])
    return made


def test_verify_drops_all_that_came_from_what_is_corrupt(store):
    made, other = chain(store), spec(9)
    add(store, other, "other")
    damage(store, made[0].result.object)
    removed = verify(store)
    assert removed.objects == [made[0].result.object]
    assert removed.manifests == [f"gait/{made[0].recipe}.json"]
    assert set(removed.derived) == {f"gait/{one.recipe}.json" for one in made[1:]}
    assert [path.stem for path in store.manifests()] == [other.recipe]
    assert [path.stem for path in store.index()] == [other.recipe]
    assert verify(store) == Removed([], [])


def test_a_manifest_remembers_what_it_was_made_of_without_the_way_to_it(store):
    """The manifest in between is gone: the objects that were read say enough."""
    made = chain(store)
    store.write_manifest(replace(made[1], inputs={"made_of": ["0" * 64]}))
    store.manifest_path("gait", made[0].recipe).unlink()
    store.index_path(made[0].recipe).unlink()
    damage(store, made[0].result.object)
    assert len(verify(store).derived) == 2


def test_what_was_made_of_checked_inputs_outlives_a_later_damage(store):
    made = chain(store)
    damage(store, made[0].result.object)
    manifests = [store.manifest_path("gait", one.recipe) for one in made]
    removed = drop_damaged(store, manifests)
    assert removed.objects == [made[0].result.object]
    assert store.known(made[0].recipe) is None
    assert [path.is_file() for path in manifests] == [False, True, True]
    assert len(removed.damage) == 2
    assert drop_damaged(store, manifests) == Removed([], [])


def test_collect_keeps_what_the_latest_plans_reach(store):
    old, new = spec(1), spec(2)
    old_result, new_result = add(store, old, "A"), add(store, new, "B")
    for age, job in ((100, old), (0, new)):
        path = write_plan(build_plan({"table1": job}), store.root / "plans")
        os.utime(path, (1e9 - age, 1e9 - age))
    (store.root / "tmp").mkdir(exist_ok=True)
    (store.root / "tmp" / "killed").mkdir()
    (store.root / "gait" / ".x.json.1.part").write_text("")
    assert collect(store, keep=2).objects == []
    assert not (store.root / "tmp").exists()
    assert not list(store.root.rglob(files.TEMPORARY_PATTERN))
    removed = collect(store, keep=1, dry_run=True)
    assert removed.objects == [old_result.object]
    assert store.is_whole(old_result.object)
    assert collect(store, keep=1) == removed
    assert not store.object_folder(old_result.object).exists()
    assert store.is_whole(new_result.object)
    assert [kind.manifests for kind in summarise(store)] == [1]
    assert store.known(old.recipe) is None
    with pytest.raises(UserError, match=r"^--keep: expected at least 1 plan, found 0$"):
        collect(store, keep=0)
    path.write_bytes(b"\xff")
    with pytest.raises(UserError, match="expected a plan, found none at"):
        collect(store, keep=1)


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
