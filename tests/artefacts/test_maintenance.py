"""Care of the store: ``slider store verify`` repairs what it names, ``gc`` keeps recent plans."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from slider.artefacts.current import current_plan
from slider.artefacts.maintenance import Removed, collect, drop_damaged, verify
from slider.artefacts.manifest import SCHEMA
from slider.artefacts.plan import build_plan, write_plan
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files
from slider.core.errors import UserError
from tests.artefacts.samples import GAITS, LIBRARY, PLAN, TABLE, compute, damage, data, fill, forge

GAIT = GAITS[0]
ONE = build_plan({"table1": GAIT})


@pytest.fixture
def one(store) -> Store:
    """Manifest, index entry and plan of one gait."""
    compute(store, GAIT)
    write_plan(ONE, store.root / "plans")
    assert verify(store) == Removed([], [])
    return store


READ = ("plans/*.json", "index/*/*.json", f"gait/{GAIT.recipe}.json")


@pytest.mark.parametrize("place", READ)
@pytest.mark.parametrize(
    "content", [b"\xff\xfe", b"", b"{}", b'{"jobs": {"a": 3}}', b"[" * 100_000]
)
def test_verify_repairs(one, place, content, capsys):
    """It says what, once; then all can be written again."""
    (path,) = one.root.glob(place)
    path.write_bytes(content)
    name = path.relative_to(one.root).as_posix()
    assert main(["store", "--artefacts", str(one.root), "verify"]) == 1
    assert f"dropped {name}, unreadable\n" in capsys.readouterr().out
    assert verify(one) == Removed([], [])
    write_plan(ONE, one.root / "plans")
    assert current_plan(one) == ONE
    assert compute(one, GAIT) == one.find(GAIT.key({}))


WRONG = ([], {"wall_s": -1}, {"computed": "yes"}, {"ended": "now"}, {"commit": 7}, {"own": [1]})


@pytest.mark.parametrize("values", WRONG)
def test_verify_drops_run_metadata_that_would_mislead_its_readers(one, values):
    path = one.metadata_path("gait", GAIT.recipe)
    path.write_text(files.canonical(values))
    assert one.metadata("gait", GAIT.recipe) == {}
    assert verify(one) == Removed([], [], unreadable=[f"gait/{path.name}"])
    assert verify(one) == Removed([], [])


def test_a_plan_that_says_something_else_than_its_name_is_dropped_or_rewritten(one):
    (path,) = (one.root / "plans").glob("*.json")
    text = path.read_text()
    path.write_text(text.replace("gait 0", "goat 0"))
    assert write_plan(ONE, path.parent) == path
    assert path.read_text() == text
    path.write_text(text.replace("gait 0", "goat 0"))
    assert verify(one).unreadable == [f"plans/{path.name}"]


def paths(store: Store, *jobs) -> list[Path]:
    return [store.manifest_path(job.stage, job.recipe) for job in jobs]


def test_verify_drops_what_is_corrupt_and_all_that_came_from_it(full):
    manifest = full.read_manifest("gait", GAIT.recipe)
    damage(data(full, manifest))
    removed = verify(full)
    assert removed.objects == [manifest.result.object]
    assert removed.manifests == [f"gait/{GAIT.recipe}.json"]
    assert removed.derived == [f"{job.stage}/{job.recipe}.json" for job in (LIBRARY, TABLE)]
    assert full.manifests() == sorted(paths(full, *GAITS[1:]))
    assert len(full.index()) == 5
    assert verify(full) == Removed([], [])


def test_a_manifest_remembers_its_inputs_without_the_way_to_them(full):
    """The manifest in between is gone: the objects that were read say enough."""
    manifest = full.read_manifest("gait", GAIT.recipe)
    library = full.read_manifest("library", LIBRARY.recipe)
    full.write_manifest(replace(library, inputs={"gaits": ["0" * 64]}))
    full.manifest_path("gait", GAIT.recipe).unlink()
    full.index_path(GAIT.key({})).unlink()
    damage(data(full, manifest))
    assert len(verify(full).derived) == 2


def test_what_came_from_checked_inputs_outlives_a_later_damage(full):
    manifest = full.read_manifest("gait", GAIT.recipe)
    damage(data(full, manifest))
    manifests = paths(full, *PLAN.jobs.values())
    line = f"gait/{GAIT.recipe}.json, with a damaged object"
    assert drop_damaged(full, manifests, dry_run=True) == [f"found {line}"]
    assert all(path.is_file() for path in manifests)
    assert drop_damaged(full, manifests) == [f"dropped {line}"]
    assert full.find(GAIT.key({})) is None
    assert [path for path in manifests if not path.is_file()] == paths(full, GAIT)
    assert drop_damaged(full, manifests) == []


def test_collect_keeps_what_the_latest_plans_reach(store):
    old, new = GAITS[:2]
    lost, kept = (compute(store, job).result.object for job in (old, new))
    for age, job in ((100, old), (0, new)):
        path = write_plan(build_plan({"table1": job}), store.root / "plans")
        os.utime(path, (1e9 - age, 1e9 - age))
    (store.root / "objects" / "tmp" / "killed").mkdir(parents=True)
    (store.root / "gait" / ".x.json.1.part").write_text("")
    assert collect(store, keep=2).objects == []
    assert not (store.root / "objects" / "tmp").exists()
    assert not list(store.root.rglob(files.TEMPORARY_PATTERN))
    removed = collect(store, keep=1, dry_run=True)
    assert removed.objects == [lost]
    assert store.is_whole(lost)
    assert collect(store, keep=1) == removed
    assert not store.object_folder(lost).exists()
    assert store.is_whole(kept)
    assert store.manifests() == paths(store, new)
    assert store.find(old.key({})) is None
    with pytest.raises(UserError, match=r"^--keep: expected at least 1 plan, found 0$"):
        collect(store, keep=0)
    path.write_bytes(b"\xff")
    with pytest.raises(UserError, match=r"expected a plan, found none at .*store verify` drops it"):
        collect(store, keep=1)


def test_what_another_version_wrote_stays(full):
    """Its plan keeps what it reaches; where a digest does not fit, it is damage."""
    path = full.manifest_path("gait", GAIT.recipe)
    forge(path, schema=SCHEMA + 1)
    text = files.canonical({"tasks": {GAIT.recipe: "of the future"}})
    plan = full.root / "plans" / f"{files.digest_text(text)}.json"
    files.write_atomic(plan, text)
    assert replace(verify(full), others=0) == Removed([], [])
    assert verify(full).others == 2
    collect(full, keep=1)
    assert full.manifests() == [path]
    assert len(full.objects()) == 1
    forge(path, signed=False, schema=SCHEMA + 2)
    assert verify(full).unreadable == [f"gait/{path.name}"]


@pytest.fixture
def layered(tmp_path) -> Iterator[Store]:
    """A finished store in a lower layer, as in the image of a container."""
    names = ("lowerdir", "upperdir", "workdir", "merged")
    layers = {name: tmp_path / name for name in names}
    for folder in layers.values():
        folder.mkdir()
    fill(Store(layers["lowerdir"] / "artefacts"))
    options = ",".join(f"{name}={layers[name]}" for name in names[:3])
    command = ["mount", "-t", "overlay", "overlay", "-o", options, layers["merged"]]
    if shutil.which("mount") is None or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("may not mount an overlay")
    yield Store(layers["merged"] / "artefacts")
    subprocess.run(["umount", "--lazy", layers["merged"]], check=True)


@pytest.mark.parametrize("care", [verify, lambda store: compute(store, GAIT)])
def test_a_damaged_object_of_a_lower_layer_is_repaired(layered, care):
    """Such a folder cannot be renamed (EXDEV)."""
    damage(data(layered, layered.read_manifest("gait", GAIT.recipe)))
    care(layered)
    manifest = compute(layered, GAIT)
    assert layered.is_whole(manifest.result.object)
    write_plan(ONE, layered.root / "plans")
    assert len(collect(layered, keep=1).objects) == 7
    assert layered.objects() == [manifest.result.object]
