"""The stage ``policy_export``: a policy for use without this package, as files of one folder.

The graphs are ONNX files that runtimes since 2022 load. The policy's graph is compared with the
policy in a rollout.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import torch

from slider.config.convert import from_dict
from slider.config.env import EstimatorConfig
from slider.config.robot import RobotConfig
from slider.control import ESTIMATOR, LAYOUT, MODEL, ONNX, POLICY_FILE
from slider.control.deployment import estimator_step, policy_step
from slider.control.exported import OnnxController
from slider.control.layout import NEXT_STATE, STATE, describe, metadata
from slider.control.onnx_graph import save
from slider.control.policy import Policy, PolicyController, load_policy
from slider.core.errors import require
from slider.core.files import digest_file
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import USUAL_NOISE, at_rest
from slider.env.state import RobotState
from slider.robot.mjcf import SimulationOptions, build_spec
from slider.robot.names import joint_names, motor_names
from slider.robot.transmission import Transmission

DURATION = 10.0  # of the roll-out [s]
TOLERANCE = 1e-6  # of a joint target [rad, m]
SPEEDS = (0.0, 0.4, 0.8, 1.2, 2.2, 3.0)  # commands of the roll-out [m/s]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Export the walking policy."""
    torch.set_num_threads(job.threads)
    policy_file = inputs["walking"][0] / POLICY_FILE
    estimator = from_dict(EstimatorConfig, section["estimator"])
    policy = write_files(policy_file, section["origin"], out, estimator)
    compare(policy, out / ONNX, DURATION, job.threads)
    return {"duration": DURATION, "tolerance": TOLERANCE}


def write_files(
    policy_file: Path, origin: dict[str, Any], out: Path, estimator: EstimatorConfig
) -> Policy:
    """Write the files ``EXPORT_FILES`` into ``out``, without :func:`compare`; return the policy.

    ``origin`` is the provenance, copied into the contract after the digest of the policy file.

    Raises:
        UserError: not a policy file, or an observation that the exported inputs do not give.
    """
    policy = load_policy(policy_file)
    graphs = {ONNX: policy_step(policy), ESTIMATOR: estimator_step(policy.robot, estimator)}
    layout = describe(policy, {"policy_sha256": digest_file(policy_file), **origin}, graphs)
    for name, step in graphs.items():
        sizes = {name: len(reading.default) for name, reading in step.readings.items()}
        inputs, outputs = {**sizes, STATE: step.state_size}, [*step.outputs, NEXT_STATE]
        save(step.function, inputs, outputs, metadata(layout, step), out / name)
    (out / LAYOUT).write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8")
    spec = build_spec(policy.robot, SimulationOptions.of(policy.env.physics))
    (out / MODEL).write_text(_with_all_digits(spec, policy.robot), encoding="utf-8")
    if policy_file.resolve() != (out / POLICY_FILE).resolve():
        shutil.copyfile(policy_file, out / POLICY_FILE)
    return policy


class Both:
    """Controls with the policy and passes the same states to the exported file.

    Attributes:
        exported: the controller of the file.
        targets: last targets of the policy (N, 12).
        difference: largest difference between targets of the two so far [rad or m].
    """

    def __init__(self, policy: PolicyController, exported: OnnxController) -> None:
        self.exported, self._controllers = exported, (policy, exported)
        self.targets, self.difference = np.zeros(0), 0.0

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start both."""
        for each in self._controllers:
            each.reset(state, velocity)

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Command both."""
        for each in self._controllers:
            each.set_velocity(velocity)

    def control(self, state: RobotState) -> np.ndarray:
        """Targets of the policy."""
        self.targets, found = (each.control(state) for each in self._controllers)
        worst = np.abs(self.targets - found).max()
        self.difference = float(np.maximum(self.difference, worst))  # NaN stays
        return self.targets


def compare(policy: Policy, onnx_file: Path, duration: float, threads: int = 1) -> float:
    """Largest difference between joint targets of file and policy in a rollout [rad or m].

    Raises:
        UserError: it is larger than ``TOLERANCE``.
    """
    count = len(SPEEDS)
    agent = AgentInterface(policy.robot, policy.env, count, policy.times, policy.reference)
    scan = policy.env.observation.height_scan
    both = Both(PolicyController(policy.network, agent), OnnxController(onnx_file, scan))
    physics = BatchedPhysics(policy.robot, policy.env.physics, count, threads)
    start = at_rest(policy.robot, USUAL_NOISE, np.random.default_rng(0), count)
    velocities = np.zeros((count, 3))
    velocities[:, 0] = SPEEDS
    roll_out(both, physics, policy.env, start, velocities, duration)
    expected = f"joint targets of the ONNX file within {TOLERANCE:g} of the policy's"
    near = both.difference <= TOLERANCE  # NaN is refused too
    require(near, "policy export", expected, f"a difference of {both.difference:.3g}")
    return both.difference


def _with_all_digits(spec: mujoco.MjSpec, robot: RobotConfig) -> str:
    """MJCF with all digits of tendon coefficients and motor parameters: MuJoCo writes six."""
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
