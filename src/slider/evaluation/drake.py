"""The stages ``drake_audit`` and ``drake_evaluation``: Drake against MuJoCo; walks in Drake.

The audit compares the two models part by part: first the parameters, as read back from Drake's
model, then what both compute, in MuJoCo's coordinates. No evaluation starts before it has passed.
"""

# mujoco has no type stubs for its compiled part; drake is optional.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

import copy
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from slider.config.convert import from_dict
from slider.config.env import PhysicsConfig
from slider.config.evaluation import DrakeContact
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.drake import DrakePhysics, DrakeRobot
from slider.evaluation import AUDIT, stage
from slider.robot import names
from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.mjcf import SimulationOptions, build_model, nominal_qpos

STATES, SECONDS = 100, 1.0
_BASE, _SEED = 6, 0
_EXACT = 1e-8  # rounding of values up to some hundreds
_INTEGRATED, _SUNK = 1e-4, 1e-2  # between two integrators, between two contact models [m, rad]
Difference = tuple[str, str, float, float]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """As the stage ``evaluation``, but in Drake."""
    engine = partial(DrakePhysics, drake=section["drake"])
    return stage.run(section, inputs, out, job, engine)


def run_audit(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write the worst part of each quantity: what differs, by how much, what is allowed.

    Raises:
        UserError: names every part that differs by more.
    """
    robot = from_dict(RobotConfig, section["robot"])
    physics = from_dict(PhysicsConfig, section["physics"])
    model = build_model(robot, SimulationOptions.of(physics))
    contact = from_dict(DrakeContact, section["drake"]["contact"])
    timestep = model.opt.timestep = section["drake"]["timestep"]
    found = audit(model, DrakeRobot(model, timestep, contact), nominal_qpos(robot))
    (out / AUDIT).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return {"quantities": len(found)}


def audit(model: mujoco.MjModel, robot: DrakeRobot, nominal: np.ndarray) -> list[dict[str, Any]]:
    """Worst part of each quantity of Drake's robot against MuJoCo's model.

    The robot stands in the ``nominal`` positions (19,).

    Raises:
        UserError: names every part that differs by more than is allowed.
    """
    worst: dict[str, dict[str, Any]] = {}
    wrong = []
    for quantity, part, difference, allowed in _differences(model, robot, nominal):
        if not difference <= allowed:
            wrong.append(f"{quantity} of {part} differs by {difference:.3g}")
        row = {"quantity": quantity, "part": part, "difference": difference, "allowed": allowed}
        if quantity not in worst or not difference <= worst[quantity]["difference"]:
            worst[quantity] = row
    if wrong:
        raise UserError(f"Drake's model: expected MuJoCo's numbers, found: {'; '.join(wrong)}")
    return list(worst.values())


def _differences(
    model: mujoco.MjModel, robot: DrakeRobot, nominal: np.ndarray
) -> Iterator[Difference]:
    yield from _bodies(model, robot.plant)
    yield from _joints(model, robot.plant)
    rng, data = np.random.default_rng(_SEED), mujoco.MjData(model)
    for _ in range(STATES):
        yield from _state(model, data, robot, rng)
    yield from _motions(model, robot, nominal)


def _gap(one: Any, other: Any) -> float:
    return float(np.abs(np.asarray(one) - np.asarray(other)).max())


def _bodies(model: mujoco.MjModel, plant: Any) -> Iterator[Difference]:
    """Mass, centre and central inertia in the frame of the body."""
    for index in range(1, model.nbody):
        name = model.body(index).name
        inertia = plant.GetBodyByName(name).default_spatial_inertia()
        centre, axes = inertia.get_com(), np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[index])
        axes = axes.reshape(3, 3)
        tensor = axes @ np.diag(model.body_inertia[index]) @ axes.T
        own = inertia.Shift(centre).CopyToFullMatrix6()[:3, :3]
        yield "mass", name, _gap(inertia.get_mass(), model.body_mass[index]), _EXACT
        yield "centre of mass", name, _gap(centre, model.body_ipos[index]), _EXACT
        yield "inertia", name, _gap(own, tensor), _EXACT


def _joints(model: mujoco.MjModel, plant: Any) -> Iterator[Difference]:
    """Axis, range, damping and armature, the motors' rotors included."""
    bare = copy.copy(model)
    bare.dof_armature[:] = bare.tendon_armature[:] = 0.0
    added = _mass_matrix(model) - _mass_matrix(bare)
    for index in range(1, model.njnt):
        name, dof = model.joint(index).name, model.jnt_dofadr[index]
        joint, actuator = plant.GetJointByName(name), plant.GetJointActuatorByName(name)
        slides = model.jnt_type[index] == mujoco.mjtJoint.mjJNT_SLIDE
        axis = joint.translation_axis() if slides else joint.revolute_axis()
        limits = joint.position_lower_limit(), joint.position_upper_limit()
        damping, inertia = joint.default_damping(), actuator.default_rotor_inertia()
        yield "axis", name, _gap(axis, model.jnt_axis[index]), _EXACT
        yield "range", name, _gap(np.ravel(limits), model.jnt_range[index]), _EXACT
        yield "damping", name, _gap(damping, model.dof_damping[dof]), _EXACT
        expected = np.zeros(model.nv)
        expected[dof] = inertia
        yield "armature", name, _gap(expected, added[dof]), _EXACT


def _mass_matrix(model: mujoco.MjModel, data: Any = None) -> np.ndarray:
    if data is None:
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    return matrix


def _state(
    model: mujoco.MjModel, data: Any, robot: DrakeRobot, rng: np.random.Generator
) -> Iterator[Difference]:
    """Results of both in a random state: dynamics, positions of the feet, torques of the motors."""
    lower, upper = model.jnt_range[1:].T
    turn = rng.standard_normal(4)
    data.qpos[:7] = [*rng.uniform(-1, 1, 3), *(turn / np.linalg.norm(turn))]
    data.qpos[7:], data.qvel[:] = rng.uniform(lower, upper), rng.standard_normal(model.nv)
    inputs = data.ctrl[:] = rng.uniform(-1, 1, model.nu)
    plant, context = robot.plant, robot.context
    robot.place(data.qpos, data.qvel)
    mujoco.mj_forward(model, data)
    own = np.eye(model.nv)  # velocities of Drake from MuJoCo's
    own[:3, :3], own[3:6, 3:6], own[:_BASE] = 0.0, 0.0, 0.0
    own[:3, 3:6], own[3:6, :3] = rotation_from_quaternion(data.qpos[None, 3:7])[0], np.eye(3)
    gravity = plant.CalcGravityGeneralizedForces(context)
    bias = own.T @ (plant.CalcBiasTerm(context) - gravity)
    mass, torques = plant.CalcMassMatrix(context), robot.torques(inputs)
    yield "mass matrix", "all", _gap(own.T @ mass @ own, _mass_matrix(model, data)), _EXACT
    motors = (model.actuator(index).name for index in range(model.nu))
    for name, one, other in zip(motors, torques, data.actuator_force, strict=True):
        yield "motor torque", name, _gap(one, other), _EXACT
    for index in range(_BASE, model.nv):
        name = model.joint(index - _BASE + 1).name
        yield "bias force", name, _gap(bias[index], data.qfrc_bias[index]), _EXACT
    for side in names.SIDES:
        yield from _foot(model, data, robot, names.foot(side))
    data.qvel[:] = 0.0
    mujoco.mj_forward(model, data)
    robot.place(data.qpos, data.qvel)
    forces = -own.T @ gravity
    for index in range(model.nv):
        name = model.joint(max(0, index - _BASE + 1)).name
        yield "gravity torque", name, _gap(forces[index], data.qfrc_bias[index]), _EXACT


def _foot(model: mujoco.MjModel, data: Any, robot: DrakeRobot, foot: str) -> Iterator[Difference]:
    """Both spheres at the ends of MuJoCo's capsule, with its radius and friction."""
    geom, context = model.geom(foot), robot.context
    inspector = robot.plant.get_geometry_query_input_port().Eval(context).inspector()
    spheres = {inspector.GetName(found): found for found in inspector.GetAllGeometryIds()}
    place, axis = data.geom(foot).xpos, data.geom(foot).xmat.reshape(3, 3)[:, 2]
    pose = robot.plant.GetBodyByName(foot).EvalPoseInWorld(context)
    for end, sign in zip(names.FOOT_ENDS, (-1, 1), strict=True):
        sphere = spheres[f"{foot}_{end}"]
        centre = pose @ inspector.GetPoseInFrame(sphere).translation()
        name, expected = f"{foot}, {end}", place + sign * geom.size[1] * axis
        yield "foot sphere", name, _gap(centre, expected), _EXACT
        yield "foot radius", name, _gap(inspector.GetShape(sphere).radius(), geom.size[0]), _EXACT
        rough = inspector.GetProximityProperties(sphere).GetProperty("material", "coulomb_friction")
        yield "friction", name, _gap(rough.static_friction(), geom.friction[0]), _EXACT


def _motions(model: mujoco.MjModel, robot: DrakeRobot, nominal: np.ndarray) -> Iterator[Difference]:
    """A second of turning in free fall, motors holding the pose; a second of standing."""
    steps, weight = round(SECONDS / model.opt.timestep), model.body_mass.sum() * names.GRAVITY
    for motion, height in (("free fall", 10.0), ("standing", 0.0)):
        data = mujoco.MjData(model)
        data.qpos[:] = nominal
        data.qpos[2] += height
        data.qvel[3:6] = [0.5, 1.0, 1.5] if height else 0.0
        robot.place(data.qpos, data.qvel)
        mujoco.mj_step(model, data, steps)
        robot.advance(data.ctrl, steps)
        qpos, _ = robot.state()
        within = _INTEGRATED if height else _SUNK
        yield motion, "base place", _gap(qpos[:3], data.qpos[:3]), within
        yield motion, "base orientation", _gap(qpos[3:7], data.qpos[3:7]), within
        yield motion, "joints", _gap(qpos[7:], data.qpos[7:]), within
    yield "standing", "weight", _gap(robot.foot_forces().sum() / weight, 1.0), _SUNK
