"""Care of the store: ``slider store verify`` repairs what it names, ``gc`` keeps recent plans."""

import os

import pytest

from slider.artefacts.current import current_plan
from slider.artefacts.maintenance import collect, drop_damaged, verify
from slider.artefacts.manifest import SCHEMA
from slider.artefacts.plan import build_plan, write_plan
from slider.cli import main
from slider.core import files
from slider.core.errors import UserError
from tests.artefacts.samples import GAITS, PLAN, compute, damage, data, forge

GAIT = GAITS[0]
ONE = build_plan({"table1": GAIT})
PLACES = ("plans/*.json", "index/*/*.json", f"gait/{GAIT.recipe}.json", "gait/*.run.json")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "content", [b"\xff\xfe", b"", b"{}", b'{"jobs": {"a": 3}}', b"[" * 100_000]
)
def test_what_is_unreadable_counts_as_absent(store, place, content, capsys):
    """A manifest is dropped; all can be written again."""
    compute(store, GAIT)
    write_plan(ONE, store.root / "plans")
    (path,) = store.root.glob(place)
    path.write_bytes(content)
    manifest = path == store.manifest_path("gait", GAIT.recipe)
    assert main(["store", "--artefacts", str(store.root), "verify"]) == int(manifest)
    name = path.relative_to(store.root).as_posix()
    assert (f"dropped {name}, unreadable\n" in capsys.readouterr().out) == manifest
    write_plan(ONE, store.root / "plans")
    assert current_plan(store) == ONE
    assert compute(store, GAIT) == store.find(GAIT.key({}))
    assert verify(store) == []


def test_what_came_from_checked_inputs_outlives_a_later_damage(full):
    damage(data(full, full.read_manifest("gait", GAIT.recipe)))
    path = full.manifest_path("gait", GAIT.recipe)
    line = f"gait/{GAIT.recipe}.json, with a damaged or lost object"
    assert drop_damaged(full, [path], dry_run=True) == [f"found {line}"]
    assert path.is_file()
    assert verify(full) == [f"dropped {line}"]
    assert full.find(GAIT.key({})) is None
    missing = [j for j in PLAN.jobs.values() if not full.manifest_path(j.stage, j.recipe).is_file()]
    assert missing == [GAIT]
    assert verify(full) == []


def test_collect_keeps_what_the_latest_plans_reach(store):
    old, new = GAITS[:2]
    lost, kept = (compute(store, job).result.object for job in (old, new))
    for age, job in ((100, old), (0, new)):
        path = write_plan(build_plan({"table1": job}), store.root / "plans")
        os.utime(path, (1e9 - age, 1e9 - age))
    (store.root / "objects" / "tmp" / "killed").mkdir(parents=True)
    (store.root / "gait" / ".x.json.1.part").write_text("")
    assert collect(store, keep=2) == []
    assert not (store.root / "objects" / "tmp").exists()
    assert not list(store.root.rglob(files.TEMPORARY_PATTERN))
    removed = collect(store, keep=1, dry_run=True)
    assert removed == [f"object {lost}", f"gait/{old.recipe}.json"]
    assert store.is_intact(lost)
    assert collect(store, keep=1) == removed
    assert not store.object_folder(lost).exists()
    assert store.is_intact(kept)
    assert store.manifests() == [store.manifest_path("gait", new.recipe)]
    assert store.find(old.key({})) is None
    with pytest.raises(UserError, match=r"^--keep: expected at least 1 plan, found 0$"):
        collect(store, keep=0)


def test_collect_keeps_what_a_plan_of_another_version_reaches(full):
    path = full.manifest_path("gait", GAIT.recipe)
    forge(path, schema=SCHEMA + 1)
    text = files.canonical({"tasks": {GAIT.recipe: "of the future"}})
    files.write_atomic(full.root / "plans" / f"{files.digest_text(text)}.json", text)
    collect(full, keep=1)
    assert full.manifests() == [path]
    assert len(full.objects()) == 1
