"""Everything that a robot's own software needs, as files of one folder."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from slider.control import POLICY_FILE
from slider.control.export import LAYOUT, MODEL, ONNX, REFERENCE, TORCH_EXPORT
from slider.control.export.agreement import Agreement, compare, record_observations
from slider.control.export.graph import save_onnx, save_torch, trace
from slider.control.export.layout import describe, reference_table
from slider.control.policy_file import Policy, load_policy
from slider.core.errors import UserError
from slider.core.files import digest_file
from slider.robot.mjcf import SimulationOptions, build_spec
from slider.robot.names import JOINTS, MOTORS
from slider.robot.transmission import Transmission

_DURATION = 4.0  # of the roll-out whose observations the files are compared on [s]


def export(policy_file: Path, origin: dict[str, Any], out: Path, threads: int = 1) -> Agreement:
    """Write the files ``FILES`` into ``out`` and compare the networks with the policy.

    Args:
        policy_file: of this project.
        origin: provenance, copied into the layout beside the digest of the policy file.
        out: existing folder.
        threads: of the roll-out.

    Raises:
        UserError: no policy file, a policy on top of a controller, or an exported network acts
            differently.
    """
    policy = write_files(policy_file, origin, out)
    observations = record_observations(policy, _DURATION, threads)
    agreement = compare(policy, out / ONNX, out / TORCH_EXPORT, observations)
    agreement.check()
    return agreement


def write_files(policy_file: Path, origin: dict[str, Any], out: Path) -> Policy:
    """Write the files, unchecked; return the policy. Arguments and errors as in ``export``."""
    policy = load_policy(policy_file)
    if policy.underlying is not None:
        raise UserError(
            f"{policy_file}: expected a policy that acts alone, found one on top of the controller "
            "hzd; only this package runs both, from the policy file"
        )
    layout = describe(policy, {"policy_sha256": digest_file(policy_file), **origin})
    program = trace(policy.network)
    save_onnx(program, layout, out / ONNX)
    save_torch(program, layout, out / TORCH_EXPORT)
    (out / LAYOUT).write_text(json.dumps(layout, indent=1) + "\n")
    np.save(out / REFERENCE, reference_table(policy).positions)
    (out / MODEL).write_text(_model_xml(policy))
    if policy_file.resolve() != (out / POLICY_FILE).resolve():
        shutil.copyfile(policy_file, out / POLICY_FILE)
    return policy


def _model_xml(policy: Policy) -> str:
    """MJCF of the simulated robot, ground and sensors."""
    physics = policy.env.physics
    options = SimulationOptions(
        physics.timestep, physics.solver_iterations, physics.line_search_iterations
    )
    spec = build_spec(policy.robot, options)
    model = spec.compile()
    return _with_all_digits(spec.to_xml(), Transmission.of(policy.robot), model)


def _with_all_digits(xml: str, motors: Transmission, model: mujoco.MjModel) -> str:
    """MuJoCo writes six digits; coefficients of tendons and parameters of motors need them all."""
    root = ElementTree.fromstring(xml)
    for tendon in root.iter("fixed"):
        row = motors.matrix[MOTORS.index(tendon.attrib["name"])]
        for joint in tendon.iter("joint"):
            joint.set("coef", repr(float(row[JOINTS.index(joint.attrib["joint"])])))
    for motor in root.iter("general"):
        count = len(motor.attrib["gainprm"].split())
        values = model.actuator(motor.attrib["name"]).gainprm[:count]
        motor.set("gainprm", " ".join(repr(float(value)) for value in values))
    return ElementTree.tostring(root, encoding="unicode")
