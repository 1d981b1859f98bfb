"""The exported files: the same actions, complete, the same bytes, and nothing of this machine."""

import json

import mujoco
import numpy as np
import onnx
import pytest
import torch

from slider.cli import main
from slider.control import EXPORT_FILES, LAYOUT, MODEL, ONNX
from slider.control.export import (
    LAYOUT_KEY,
    TOLERANCE,
    compare,
    export,
    record_observations,
    save_onnx,
    write_files,
)
from slider.control.exported import OnnxNetwork
from slider.control.policy import PolicyNetwork, load_policy
from slider.core.errors import UserError
from slider.env.physics import BatchedPhysics
from slider.robot.mjcf import nominal_qpos
from tests.control.policies import make_policy, write_policy
from tests.env.synthetic import motor_angles


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    write_policy(folder / "policy.pt")
    export(folder / "policy.pt", {"recipe": "abc"}, folder)
    return folder


def test_another_network_is_refused(folder):
    policy = load_policy(folder / "policy.pt")
    observations = record_observations(policy, 0.1)
    assert compare(policy, folder / ONNX, observations) <= TOLERANCE
    for spoiled in (policy.network.std[3] + 0.01, np.nan):
        policy.network.std[3] = spoiled
        with pytest.raises(UserError, match="actions of the ONNX file within 1e-05"):
            compare(policy, folder / ONNX, observations)


def test_the_layout_is_in_both_files(folder):
    layout = json.loads((folder / LAYOUT).read_text())
    model = onnx.load(folder / ONNX)
    assert json.loads({p.key: p.value for p in model.metadata_props}[LAYOUT_KEY]) == layout
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
        qvel, inputs = 0.1 * rng.standard_normal(18), motor_angles(qpos[7:])
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


def test_same_policy_same_bytes_and_no_paths_of_this_machine(folder, tmp_path):
    write_policy(tmp_path / "policy.pt")
    write_files(tmp_path / "policy.pt", {"recipe": "abc"}, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(EXPORT_FILES)
    for name in EXPORT_FILES:
        content = (tmp_path / name).read_bytes()
        assert content == (folder / name).read_bytes(), name
        assert b"site-packages" not in content, name


def test_the_command_exports_and_shows(folder, tmp_path, refused, capsys):
    path, out = str(folder / "policy.pt"), tmp_path / "a"
    assert main(["policy", "export", path, "--out", str(out)]) == 0
    assert "largest difference of an action over 4800 observations" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == set(EXPORT_FILES)
    size = sum(load_policy(folder / "policy.pt").observations.values())
    assert main(["policy", "show", path]) == 0
    shown = capsys.readouterr().out
    for part in (f"{size} × 24 × 16 × 12, elu", "actions about   the gait", "left_slide"):
        assert part in shown
    assert main(["policy", "show", "--json", path]) == 0
    assert json.loads(capsys.readouterr().out)["observation"]["size"] == size
    (tmp_path / "policy.pt").write_text("not a policy")
    assert "expected a policy file" in refused("policy", "show", str(tmp_path / "policy.pt"))


@pytest.mark.parametrize("activation", ["elu", "relu", "tanh"])
def test_onnx_loads_in_the_runtimes_of_2022_with_any_activation(tmp_path, activation):
    network = PolicyNetwork(5, 12, (8, 4), activation).eval()
    network.mean.fill_(0.3)
    network.std.fill_(2.0)
    save_onnx(network, {}, tmp_path / ONNX)
    model = onnx.load(tmp_path / ONNX)
    assert (model.ir_version, model.opset_import[0].version) == (8, 13)
    observations = torch.randn(7, 5)
    with torch.inference_mode():
        expected = network(observations).numpy()
    actions = OnnxNetwork(tmp_path / ONNX, 5)(observations)
    np.testing.assert_allclose(actions, expected, atol=1e-6)
