"""``slider store verify`` repairs what it names, whatever was done to the store."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from slider.artefacts.current import current_plan
from slider.artefacts.maintenance import Removed, verify
from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, build_plan, read_plan, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files

JOB = JobSpec("gait", "a gait", Code("slider.none:run", "abc", {}), {"value": 1})
PLAN = build_plan({"table1": JOB})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """One of each kind of file that a store has."""
    store = Store(tmp_path / "artefacts")
    with store.temporary("test") as out:
        (out / "data.txt").write_text("A")
        result = store.publish(out, {})
    manifest = Manifest("gait", JOB.recipe, {}, result, {})
    store.write_manifest(manifest)
    store.remember("ab" * 32, manifest)
    files.write_json(store.sidecar_path("gait", JOB.recipe), {"wall_s": 1.0})
    files.write_atomic(store.root / "current" / "table1", f"{JOB.recipe}\n")
    write_plan(PLAN, store.root / "plans")
    store.log_path("gait", JOB.recipe).parent.mkdir(parents=True)
    store.work_folder("gait", JOB.recipe).mkdir(parents=True)
    assert verify(store) == Removed([], [])
    return store


def garbage(content: bytes) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(content)


def a_folder(path: Path) -> None:
    path.unlink(missing_ok=True)
    (path / "deep").mkdir(parents=True)


def a_file(path: Path) -> None:
    shutil.rmtree(path, ignore_errors=True)
    path.write_text("")


GARBAGE = (b"\xff\xfe", b"", b"{}", b"[]", b"null", b"3", b'{"jobs": {"a": 3}}', b"[" * 100_000)
READ = ("plans/*.json", "index/*/*.json", f"gait/{JOB.recipe}.json", "gait/*.run.json")
CHANGES = [
    *((place, garbage(content)) for place in READ[:3] for content in GARBAGE),
    *((READ[3], garbage(content)) for content in (b"\xff\xfe", b"", b"[]", b"3")),
    *((place, a_folder) for place in (*READ, "current/table1")),
    ("current/table1", garbage(b"\xff\xfe")),
    ("locks/all.lock", a_folder),
    *((place, a_file) for place in ("objects/*", "index/*", "gait", "locks", "tmp")),
    *((place, a_file) for place in ("objects", "index", "plans", "current", "logs", "work")),
]


@pytest.mark.parametrize(("place", "change"), CHANGES)
def test_verify_repairs(store, place, change, capsys):
    """It says what, once; the plan can be laid out again and its job's result be written."""
    (path,) = store.root.glob(place)
    change(path)
    name = path.relative_to(store.root).as_posix()
    code = main(["store", "--artefacts", str(store.root), "verify"])
    found = capsys.readouterr()
    assert code == 1
    assert f"dropped {name}, unreadable\n" in found.out
    assert verify(store) == Removed([], [])
    again = write_plan(PLAN, store.root / "plans")
    assert read_plan(again) == PLAN
    assert current_plan(store) == PLAN
    files.write_atomic(store.root / "current" / "table1", "")
    files.write_json(store.sidecar_path("gait", JOB.recipe), {})
    with store.temporary("test") as out:
        (out / "data.txt").write_text("A")
        manifest = Manifest("gait", JOB.recipe, {}, store.publish(out, {}), {})
    store.write_manifest(manifest)
    store.remember("ab" * 32, manifest)
    assert store.known("ab" * 32) == manifest


def test_a_plan_that_says_something_else_than_its_name_is_dropped_or_rewritten(store):
    (path,) = (store.root / "plans").glob("*.json")
    text = path.read_text()
    path.write_text(text.replace("a gait", "a goat"))
    assert write_plan(PLAN, path.parent) == path
    assert path.read_text() == text
    path.write_text(text.replace("a gait", "a goat"))
    assert verify(store).unreadable == [f"plans/{path.name}"]


def test_a_manifest_under_another_name_is_dropped(store):
    path = store.manifest_path("gait", JOB.recipe)
    path.write_text(json.dumps(files.read_json(path) | {"recipe": "0" * 64}))
    assert verify(store).unreadable == [f"gait/{JOB.recipe}.json"]


def test_what_is_no_object_is_dropped(store):
    (store.root / "objects" / "zz" / "notes").mkdir(parents=True)
    assert verify(store).unreadable == ["objects/zz/notes"]
    assert store.known("ab" * 32) is not None
