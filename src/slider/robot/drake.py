"""Drake's model of a robot on flat ground, built from the data of its compiled MuJoCo model.

Masses, axes, limits and drives are read from MuJoCo's arrays, not from the robot's configuration.
Two things are modelled differently. A foot touches the ground with two spheres, the ends of its
capsule. The armature of a tendon over slide and ankle becomes a reflected inertia of each joint:
the coupling terms of the two equal motors of a capstan cancel.
"""

# mujoco has no type stubs for its compiled part; drake is optional.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

import logging
from typing import Any, NamedTuple

import mujoco
import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    Capsule,
    CollisionFilterDeclaration,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody import tree
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.systems.primitives import Adder, MatrixGain, Saturation

from slider.config.evaluation import DrakeContact
from slider.robot import names

# Drake warns about half spaces and deformable bodies; there are no deformable bodies here.
logging.getLogger("drake").setLevel(logging.ERROR)
_GEOM, _JOINT = mujoco.mjtGeom, mujoco.mjtJoint
_SHAPES = {
    _GEOM.mjGEOM_PLANE: lambda size: HalfSpace(),
    _GEOM.mjGEOM_SPHERE: lambda size: Sphere(size[0]),
    _GEOM.mjGEOM_CAPSULE: lambda size: Capsule(size[0], 2 * size[1]),
    _GEOM.mjGEOM_BOX: lambda size: Box(*(2 * size)),
}


class Motors(NamedTuple):
    """Motors of the compiled model, in its order.

    Attributes:
        matrix: motor angles per joint position (10, 12).
        kp, kd: of the position loops (10,) [N m/rad], [N m s/rad]; zero for torque inputs.
        stall, speed: stall torque [N m] and no-load speed [rad/s] of the torque-speed line (10,).
        limit: torque limits (10,) [N m].
    """

    matrix: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    stall: np.ndarray
    speed: np.ndarray
    limit: np.ndarray

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "Motors":
        """Motors with resistance R, constant K, voltage V: stall torque K V / R, speed V / K."""
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        matrix = np.zeros((model.nu, model.nv))
        moment = data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
        mujoco.mju_sparse2dense(matrix, *(values.ravel() for values in moment))
        resistance, constant, _, _, kp, _, kd, voltage, *_ = model.actuator_gainprm.T
        stall, speed = constant * voltage / resistance, voltage / constant
        return cls(matrix[:, 6:], kp, kd, stall, speed, model.actuator_forcerange[:, 1])


def add_drives(builder: Any, plant: Any, motors: Motors) -> tuple[Any, Any]:
    """Add motors to a plant; their position loops are evaluated explicitly once per plant step.

    A motor's torque follows its input, bounded by the torque-speed line and by its limit.

    Returns:
        Ports of the inputs (10,) [rad or N m] and of the torques (10,) [N m].
    """

    def add(system: Any, *sources: Any) -> Any:
        builder.AddSystem(system)
        for index, source in enumerate(sources):
            builder.Connect(source, system.get_input_port(index))
        return system.get_output_port()

    none, state, count = np.zeros_like(motors.matrix), plant.get_state_output_port(), len(motors.kp)
    kp, kd, slope = (x[:, None] for x in (motors.kp, motors.kd, motors.stall / motors.speed))
    pad = np.zeros((count, 7)), np.zeros((count, 6))  # of the base
    loop = np.hstack([pad[0], -kp * motors.matrix, pad[1], -kd * motors.matrix])
    speed_line = np.hstack([pad[0], none, pad[1], -slope * motors.matrix])
    scale = MatrixGain(np.diag(motors.kp if motors.kp.any() else np.ones(count)))
    demanded, line = add(scale), add(MatrixGain(speed_line), state)
    above = add(Adder(2, count), demanded, add(MatrixGain(loop - speed_line), state))
    bounded = add(Saturation(-motors.stall, motors.stall), above)
    torques = add(Saturation(-motors.limit, motors.limit), add(Adder(2, count), bounded, line))
    builder.Connect(add(MatrixGain(motors.matrix.T), torques), plant.get_actuation_input_port())
    return scale.get_input_port(), torques


def add_robot(
    builder: Any, model: mujoco.MjModel, timestep: float, contact: DrakeContact
) -> "MultibodyPlant":
    """Add robot and ground, with a time step of ``timestep`` [s]."""
    approximation = contact.approximation
    settings = MultibodyPlantConfig(
        time_step=timestep, discrete_contact_approximation=approximation
    )
    plant, scene = AddMultibodyPlant(settings, builder)
    plant.mutable_gravity_field().set_gravity_vector(model.opt.gravity)
    bodies = [plant.world_body()]
    for index in range(1, model.nbody):
        bodies.append(plant.AddRigidBody(model.body(index).name, _inertia(model, index)))
        _add_joint(plant, model, bodies[model.body_parentid[index]], bodies[index], index)
    _add_geometry(plant, scene, model, bodies, contact.dissipation)
    plant.Finalize()
    return plant


