"""Exported policies read back: the same actions; another layout or a damaged file is one line."""

import json
import shutil

import numpy as np
import pytest
import torch

from slider.control import LAYOUT, ONNX
from slider.control.export import record_observations, write_files
from slider.control.exported import load_exported, run
from slider.core.errors import UserError
from slider.core.files import digest_file
from slider.core.job import Job
from tests.control.policies import write_policy


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    write_policy(folder / "policy.pt")
    return folder, write_files(folder / "policy.pt", {}, folder)


@pytest.fixture
def copy(exported, tmp_path):
    return shutil.copytree(exported[0], tmp_path / "copy"), exported[1]


def test_network_clock_and_gaits_are_those_of_the_policy(copy):
    """Whatever the words."""
    folder, policy = copy
    layout = json.loads((folder / LAYOUT).read_text())
    layout["observation"]["terms"][0]["meaning"] = "as ever"
    (folder / LAYOUT).write_text(json.dumps(layout))
    network, read = load_exported(folder, policy.robot, policy.env)
    observations = torch.from_numpy(record_observations(policy, 0.1))
    with torch.inference_mode():
        expected = policy.network(observations).numpy()
    np.testing.assert_allclose(network(observations).numpy(), expected, atol=1e-5)
    np.testing.assert_array_equal(read.times.step_time, policy.times.step_time)
    np.testing.assert_array_equal(read.reference.standing, policy.reference.standing)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda layout: layout["observation"]["terms"][1].update(scale=7.0),
            r"observation\.terms\.1\.scale: expected .*, as configured, found 7\.0$",
        ),
        (
            lambda layout: layout["action"]["motors"][0].update(kp=1.0),
            r"action\.motors\.0\.kp: expected .*, as configured, found 1\.0$",
        ),
        (lambda layout: layout.update(version=1), r"expected slider-policy-layout 10, found .* 1$"),
        (lambda layout: layout.pop("clock"), "expected a layout of this project, found another"),
    ],
)
def test_another_layout_is_one_line(copy, change, message):
    folder, policy = copy
    layout = json.loads((folder / LAYOUT).read_text())
    change(layout)
    (folder / LAYOUT).write_text(json.dumps(layout))
    with pytest.raises(UserError, match=message):
        load_exported(folder, policy.robot, policy.env)


def test_a_damaged_network_is_one_line(copy):
    folder, policy = copy
    (folder / ONNX).write_bytes(b"nothing")
    with pytest.raises(UserError, match=r"policy\.onnx: expected an ONNX file, found another one$"):
        load_exported(folder, policy.robot, policy.env)


def test_the_import_takes_the_files_that_it_was_laid_out_for(copy, tmp_path):
    folder, out = copy[0], tmp_path / "out"
    out.mkdir()
    section = {"folder": str(folder), "files": {ONNX: digest_file(folder / ONNX)}}
    run(section, {}, out, Job(tmp_path))
    assert (out / ONNX).read_bytes() == (folder / ONNX).read_bytes()
    (folder / ONNX).write_bytes(b"another")
    with pytest.raises(UserError, match=r"policy\.onnx: expected the file that the job was laid"):
        run(section, {}, out, Job(tmp_path))
