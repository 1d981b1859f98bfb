"""The stage ``gait``: same input, same bytes; a failure is a result; a light process."""

import json
import shutil
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from slider.core.job import Job
from slider.gait.formulation import Node
from slider.gait.rooted import DECOUPLING
from slider.gait.solve import ANCHOR
from slider.gait.stage import MIN_PENDING_JOBS, REPORT, run
from slider.gait.transcription import NODE
from tests.gait.gaits import nodes, problem, section
from tests.library.solved import solved_gait


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def solve_into(out: Path, job: Job | None = None, anchor: Path | None = None, **settings: Any):
    out.mkdir()
    inputs = {"anchor": [anchor]} if anchor else {}
    return run(section(0.6, 0.1, **settings), inputs, out, job or Job(out))


@pytest.fixture
def gait() -> Path:
    return solved_gait((0.6, 0.1, 0.0))


def test_neither_an_option_file_of_ipopt_nor_an_anchor_that_failed_changes_a_byte(
    gait, tmp_path, monkeypatch
):
    solve_into(tmp_path / "failed", max_iterations=3, guesses=["cold"])
    (tmp_path / "ipopt.opt").write_text("nlp_scaling_method none\nmax_cpu_time 0.05\n")
    monkeypatch.chdir(tmp_path)
    job = Job(tmp_path)
    summary = solve_into(tmp_path / "hostile", job, anchor=tmp_path / "failed")
    assert contents(tmp_path / "hostile") == contents(gait)
    assert summary["max_violation"] <= 1e-6
    assert job.metadata["solve_cpu"] > 0


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_compiled_functions_give_the_same_bytes(gait, tmp_path: Path, monkeypatch):
    compiler = tmp_path / "quick-cc"  # that does not optimise: the same bits, in less time
    compiler.write_text('#!/bin/sh\nexec cc "$@" -O0\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    job = Job(tmp_path, cache=tmp_path / "cache", waiting=MIN_PENDING_JOBS)
    solve_into(tmp_path / "compiled", job)
    assert list((tmp_path / "cache").glob("*.so"))
    assert contents(tmp_path / "compiled") == contents(gait)


def test_the_report_has_cost_of_transport_and_height_of_the_base(gait):
    """Against the expressions of the nodes."""
    x, form = ca.SX.sym("x", NODE), problem().form
    node = Node(form, x, ca.SX.zeros(2))
    power = ca.sum1(ca.fabs(node.motor_torques * node.motor_speeds))
    values = ca.Function("values", [x], [power, node.base.origin[2]]).map(42)(nodes(0.6, 0.1).T)
    power, height = (
        np.trapezoid(value.full().reshape(2, 21), dx=0.05, axis=1).mean() for value in values
    )
    report = json.loads((gait / REPORT).read_text())
    assert report["gait_transport"] == pytest.approx(power / form.weight / 0.6, rel=1e-9)
    assert report["base_height"] == pytest.approx(height, rel=1e-9)


def test_a_gait_that_does_not_converge_is_a_result(tmp_path: Path):
    """A decoupling below its bound is named as any other constraint."""
    given = section(0.6, 0.1, max_iterations=3, guesses=["cold"])
    given["solve"]["decoupling_min"] = 1e3
    summary = run(given, {}, tmp_path, Job(tmp_path))
    assert summary["status"] == "Maximum_Iterations_Exceeded"
    assert not summary["converged"]
    report = json.loads((tmp_path / REPORT).read_text())
    least = np.load(tmp_path / f"{DECOUPLING}.npy")[:, 0].min()
    assert max(report["residuals"].values()) == summary["max_violation"] == 1e3 - least > 900
    assert report["residuals"]["impact"] > 1e-3
    assert report["worst"][DECOUPLING] == f"{least:.3g}, at least 1e+03"
    assert np.isfinite(np.load(tmp_path / "samples.npy")).all()


def test_a_gait_starts_from_its_anchor_with_multipliers(gait, tmp_path: Path):
    solve_into(tmp_path / "gait", anchor=solved_gait((0.6, 0.0, 0.0)))
    cold, report = (
        json.loads((folder / REPORT).read_text()) for folder in (gait, tmp_path / "gait")
    )
    assert [attempt["name"] for attempt in report["attempts"]] == [ANCHOR]
    assert report["cost"] == pytest.approx(cold["cost"], rel=1e-6)
    assert report["max_violation"] <= 1e-6
    assert report["iterations"] < 0.75 * cold["iterations"]


def test_the_order_of_gaits_changes_no_byte(tmp_path: Path):
    """As after a kill: the neighbours of an anchor forwards and backwards, in one process."""
    anchor, found = {"anchor": [solved_gait((0.6, 0.0, 0.0))]}, []
    for name, order in ("forwards", [0.05, 0.1]), ("backwards", [0.1, 0.05]):
        for vy in order:
            out = tmp_path / name / f"{vy}"
            out.mkdir(parents=True)
            run(section(0.6, vy), anchor, out, Job(out))
        found.append([contents(tmp_path / name / f"{vy}") for vy in (0.05, 0.1)])
    assert found[0] == found[1]
