"""What the pipeline calls: a job checks its recipe, a report is copied whole or not at all."""

import socket
from unittest.mock import Mock

import pytest

from slider.artefacts.plan import build_plan, write_plan
from slider.artefacts.runner import Runner
from slider.cli import main
from slider.core import files
from slider.tracking import DATABASE, LATEST
from tests.artefacts.samples import GAITS, compute, damage

JOB = GAITS[0]


def test_a_recipe_that_does_not_fit_its_job_is_refused(tmp_path, refused):
    path = write_plan(build_plan({"table1": JOB}), tmp_path)
    other = "0" * 64
    text = path.read_text().strip().replace(JOB.recipe, other)
    named = path.with_stem(files.digest_text(text))
    named.write_text(text)
    line = refused("run", other, "--plan", str(named), "--artefacts", str(tmp_path))
    assert line == f"slider: expected a recipe of {named}, found {other}"


def test_a_job_without_memory_is_one_line(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(Runner, "run", Mock(side_effect=MemoryError))
    path = write_plan(build_plan({"table1": JOB}), tmp_path)
    assert main(["run", JOB.recipe, "--plan", str(path), "--artefacts", str(tmp_path)]) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("slider: gait 0: expected more memory, found: none; results and")


@pytest.mark.parametrize("damaged", [False, True])
def test_a_copy_is_what_the_manifest_says(store, tmp_path, capsys, damaged):
    report = tmp_path / "reports" / "table1.csv"
    result = compute(store, JOB, table1="mse\n0.0285\n").result
    report.parent.mkdir()
    report.write_text("the one before")
    if damaged:
        damage(store.object_folder(result.object) / "table1.csv")
    path = store.manifest_path("gait", JOB.recipe)
    arguments = ["publish", str(path), str(report), "--artefacts", str(store.root)]
    assert main(arguments) == int(damaged)
    assert report.read_text() == ("the one before" if damaged else "mse\n0.0285\n")
    assert [*report.parent.iterdir()] == [report]
    error = capsys.readouterr().err
    assert ("found it damaged: run `slider store verify`" in error) is damaged


@pytest.mark.parametrize("content", [None, b"", b"no database"])
def test_without_runs_it_is_one_line(tmp_path, refused, content):
    if content is not None:
        (tmp_path / "mlflow.db").write_bytes(content)
    assert refused("runs", "--artefacts", str(tmp_path)).startswith("slider: expected runs in ")
    assert not (tmp_path / "mlflow.db").exists() or (tmp_path / "mlflow.db").read_bytes() == content


def test_a_taken_port_is_one_line(tmp_path, refused):
    for name in (DATABASE, LATEST):
        files.write_atomic(tmp_path / name, "")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        line = refused("runs", "--artefacts", str(tmp_path), "--port", str(port))
    assert f"--port: expected a free port at 127.0.0.1, found {port}" in line
