"""The runner: cut-off, interrupted jobs, changed sources, damaged inputs."""

import multiprocessing
import os
import shutil
from pathlib import Path
from typing import Any

import pytest

from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import code_of, read_module
from slider.artefacts.run_metadata import note_start
from slider.artefacts.runner import Runner
from slider.artefacts.store import Store
from slider.core.errors import UserError
from slider.core.machine import kernels

STAGE = """
import time
from pathlib import Path


def first(section, inputs, out, job):
    assert not list(Path().iterdir()), "no option file of a library lies here"
    (out / "value.txt").write_text(str(section["value"] // 10))
    job.metadata["solve_s"] = 0.5
    return {"value": section["value"], "inf": float("inf")}


def second(section, inputs, out, job):
    text = [(folder / "value.txt").read_text() for folder in inputs["values"]]
    (out / "sum.txt").write_text(",".join(text) + str(job.input_metadata["values"][0]["solve_s"]))
    return {}


def slow(section, inputs, out, job):
    (out / "once.txt").write_text("")
    with (Path(section["log"])).open("a") as file:
        file.write("computed\\n")
    time.sleep(0.5)
    return {}
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Stages in a module of their own beside the real package."""
    name = f"stages_{tmp_path.name.replace('-', '_')}"
    root = tmp_path / "source"
    root.mkdir()
    (root / f"{name}.py").write_text(STAGE)
    monkeypatch.syspath_prepend(root)
    monkeypatch.setattr("slider.artefacts.runner.SOURCE_ROOT", root)
    code_of.cache_clear()
    read_module.cache_clear()
    return root, name


def job(package, function: str, section, inputs=None) -> JobSpec:
    root, name = package
    code = code_of(f"{name}:{function}", root)
    return JobSpec(function, function, code, section, inputs or {})


def metadata(store: Store, spec: JobSpec):
    return store.metadata(spec.stage, spec.recipe)


def test_equal_contents_of_inputs_cut_off_what_follows(package, store):
    runner = Runner(store)
    jobs = [job(package, "first", {"value": value}) for value in (10, 11)]
    ends = [job(package, "second", {}, {"values": [item]}) for item in jobs]
    assert jobs[0].recipe != jobs[1].recipe
    outcomes = [runner.run(item) for item in (jobs[0], ends[0], jobs[1], ends[1])]
    assert outcomes[3] == "reused"
    assert "reused" not in outcomes[:3]
    manifests = [store.read_manifest("second", end.recipe) for end in ends]
    assert manifests[0].result == manifests[1].result
    assert manifests[1].inputs == {"values": [jobs[1].recipe]}
    (digest,) = {store.read_manifest("first", item.recipe).result.object for item in jobs}
    assert manifests[0].input_objects == manifests[1].input_objects == {"values": [digest]}
    assert metadata(store, ends[1])["computed"] is False
    assert metadata(store, ends[1])["reused_from"] == ends[0].recipe


def test_a_forced_job_computes_again_what_an_earlier_one_left(package, store, tmp_path):
    """Also where its input has another recipe by now and the same content."""
    jobs = [job(package, "first", {"value": value}) for value in (10, 11)]
    first, second = (job(package, "second", {}, {"values": [item]}) for item in jobs)
    runner = Runner(store, tmp_path / "plan.json")
    for item in (jobs[0], first, jobs[1]):
        runner.run(item)
    note_start(runner.plan, forced=[second.recipe])
    assert runner.run(second) != "reused"
    assert metadata(store, second)["computed"] is True


def test_a_job_refuses_kernels_that_are_not_its_recipes(package, store):
    """Laid out on another machine: one line, and neither a result nor a word of it."""
    spec = job(package, "first", {"value": 10, "numerics": "vax"})
    with pytest.raises(UserError, match=r"numerics: expected vax, .* found \S+ on "):
        Runner(store).run(spec)
    assert not store.manifest_path("first", spec.recipe).exists()
    Runner(store).run(job(package, "first", {"value": 10, "numerics": kernels()}))


def test_lost_manifest_is_written_again_without_computing(package, store):
    spec = job(package, "first", {"value": 10})
    Runner(store).run(spec)
    path = store.manifest_path("first", spec.recipe)
    text, before = path.read_text(), metadata(store, spec)
    path.unlink()
    assert Runner(store).run(spec) == "reused"
    assert path.read_text() == text
    assert metadata(store, spec) == before
    assert '"inf": "inf"' in text


def test_a_power_cut_loses_no_finished_job(package, store, monkeypatch):
    """Object, then manifest are on the disk, names included, before the checkpoints go."""
    synced: list[Path] = []
    monkeypatch.setattr(os, "fsync", lambda d: synced.append(Path(f"/proc/self/fd/{d}").readlink()))
    spec = job(package, "first", {"value": 10})
    work, rmtree = store.work_folder("first", spec.recipe), shutil.rmtree

    def forget(folder: Path, **options: Any) -> None:
        if folder == work:
            manifest = store.read_manifest("first", spec.recipe)
            path, folder_of = store.manifest_path("first", spec.recipe), manifest.result.object
            names = [place.name for place in synced]
            assert names.index("value.txt") < names.index(folder_of[:2]) < names.index("first")
            assert {path.parent, store.root, store.root / "objects"} <= {*synced}
            assert any(name.startswith(f".{path.name}") for name in names)
        rmtree(folder, **options)

    monkeypatch.setattr(shutil, "rmtree", forget)
    Runner(store).run(spec)
    assert not work.exists()


def test_a_broken_index_entry_or_fact_is_computed_again(package, store):
    spec = job(package, "first", {"value": 10})
    Runner(store).run(spec)
    (entry,) = store.root.glob("index/*/*.json")
    for path in (entry, store.metadata_path("first", spec.recipe)):
        path.write_text("[]")
    assert Runner(store).run(spec) != "reused"
    assert metadata(store, spec)["computed"] is True
    store.metadata_path("first", spec.recipe).write_text("{")
    following = job(package, "second", {}, {"values": [spec]})
    with pytest.raises(KeyError, match=r"^'solve_s'$"):  # of the stage: it receives none
        Runner(store).run(following)


@pytest.mark.parametrize("damage", [Path.unlink, lambda path: path.write_text("7")])
def test_damaged_input_is_refused(package, store, damage):
    first = job(package, "first", {"value": 10})
    Runner(store).run(first)
    digest = store.read_manifest("first", first.recipe).result.object
    (store.object_folder(digest) / "value.txt").chmod(0o644)
    damage(store.object_folder(digest) / "value.txt")
    message = rf"^expected an intact first result {digest[:12]}, .* run `slider store verify`$"
    with pytest.raises(UserError, match=message):
        Runner(store).run(job(package, "second", {}, {"values": [first]}))


def test_source_that_changed_after_planning_is_refused(package, store):
    spec = job(package, "first", {"value": 10})
    root, name = package
    path = root / f"{name}.py"
    path.write_text(path.read_text().replace("// 10", "// 5"))
    code_of.cache_clear()
    read_module.cache_clear()
    with pytest.raises(UserError, match=r"^the source or the packages of stage first changed .*$"):
        Runner(store).run(spec)
    assert not store.manifest_path("first", spec.recipe).exists()


def test_two_processes_with_one_job_compute_it_once(package, store, tmp_path):
    log = tmp_path / "computed.log"
    spec, fork = job(package, "slow", {"log": str(log)}), multiprocessing.get_context("fork")
    processes = [fork.Process(target=Runner(store).run, args=(spec,)) for _ in range(2)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0]
    assert log.read_text() == "computed\n"
