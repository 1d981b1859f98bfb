"""Every name by which people call a result, and what is no such name."""

import pytest

from slider.artefacts.lineage.targets import find, place
from slider.artefacts.store import Store
from slider.core.errors import UserError


@pytest.fixture
def done(world, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    world.compute(world.plan())
    return world


@pytest.mark.parametrize(
    ("name", "stage"),
    [
        ("table1", "table"),
        ("reports/table1.csv", "table"),
        ("gait_library", "library"),
        ("the library", "library"),
        ("The  Library", "library"),
        ("library", "library"),
        ("gait 0.50 m/s", "gait"),
        ("gait vx=0.5 vy=0", "gait"),
        ("gait vx=0.5", "gait"),
    ],
)
def test_a_name(done, name, stage):
    job = find(name, done.store).job
    assert job.stage == stage
    assert stage != "gait" or job.section["command"] == [0.5, 0.0, 0.0]


def test_digests_and_files(done):
    table = done.found(done.plan())
    manifest = done.store.manifest_path("table", table.job.recipe)
    digest = table.manifest.result.object
    report = done.store.root.parent / "copy.csv"
    report.write_text((done.store.object_folder(digest) / "table.csv").read_text())
    sidecar = done.store.sidecar_path("table", table.job.recipe)
    for name in (table.job.recipe[:6], table.job.recipe, digest[:8], manifest, sidecar, report):
        assert find(str(name), done.store).job.recipe == table.job.recipe


def test_a_recipe_of_an_earlier_plan_is_found_and_the_latest_plan_comes_first(done):
    old = done.found(done.plan())
    new = done.compute(done.plan(trials=3))
    assert find("table1", done.store).job.recipe == new.job.recipe
    assert find(old.job.recipe[:12], done.store).job.recipe == old.job.recipe


def test_another_store(done, tmp_path):
    assert place(f"{done.store.root}:table1", tmp_path) == (done.store, "table1")
    assert place(f"{done.store.root.parent}:table1", tmp_path) == (done.store, "table1")
    assert place("protocol:table1", tmp_path) == (Store(tmp_path), "protocol:table1")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("tabel1", r"expected a report, .* found 'tabel1'; did you mean table1\?"),
        ("elephant", r"found 'elephant'; targets: library, table1, report"),
        ("123456", r"found '123456'; targets"),
        ("a" * 300, r"found 'aaa"),
        ("a\0b:c", r"found 'a.b:c'"),
        ("gait vx=0.3", r"found 'gait vx=0.3'"),
        ("gait vx=fast", r"found 'gait vx=fast'"),
        ("gait", r"'gait' may be [0-9a-f]{12} \(gait 0.00 m/s of library\), .*: its recipe tells"),
    ],
)
def test_no_name_or_several(done, name, text):
    with pytest.raises(UserError, match=text):
        find(name, done.store)


def test_a_file_that_is_no_result(done, tmp_path):
    (tmp_path / "table1.csv").write_text("edited by hand")
    with pytest.raises(UserError, match=r"table1.csv to be a file of a result in .*, found none"):
        find("table1.csv", done.store)


def test_a_store_without_plans(tmp_path):
    with pytest.raises(UserError, match=r"expected a plan in .*plans, found none: `snakemake -n`"):
        find("table1", Store(tmp_path))


def test_a_plan_that_nobody_can_read_is_passed_over(done):
    for content in ("", "{}", '{"jobs": {"a": 3}}', '{"jobs": {}, "targets": 3}'):
        (done.store.root / "plans" / f"{'0' * 64}.json").write_text(content)
        assert find("table1", done.store).job.stage == "table"