def _inertia(model: mujoco.MjModel, body: int) -> "tree.SpatialInertia":
    turn = RotationMatrix(Quaternion(_unit(model.body_iquat[body])))
    central = tree.RotationalInertia(*model.body_inertia[body]).ReExpress(turn)
    mass, place = model.body_mass[body], model.body_ipos[body]
    return tree.SpatialInertia.MakeFromCentralInertia(mass, place, central)


def _add_joint(plant: Any, model: mujoco.MjModel, parent: Any, child: Any, body: int) -> None:
    """Add the joint of a body; joints other than the root get an actuator, with the armature."""
    joint = model.body_jntadr[body]
    name, frames = model.joint(joint).name, (parent.body_frame(), child.body_frame())
    if model.jnt_type[joint] == _JOINT.mjJNT_FREE:
        plant.AddJoint(tree.QuaternionFloatingJoint(name, *frames))
        return
    turn = RotationMatrix(Quaternion(_unit(model.body_quat[body])))
    place = RigidTransform(turn, model.body_pos[body])
    there = RigidTransform(model.jnt_pos[joint])
    frames = (
        plant.AddFrame(tree.FixedOffsetFrame(f"{name}_{end}", frame, pose))
        for end, frame, pose in zip(("on", "at"), frames, (place @ there, there), strict=True)
    )
    dof = model.jnt_dofadr[joint]
    kind = model.jnt_type[joint] == _JOINT.mjJNT_SLIDE
    added = (tree.PrismaticJoint if kind else tree.RevoluteJoint)(
        name, *frames, model.jnt_axis[joint], damping=model.dof_damping[dof]
    )
    lower, upper = model.jnt_range[joint]
    added.set_position_limits([lower], [upper])
    actuator = plant.AddJointActuator(name, plant.AddJoint(added))
    rotors = np.repeat(model.tendon_armature, model.tendon_num) * model.wrap_prm**2
    inertia = model.dof_armature[dof] + rotors[model.wrap_objid == joint].sum()
    actuator.set_default_rotor_inertia(inertia)


def _add_geometry(
    plant: Any, scene: Any, model: mujoco.MjModel, bodies: list[Any], dissipation: float | None
) -> None:
    """Add the geometries that collide in MuJoCo, and allow the same collision pairs only."""
    feet, shapes, grounded = {names.foot(side) for side in names.SIDES}, {}, []
    for geom in range(model.ngeom):
        name, body = model.geom(geom).name, bodies[model.geom_bodyid[geom]]
        turn = RotationMatrix(Quaternion(_unit(model.geom_quat[geom])))
        pose, properties = RigidTransform(turn, model.geom_pos[geom]), ProximityProperties()
        friction = model.geom_friction[geom, 0]
        if name == names.FLOOR:  # Drake's friction of a pair is the harmonic mean
            friction = model.geom(names.foot(names.SIDES[0])).friction[0]
        rough = CoulombFriction(friction, friction)
        AddContactMaterial(properties=properties, dissipation=dissipation, friction=rough)
        shape = _SHAPES[_GEOM(model.geom_type[geom])](model.geom_size[geom])
        shapes[geom] = plant.RegisterCollisionGeometry(body, pose, shape, name, properties)
        if name in feet:
            radius, half, _ = model.geom_size[geom]
            for end, sign in zip(names.FOOT_ENDS, (-1, 1), strict=True):
                tip = pose @ RigidTransform([0.0, 0.0, sign * half])
                sphere = body, tip, Sphere(radius), f"{name}_{end}", properties
                grounded.append(plant.RegisterCollisionGeometry(*sphere))
        elif model.geom_conaffinity[geom]:
            grounded.append(shapes[geom])
    filters, floor = scene.collision_filter_manager(), shapes[model.geom(names.FLOOR).id]
    everything = GeometrySet([*shapes.values(), *grounded])
    filters.Apply(CollisionFilterDeclaration().ExcludeWithin(everything))
    pairs = [(GeometrySet(floor), GeometrySet(grounded))]
    for first, second in zip(model.pair_geom1, model.pair_geom2, strict=True):
        pairs.append((GeometrySet(shapes[first]), GeometrySet(shapes[second])))
    for pair in pairs:
        filters.Apply(CollisionFilterDeclaration().AllowBetween(*pair))


def _unit(quaternion: np.ndarray) -> np.ndarray:
    return quaternion / np.linalg.norm(quaternion)
