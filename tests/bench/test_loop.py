"""The benchmark of the training measures what it claims."""

import re

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from slider.bench.loop import Bench
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
    row = bench.measure(seconds=0.05, rounds=2)
    assert min(row.bare.cpu, row.environment.cpu, row.loop.cpu) > 0
    assert sum(row.parts.values()) == pytest.approx(1.0)
    assert {"physics", "state", "observation", "reward", "policy", "update"} <= row.parts.keys()
    assert min(row.parts.values()) > 0
    assert row.line().split()[0] == "8"


def test_it_runs_with_the_default_configuration(tmp_path, capsys):
    library = write_store(tmp_path, [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    arguments = ["--envs", "4", "--seconds", "0.01", "--rounds", "1", "--threads", "1"]
    arguments += ["--library", str(library)]
    assert main(["benchmark-training", *arguments]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^ +4 +[\d.]+ \(", shown, re.MULTILINE)


def test_with_warp_all_three_run_on_the_device(calm, tmp_path):
    pytest.importorskip("mujoco_warp", reason="needs the extra gpu")
    settings = task(robots=8, disturbance=calm, simulator="mujoco_warp")
    bench = Bench(settings, threads=1, work=tmp_path)
    following, ends = [qpos for qpos, *_ in bench.recorded[1:]], []
    simulation = bench.env.physics.simulation
    step = simulation.step
    simulation.step = lambda: (step(), ends.append(simulation.qpos.clone()))
    assert bench.bare() == 24 * 8
    same = [(a == b).all(dim=1) for a, b in zip(ends, following, strict=False)]
    assert np.mean(np.stack(same)) > 0.8  # resets apart
    row = bench.measure(seconds=0.01, rounds=1)
    assert min(row.bare.cpu, row.environment.cpu, row.loop.cpu) > 0


def test_the_environment_is_left_as_it_was(bench):
    assert "step" not in vars(bench.env)
    assert "step" not in vars(bench.env.physics)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        *(
            (f"--{n}", "0", f"--{n}: expected at least 1, found 0")
            for n in ("envs", "rounds", "threads")
        ),
        *(("--seconds", v, "--seconds: expected a positive number") for v in ("0", "nan", "-1")),
    ],
)
def test_impossible_numbers_are_one_line(option, value, message, capsys):
    assert main(["benchmark-training", option, value]) == 1
    assert message in capsys.readouterr().err


def test_without_a_library_it_says_how_to_make_one(tmp_path, capsys):
    assert main(["benchmark-training", "--envs", "8", "--artefacts", str(tmp_path)]) == 1
    assert "snakemake -j2 gait_library" in capsys.readouterr().err
