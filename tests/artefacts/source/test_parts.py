"""The modules behind a source digest are noted beside the plan, once, and go with it."""

from pathlib import Path

import pytest

from slider.artefacts.maintenance import collect, verify
from slider.artefacts.plan import JobSpec, Plan, build_plan, write_plan
from slider.artefacts.recipe import code_of
from slider.artefacts.source.closure import closure
from slider.artefacts.source.parts import known_parts, note_sources
from slider.artefacts.store import Store
from slider.core import files

ENTRY = "slider.core.files:plain"


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "artefacts")


@pytest.fixture
def plan() -> Plan:
    return build_plan({"files": JobSpec("files", "files", code_of(ENTRY), {})})


def source(plan: Plan) -> str:
    return next(iter(plan.jobs.values())).code.source


def test_every_module_has_its_digest(store, plan):
    note_sources(plan, store)
    parts = known_parts(store, source(plan))
    assert parts is not None
    assert tuple(name for name in parts if "/" not in name) == (
        *("slider", "slider.core", "slider.core.files"),
    )


def test_data_files_are_parts(tmp_path):
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "__init__.py").write_text("")
    (tmp_path / "pack" / "table.csv").write_text("1\n")
    found = closure("pack", tmp_path).parts
    assert found["pack/table.csv"] == files.digest_file(tmp_path / "pack" / "table.csv")


def test_what_is_there_is_not_written_again(store, plan):
    note_sources(plan, store)
    (path,) = (store.root / "sources").glob("*")
    path.write_text("mine")
    note_sources(plan, store)
    assert path.read_text() == "mine"
    assert known_parts(store, source(plan)) is None
    assert verify(store).unreadable == [f"sources/{path.name}"]
    note_sources(plan, store)
    assert known_parts(store, source(plan)) is not None


def test_a_digest_of_another_source_gets_no_parts(store, plan, tmp_path):
    (tmp_path / "slider" / "core").mkdir(parents=True)
    (tmp_path / "slider" / "core" / "files.py").write_text("")
    note_sources(plan, store, tmp_path)
    assert not (store.root / "sources").exists()


def test_they_are_no_manifests_and_go_with_the_last_plan_that_names_them(store, plan):
    path = write_plan(plan, store.root / "plans")
    note_sources(plan, store)
    other = store.parts_path("0" * 64)
    files.write_json(other, {})
    assert store.manifests() == []
    collect(store, 1, dry_run=True)
    assert other.is_file()
    collect(store, 1)
    assert not other.exists()
    assert known_parts(store, source(plan)) is not None
    values = files.read_json(path)
    files.write_json(path, {key: values[key] for key in values if key != "codes"})  # of old
    collect(store, 1)
    assert known_parts(store, source(plan)) is None
