"""Exported policies read back: of another robot or a damaged file is one line."""

import json
import shutil

import pytest

from slider.control import LAYOUT, ONNX
from slider.control.exported import load_exported, run
from slider.core.errors import UserError
from slider.core.files import digest_file
from slider.core.job import Job
from tests.control.policies import exported, make_policy


@pytest.fixture
def copy(tmp_path):
    return shutil.copytree(exported(), tmp_path / "copy"), make_policy()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda layout: layout["joints"][1].update(upper=7.0),
            r"joints\.1\.upper: expected .*, as configured, found 7\.0$",
        ),
        (lambda layout: layout.update(version=1), r"expected slider-policy-layout 11, found .* 1$"),
        (lambda layout: layout.pop("format"), "expected a layout of this project, found another"),
    ],
)
def test_another_layout_is_one_line(copy, change, message):
    folder, policy = copy
    assert load_exported(folder, policy.robot, policy.env)
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
