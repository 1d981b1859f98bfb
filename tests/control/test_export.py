"""The exported files: complete, the same bytes; those of another robot or damaged are one line."""

import json
import shutil
from dataclasses import replace

import mujoco
import numpy as np
import onnx
import pytest

from slider.cli import main
from slider.control import ESTIMATOR, EXPORT_FILES, LAYOUT, MODEL, ONNX, POLICY_FILE
from slider.control.export import TOLERANCE, compare, write_files
from slider.control.exported import load_exported, run
from slider.control.policy import load_policy
from slider.core.errors import UserError
from slider.core.files import digest_file
from slider.core.job import Job
from slider.env.observations import TERMS
from slider.env.physics import BatchedPhysics
from slider.robot.mjcf import nominal_qpos
from tests.config.composed import CONF
from tests.control.policies import exported, make_policy, write_policy
from tests.env.synthetic import TRANSMISSION, config

SETTINGS = config("experiment=test").env.estimator


@pytest.fixture
def folder():
    return exported()


def test_another_network_is_refused(folder):
    policy = load_policy(folder / POLICY_FILE)
    assert compare(policy, folder / ONNX, 0.1) <= TOLERANCE
    for spoiled in (policy.network.std[3] + 0.01, np.nan):
        policy.network.std[3] = spoiled
        with pytest.raises(UserError, match="joint targets of the ONNX file within 1e-06"):
            compare(policy, folder / ONNX, 0.1)


def test_the_graphs_are_of_2022_and_the_contract_names_their_ends(folder):
    layout = json.loads((folder / LAYOUT).read_text())
    for name in (ONNX, ESTIMATOR):
        model = onnx.load(folder / name)
        assert (model.ir_version, model.opset_import[0].version) == (8, 13)
        told = layout["graphs"][name]
        sizes = {end.name: end.type.tensor_type.shape.dim[1].dim_value for end in model.graph.input}
        state = told["state"]
        assert sizes == {n: given["size"] for n, given in told["inputs"].items()} | {
            state["input"]: state["size"]
        }
        assert [end.name for end in model.graph.output] == [*told["outputs"], state["output"]]
    assert layout["provenance"]["recipe"] == "abc"
    assert len(layout["provenance"]["policy_sha256"]) == 64
    assert layout["training"] == {"seed": 1, "iteration": 20, "value": 0.25}


def test_the_model_steps_like_the_simulated_one(folder):
    """In the air, on the ground, and with legs that touch: 40 steps from the same states."""
    policy = make_policy()
    plant = BatchedPhysics(policy.robot, policy.env.physics, 1).model
    model = mujoco.MjModel.from_xml_path(str(folder / MODEL))
    for name in ("jnt_range", "actuator_forcerange", "geom_friction"):  # beyond these states
        np.testing.assert_allclose(getattr(model, name), getattr(plant, name), rtol=1e-12)
    assert model.opt.timestep == plant.opt.timestep
    air, standing, crossed = np.tile(nominal_qpos(policy.robot), (3, 1))
    air[2], standing[2] = 1.2, standing[2] - 0.002
    crossed[2], crossed[[8, 14]] = 1.2, (-0.16, 0.16)  # hip rolls that bring the legs together
    feet, tubes = {"left_foot", "right_foot"}, {"left_tube", "right_tube"}
    rng = np.random.default_rng(0)
    for qpos, touching in ((air, set()), (standing, feet | {"floor"}), (crossed, tubes)):
        qvel, inputs = 0.1 * rng.standard_normal(18), TRANSMISSION.angles(qpos[7:])
        inputs = inputs + 0.2 * rng.standard_normal(10)
        ends = []
        for each in (plant, model):
            data = mujoco.MjData(each)
            data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, inputs
            mujoco.mj_forward(each, data)
            assert {each.geom(int(g)).name for c in data.contact for g in c.geom} == touching
            for _ in range(40):
                mujoco.mj_step(each, data)
            ends.append(np.concatenate([data.qpos, data.qvel, data.actuator_force]))
        np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-9)


def test_an_observation_that_no_robot_has_is_refused(tmp_path, monkeypatch):
    write_policy(tmp_path / POLICY_FILE)
    felt = replace(TERMS["base_height"], function=lambda view: view.state.foot_forces[:, :1])
    monkeypatch.setitem(TERMS, "base_height", felt)
    with pytest.raises(UserError, match=r"expected observations of .*needs foot_forces$"):
        write_files(tmp_path / POLICY_FILE, {}, tmp_path, SETTINGS)


def test_the_command_exports_and_shows(folder, tmp_path, refused, capsys):
    path, out = str(folder / POLICY_FILE), tmp_path / "a"
    assert main(["policy", "export", path, "--out", str(out), "--conf", str(CONF)]) == 0
    assert "largest difference of a joint target in a roll-out: " in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {*EXPORT_FILES}
    for name in {*EXPORT_FILES} - {LAYOUT}:  # which says of what recipe
        content = (out / name).read_bytes()
        assert content == (folder / name).read_bytes(), name
        assert b"site-packages" not in content, name
    assert main(["policy", "show", path]) == 0
    shown, written = json.loads(capsys.readouterr().out), json.loads((out / LAYOUT).read_text())
    assert shown["observation"] == written["observation"] != []
    (tmp_path / POLICY_FILE).write_text("not a policy")
    assert "expected a policy file" in refused("policy", "show", str(tmp_path / POLICY_FILE))


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
