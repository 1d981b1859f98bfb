"""The stage ``policy_export``: a policy for use without this package, as files of one folder.

The network is an ONNX file, which runtimes since 2022 load, with the layout inside. Its actions are
compared with the policy's on observations of a roll-out.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from torch import nn

from slider.config.convert import from_dict
from slider.config.env import EstimatorConfig
from slider.config.robot import RobotConfig
from slider.control import LAYOUT, MODEL, ONNX, POLICY_FILE, REFERENCE
from slider.control.exported import OnnxNetwork
from slider.control.layout import INPUT, OUTPUT, describe, reference_table
from slider.control.policy import Policy, PolicyController, PolicyNetwork, load_policy
from slider.core.errors import require
from slider.core.files import digest_file
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.robot.mjcf import SimulationOptions, build_spec
from slider.robot.names import joint_names, motor_names
from slider.robot.transmission import Transmission

LAYOUT_KEY = "slider_policy_layout"  # in the metadata of the ONNX file
_IR, _OPSET = 8, 13  # of ONNX 1.10, which onnxruntime has loaded since 1.10
_DURATION = 4.0  # of the roll-out [s]
TOLERANCE = 1e-5  # of an action
SPEEDS = (0.0, 0.4, 0.8, 1.2, 2.2, 3.0)  # commands of the roll-out [m/s]
_ROBOTS = 4  # per command


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Export the walking policy."""
    torch.set_num_threads(job.threads)
    estimator = section["estimator"]
    observations, _ = export(
        inputs["walking"][0] / POLICY_FILE,
        section["origin"],
        out,
        job.threads,
        None if estimator is None else from_dict(EstimatorConfig, estimator),
    )
    return {"observations": observations, "tolerance": TOLERANCE}


def export(
    policy_file: Path,
    origin: dict[str, Any],
    out: Path,
    threads: int = 1,
    estimator: EstimatorConfig | None = None,
) -> tuple[int, float]:
    """Write the files ``EXPORT_FILES`` into ``out`` and compare the network with the policy.

    ``origin`` is the provenance, copied into the layout beside the digest of the policy file; the
    ``estimator`` on board is for the layout, too.

    Returns:
        The number of observations, and the largest difference of an action.

    Raises:
        UserError: no policy file, or the exported network acts differently.
    """
    policy = write_files(policy_file, origin, out, estimator)
    observations = record_observations(policy, _DURATION, threads)
    return len(observations), compare(policy, out / ONNX, observations)


def write_files(
    policy_file: Path,
    origin: dict[str, Any],
    out: Path,
    estimator: EstimatorConfig | None = None,
) -> Policy:
    """Write the files, unchecked; return the policy. Arguments and errors as in ``export``."""
    policy = load_policy(policy_file)
    layout = describe(policy, {"policy_sha256": digest_file(policy_file), **origin}, estimator)
    save_onnx(policy.network, layout, out / ONNX)
    (out / LAYOUT).write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8")
    np.save(out / REFERENCE, reference_table(policy).values)
    spec = build_spec(policy.robot, SimulationOptions.of(policy.env.physics))
    (out / MODEL).write_text(_with_all_digits(spec, policy.robot), encoding="utf-8")
    if policy_file.resolve() != (out / POLICY_FILE).resolve():
        shutil.copyfile(policy_file, out / POLICY_FILE)
    return policy


def record_observations(policy: Policy, duration: float, threads: int = 1) -> np.ndarray:
    """Observations (steps · N, size) of robots that walk under the policy for ``duration`` [s]."""
    count = len(SPEEDS) * _ROBOTS
    recorded: list[torch.Tensor] = []

    def network(observations: torch.Tensor) -> torch.Tensor:
        recorded.append(observations)
        return policy.network(observations)

    agent = AgentInterface(policy.robot, policy.env, count, policy.times, policy.reference)
    physics = BatchedPhysics(policy.robot, policy.env.physics, count, threads)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), count)
    velocities = np.zeros((count, 3))
    velocities[:, 0] = np.repeat(SPEEDS, _ROBOTS)
    roll_out(PolicyController(network, agent), physics, policy.env, start, velocities, duration)
    return torch.cat(recorded).numpy()


def compare(policy: Policy, onnx_file: Path, observations: np.ndarray) -> float:
    """Largest difference of an action of the file from the policy's on observations (N, size).

    Raises:
        UserError: it is larger than ``TOLERANCE``.
    """
    given = torch.from_numpy(observations)
    with torch.inference_mode():
        actions = OnnxNetwork(onnx_file, given.shape[1])(given)
        difference = float((actions - policy.network(given)).abs().max())
    expected = f"the actions of the ONNX file within {TOLERANCE:g} of the policy's"
    near = difference <= TOLERANCE  # NaN is refused too
    require(near, "policy export", expected, f"a difference of {difference:.3g}")
    return difference


def save_onnx(network: PolicyNetwork, layout: Mapping[str, Any], path: Path) -> None:
    """Write the normaliser and the layers for any ONNX runtime: (N, size) → (N, 12)."""
    tensors = {"mean": network.mean, "std": network.std}
    nodes = [
        helper.make_node("Sub", [INPUT, "mean"], ["centred"]),
        helper.make_node("Div", ["centred", "std"], ["normalised"]),
    ]
    last = "normalised"
    for index, layer in enumerate(network.mlp):
        output = OUTPUT if index == len(network.mlp) - 1 else f"layer{index}"
        if isinstance(layer, nn.Linear):
            names = [f"weight{index}", f"bias{index}"]
            tensors |= dict(zip(names, (layer.weight, layer.bias), strict=True))
            nodes.append(helper.make_node("Gemm", [last, *names], [output], transB=1))
        else:
            operator = type(layer).__name__.capitalize()  # Elu, Relu, Tanh
            nodes.append(helper.make_node(operator, [last], [output]))
        last = output
    sizes = len(network.mean), tensors[nodes[-1].input[2]].numel()
    ends = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["robots", size])
        for name, size in zip((INPUT, OUTPUT), sizes, strict=True)
    ]
    values = [numpy_helper.from_array(t.detach().numpy(), name) for name, t in tensors.items()]
    graph = helper.make_graph(nodes, "policy", ends[:1], ends[1:], values)
    opset = [helper.make_opsetid("", _OPSET)]
    model = helper.make_model(graph, ir_version=_IR, opset_imports=opset, producer_name="slider")
    helper.set_model_props(model, {LAYOUT_KEY: json.dumps(layout)})
    onnx.checker.check_model(model, full_check=True)
    path.write_bytes(model.SerializeToString(deterministic=True))


def _with_all_digits(spec: mujoco.MjSpec, robot: RobotConfig) -> str:
    """MJCF with all digits of the tendons' coefficients and motors' parameters: MuJoCo has six."""
    model, motors = spec.compile(), Transmission.of(robot)
    names, joints = motor_names(robot.geometry), joint_names(robot.geometry)
    root = ElementTree.fromstring(spec.to_xml())
    for tendon in root.iter("fixed"):
        row = motors.matrix[names.index(tendon.attrib["name"])]
        for joint in tendon.iter("joint"):
            joint.set("coef", repr(float(row[joints.index(joint.attrib["joint"])])))
    for motor in root.iter("general"):
        count = len(motor.attrib["gainprm"].split())
        values = model.actuator(motor.attrib["name"]).gainprm[:count]
        motor.set("gainprm", " ".join(repr(float(value)) for value in values))
    return ElementTree.tostring(root, encoding="unicode")
