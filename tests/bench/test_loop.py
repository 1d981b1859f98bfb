"""The benchmark of the training measures what it says."""

import re

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from slider.bench.throughput import Bench
from slider.bench.training import _resolved, line
from slider.cli import main
from tests.env.synthetic import config
from tests.library.gaits import write_store
from tests.training.test_trainer import TINY, task


@pytest.fixture(scope="module")
def calm():
    """No disturbances: delays come before the physics."""
    return config(*TINY, "train/walking/disturbance=none").train.walking.disturbance


@pytest.fixture(scope="module")
def bench(calm, tmp_path_factory):
    settings = task(robots=8, disturbance=calm)
    return Bench(settings, threads=1, work=tmp_path_factory.mktemp("work"))


def test_bare_physics_does_the_environments_work(bench):
    """Each recorded state and input leads to the state that was recorded next, resets apart."""
    model = bench.env.physics.model
    pool, data = rollout.Rollout(nthread=1), [mujoco.MjData(model)]
    same = []
    for (state, angles), (following, _) in zip(bench.recorded, bench.recorded[1:], strict=False):
        control = np.repeat(angles[:, None], 4, axis=1)
        end = np.asarray(pool.rollout(model, data, state, control)[0])[:, -1]
        same.append((end[:, 1:] == following[:, 1:]).all(axis=1))
    assert len(same) == 23
    assert np.mean(same) > 0.8


def test_rates_and_shares_are_of_the_same_run(bench):
    rows = bench.measure(["float32"], seconds=0.05, rounds=2)
    assert [(row.num_envs, row.precision) for row in rows] == [(8, "float32")]
    row = rows[0]
    assert min(row.bare.cpu, row.environment.cpu, row.loop.cpu) > 0
    assert min(row.environment_share, row.loop_share, row.products_share) > 0
    assert sum(row.parts.values()) == pytest.approx(1.0)
    assert {"physics", "state", "observation", "reward", "policy", "update"} <= row.parts.keys()
    assert min(row.parts.values()) > 0
    assert line(row).split()[:2] == ["8", "float32"]


def test_it_runs_with_the_default_configuration(tmp_path, capsys):
    library = write_store(tmp_path, [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    arguments = ["--envs", "4", "--seconds", "0.01", "--rounds", "1", "--threads", "1"]
    arguments += ["--precision", "float32", "--library", str(library)]
    assert main(["benchmark-training", *arguments]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^ +4  float32 ", shown, re.MULTILINE)


def test_with_warp_all_three_run_on_the_device(calm, tmp_path):
    pytest.importorskip("mujoco_warp", reason="needs the extra gpu")
    settings = task(robots=8, disturbance=calm, simulator="mujoco_warp")
    bench = Bench(settings, threads=1, work=tmp_path)
    following, ends = [qpos for qpos, *_ in bench.recorded[1:]], []
    simulation = bench._bare.simulation  # type: ignore[attr-defined]
    step = simulation.step
    simulation.step = lambda: (step(), ends.append(simulation.qpos.clone()))
    assert bench._bare() == 24 * 8
    same = [(a == b).all(dim=1) for a, b in zip(ends, following, strict=False)]
    assert np.mean(np.stack(same)) > 0.8  # resets apart
    (row,) = bench.measure(["float32"], seconds=0.01, rounds=1)
    assert min(row.bare.cpu, row.environment.cpu, row.loop.cpu) > 0


def test_the_environment_is_left_as_it_was(bench):
    assert "step" not in vars(bench.env)
    assert "step" not in vars(bench.env.physics)


@pytest.mark.parametrize(("has_cuda", "device"), [(False, "cpu"), (True, "cuda")])
def test_a_device_is_found_where_it_is_auto(monkeypatch, has_cuda, device):
    """As the pipeline does before a recipe."""
    monkeypatch.setattr("slider.core.numerics._has_cuda", lambda: has_cuda)
    auto = ["train.walking.simulator=mujoco_warp", "train.walking.device=auto"]
    assert _resolved(config(*auto)).train.walking.device == device


@pytest.mark.parametrize("option", ["--envs", "--rounds", "--threads"])
def test_impossible_numbers_are_one_line(option, capsys):
    assert main(["benchmark-training", option, "0"]) == 1
    assert f"{option}: expected at least 1, found 0" in capsys.readouterr().err


@pytest.mark.parametrize("seconds", ["0", "nan", "-1"])
def test_a_measurement_takes_time(seconds, capsys):
    assert main(["benchmark-training", "--seconds", seconds]) == 1
    assert "--seconds: expected a positive number" in capsys.readouterr().err


def test_without_a_library_it_says_how_to_make_one(tmp_path, capsys):
    assert main(["benchmark-training", "--envs", "8", "--artefacts", str(tmp_path)]) == 1
    assert "snakemake -j2 gait_library" in capsys.readouterr().err
