"""The prismatic MuJoCo model, generated from the robot parameters.

Motors are MuJoCo's DC motors, bounded by their torque limit and by a linear torque-speed line. They
act on their joints; the two capstan motors of a leg act on fixed tendons over slide and ankle. The
rotor inertia is the tendon's armature, so that limits, speeds and inertia of the two joints are
coupled. The input is a motor angle for the onboard PD loop, or a torque
(:class:`slider.robot.transmission.Transmission`).

Feet, tubes and hips of one leg collide with those of the other, and tubes with the base. Everything
else collides only with the ground.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from slider.config.env import PhysicsConfig, SoleContact
from slider.config.robot import Geometry, LegJoint, Link, RobotConfig
from slider.robot import names
from slider.robot.transmission import Transmission, by_motor

BUS_VOLTAGE = 48.0  # [V]; cancels out of the torque-speed line
_GROUND = (1, 0)  # contype, conaffinity of the floor
_BODY = (0, 1)
_FOOT = [0.75, 0.35, 0.15, 1]
DISTANCE_CUTOFF = 0.3  # largest distance of the legs that sensors report [m]
_SITE, _GEOM = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_GEOM
_KIND = mujoco.mjtSensor
_MOTION = (("position", _KIND.mjSENS_FRAMEPOS), ("velocity", _KIND.mjSENS_FRAMELINVEL))
# Contact sensors: (data field bits, reduction, slots), as the XML attributes data, reduce and num.
_NET_FORCE = (1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1)
_FOUND = (1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1)

Actuation = Literal["position", "torque"]


@dataclass(frozen=True)
class SimulationOptions:
    """Integration settings: time step [s], solver and line-search iterations; motor inputs.

    ``actuation`` is ``position`` (input: motor angles [rad], onboard PD) or ``torque`` (input:
    motor torques [N m]); limits, inertia and damping are the same. ``instruments`` adds sensors
    for metrics: of heels and toes, and of the distance of the legs. Without ``contact``, the feet
    have MuJoCo's default softness.
    """

    timestep: float = 0.005
    solver_iterations: int = 4
    line_search_iterations: int = 8
    actuation: Actuation = "position"
    instruments: bool = False
    contact: SoleContact | None = None

    @classmethod
    def of(cls, physics: PhysicsConfig, **others: Any) -> "SimulationOptions":
        """Options from a configuration, with ``others`` such as ``actuation``."""
        settings = physics.timestep, physics.solver_iterations, physics.line_search_iterations
        return cls(*settings, contact=physics.contact, **others)


def build_model(robot: RobotConfig, options: SimulationOptions) -> mujoco.MjModel:
    """Compile the model of a robot on flat ground."""
    return build_spec(robot, options).compile()


def build_spec(robot: RobotConfig, options: SimulationOptions) -> mujoco.MjSpec:
    """Specification of the robot, the ground and the sensors, to be compiled."""
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    spec.option.timestep = options.timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.iterations = options.solver_iterations
    spec.option.ls_iterations = options.line_search_iterations
    # A robot is a single island: searching for islands takes time and does not change results.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    # MuJoCo 4.0.0 has wrong accelerations with its sparse factor (google-deepmind/mujoco#3767).
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    floor = spec.worldbody.add_geom(
        name=names.FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[100, 100, 0.1]
    )
    floor.contype, floor.conaffinity = _GROUND
    base = _add_base(spec, robot)
    for sign, side in zip((1.0, -1.0), names.SIDES, strict=True):
        _add_leg(base, robot, side, sign, options.contact)
    for first, second in (*names.LEG_PAIRS, *names.BASE_PAIRS):
        pair = spec.add_pair(name=f"{first}_{second}", geomname1=first, geomname2=second, condim=3)
        pair.friction[:2] = robot.contact.friction
    _add_motors(spec, robot, options.actuation)
    _add_sensors(spec, robot.geometry)
    if options.instruments:
        _add_instruments(spec, robot.geometry)
    return spec


def nominal_qpos(robot: RobotConfig) -> np.ndarray:
    """Base pose and joint positions of the upright nominal pose, soles on the ground (19,)."""
    qpos = np.zeros(7 + names.NUM_JOINTS)
    qpos[2] = robot.geometry.standing_height
    qpos[3] = 1.0
    return qpos


def _add_base(spec: mujoco.MjSpec, robot: RobotConfig) -> mujoco.MjsBody:
    base = spec.worldbody.add_body(name=names.BASE, pos=nominal_qpos(robot)[:3])
    base.add_freejoint(name="root")
    _set_inertia(base, robot.links.base)
    _add_geom(
        base,
        names.BASE,
        mujoco.mjtGeom.mjGEOM_BOX,
        size=list(robot.geometry.base_half_size),
        pos=[0.0, 0.0, 0.05],
        rgba=[0.20, 0.28, 0.55, 1],
    )
    base.add_site(name=names.IMU)
    return base


def _add_leg(
    base: mujoco.MjsBody, robot: RobotConfig, side: str, sign: float, contact: SoleContact | None
) -> None:
    geometry, capsule, parent = robot.geometry, mujoco.mjtGeom.mjGEOM_CAPSULE, base
    bodies, *_, (_, knee, _, _), (_, ankle, _, _) = {}, *geometry.leg(sign)
    for joint in geometry.leg(sign):
        parent = bodies[joint.name] = _add_link(parent, robot, side, joint)
    _add_geom(
        bodies["hip_roll"],
        f"{side}_hip",
        mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[geometry.hip_radius, 0, 0],
        rgba=[0.35, 0.37, 0.4, 1],
    )
    # The collision tube ends above the ankle, so that only the foot touches the ground.
    rod = {"size": [geometry.tube_radius, 0, 0], "rgba": [0.12, 0.12, 0.13, 1]}
    top, end = [0.0, 0.0, geometry.upper_foot_height], [*ankle[:2], ankle[2] + 0.05]
    if geometry.knee is not None:
        top = [0.0, 0.0, 0.0]
        hip = -geometry.axes.below_pitch * [1.0, sign, 1.0]
        last = bodies[geometry.axes.order[-1]]
        thigh = _add_geom(last, f"{side}_thigh", capsule, fromto=[*hip, *knee], **rod)
        thigh.conaffinity = 0  # only visual
    _add_geom(bodies["slide"], names.tube(side), capsule, fromto=[*top, *end], **rod)
    foot, upper = bodies["ankle"], bodies["slide"]
    if geometry.sole is not None:
        roll = LegJoint("ankle_roll", geometry.ankle_roll, np.eye(3)[0], slides=False)
        foot = _add_link(foot, robot, side, roll)
    ground = _add_foot(
        foot, names.foot(side), geometry, geometry.foot_radius - geometry.sole_height
    )
    ground.friction = [robot.contact.friction, 0.005, 0.0001]
    if contact is not None:
        ground.solref[0] = contact.time_constant
        ground.solimp[:3] = [*contact.impedance, contact.depth]
    ground.priority = 1  # the foot's friction counts, not the floor's
    foot.add_site(name=names.sole(side), pos=[0.0, 0.0, -geometry.sole_height])
    if geometry.sole is None:
        # After the foot: MuJoCo numbers joints in this order, that of joint_names.
        place = np.array([0.0, 0.0, geometry.upper_foot_height])
        joint = LegJoint("upper_foot", place, np.eye(3)[1], slides=False)
        upper = _add_link(upper, robot, side, joint)
    height = geometry.ankle_height - geometry.foot_radius
    line = _add_geom(upper, f"{side}_upper_foot", capsule, **_foot_line(geometry, height))
    if geometry.knee is not None or geometry.sole is not None:  # there is no upper foot
        line.fromto, line.size = [0, 0, -0.001, 0, 0, 0.001], [0.001, 0, 0]
    line.conaffinity = 0  # far above the ground


def _add_foot(body: mujoco.MjsBody, name: str, geometry: Geometry, height: float) -> mujoco.MjsGeom:
    """Foot line, or sole (a box), with its centre at ``height`` above the joint [m]."""
    if geometry.sole is None:
        return _add_geom(body, name, mujoco.mjtGeom.mjGEOM_CAPSULE, **_foot_line(geometry, height))
    length, middle = geometry.toe + geometry.heel, (geometry.toe - geometry.heel) / 2
    size = [length / 2, geometry.sole.width / 2, geometry.foot_radius]
    look = {"pos": [middle, 0.0, height], "rgba": _FOOT}
    return _add_geom(body, name, mujoco.mjtGeom.mjGEOM_BOX, size=size, **look)


def _foot_line(geometry: Geometry, height: float) -> dict[str, list[float]]:
    """Capsule along x at ``height`` above its joint [m]."""
    return {
        "size": [geometry.foot_radius, 0, 0],
        "fromto": [-geometry.heel, 0, height, geometry.toe, 0, height],
        "rgba": _FOOT,
    }


def _add_link(
    parent: mujoco.MjsBody, robot: RobotConfig, side: str, joint: LegJoint
) -> mujoco.MjsBody:
    config, drive = robot.joints[joint.name], robot.drives.get(joint.name)
    name = f"{side}_{joint.name}"
    link = robot.geometry.links[joint.name]
    body_name = names.foot(side) if link == "foot" else name
    body = parent.add_body(name=body_name, pos=joint.place)
    index, kinds = names.joint_names(robot.geometry).index(name), mujoco.mjtJoint
    body.add_joint(
        name=name,
        type=kinds.mjJNT_SLIDE if joint.slides else kinds.mjJNT_HINGE,
        axis=joint.axis,
        limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        range=robot.joint_ranges[:, index],
        armature=config.armature + (0.0 if drive is None else drive.inertia),
        damping=np.array([config.damping]),
    )
    _set_inertia(body, getattr(robot.links, link), 1.0 if side == names.SIDES[0] else -1.0)
    return body


def _set_inertia(body: mujoco.MjsBody, link: Link, lateral: float = 1.0) -> None:
    """Set mass and inertia of a link; ``lateral`` is −1 for the right side, which is mirrored."""
    (x, y, z), (xy, xz, yz) = link.com, link.products
    body.explicitinertial = True
    body.mass, body.ipos = link.mass, [x, lateral * y + 0.0, z]
    if any(link.products):
        body.fullinertia = [*link.inertia, lateral * xy, xz, lateral * yz]
    else:
        body.inertia = link.inertia


def _add_geom(body: mujoco.MjsBody, name: str, kind: mujoco.mjtGeom, **shape) -> mujoco.MjsGeom:
    geom = body.add_geom(name=name, type=kind, mass=0.0, **shape)
    geom.contype, geom.conaffinity = _BODY
    return geom


def _add_motors(spec: mujoco.MjSpec, robot: RobotConfig, actuation: Actuation) -> None:
    inputs, motors = mujoco.mjtCtrlInput, Transmission.of(robot)
    gains = by_motor(robot, robot.gains) * len(names.SIDES)
    torque, joint_names = actuation == "torque", names.joint_names(robot.geometry)
    for index, name in enumerate(names.motor_names(robot.geometry)):
        joints = np.flatnonzero(motors.matrix[index])
        kind, target = mujoco.mjtTrn.mjTRN_JOINT, joint_names[joints[0]]
        if len(joints) > 1:
            kind, target = mujoco.mjtTrn.mjTRN_TENDON, name
            tendon = spec.add_tendon(name=name, armature=motors.inertia[index])
            for joint in joints:
                tendon.wrap_joint(joint_names[joint], motors.matrix[index, joint])
        actuator = spec.add_actuator(name=name, trntype=kind, target=target)
        kp, kd = (0.0, 0.0) if torque else (gains[index].kp, gains[index].kd)
        actuator.set_to_dcmotor(
            motorconst=[0.0, 0.0],
            resistance=0.0,
            nominal=[BUS_VOLTAGE, motors.stall[index], motors.speed[index]],
            saturation=[motors.torque[index], 0.0, 0.0],
            controller=[kp, 0.0, kd, 0.0, 0.0, BUS_VOLTAGE],
            ctrlspec=inputs.mjINPUT_FF if torque else inputs.mjINPUT_POS,
        )


def _add_sensors(spec: mujoco.MjSpec, geometry: Geometry) -> None:
    """Add sensors for controllers and rewards: base, motors, soles, forces on the feet."""
    _add_sensor(spec, "base_linear_velocity", _KIND.mjSENS_VELOCIMETER, names.IMU)
    _add_sensor(spec, "base_angular_velocity", _KIND.mjSENS_GYRO, names.IMU)
    for motor in names.motor_names(geometry):
        actuator = mujoco.mjtObj.mjOBJ_ACTUATOR
        _add_sensor(spec, f"{motor}_torque", _KIND.mjSENS_ACTUATORFRC, motor, objtype=actuator)
    for side in names.SIDES:
        for quantity, kind in _MOTION:
            _add_sensor(spec, f"{side}_sole_{quantity}", kind, names.sole(side))
        _add_contact(spec, f"{side}_foot_force", names.foot(side), _NET_FORCE)
    for body in (names.BASE, *(names.tube(side) for side in names.SIDES)):
        _add_contact(spec, f"{body}_contact", body, _FOUND)


def _add_instruments(spec: mujoco.MjSpec, geometry: Geometry) -> None:
    """Add sensors for metrics: heels and toes, rotation of feet, distances between the legs."""
    height = geometry.foot_radius - geometry.sole_height
    for side in names.SIDES:
        for end, x in zip(names.FOOT_ENDS, (-geometry.heel, geometry.toe), strict=True):
            name = f"{side}_{end}"  # in the middle of the capsule's round end
            spec.body(names.foot(side)).add_site(name=name, pos=[x, 0, height])
            for quantity, kind in _MOTION:
                _add_sensor(spec, f"{name}_{quantity}", kind, name)
        _add_sensor(spec, f"{side}_foot_turning", _KIND.mjSENS_FRAMEANGVEL, names.sole(side))
    for first, second in names.LEG_PAIRS:
        name, ends = f"{first}_{second}_distance", {"reftype": _GEOM, "refname": second}
        kind = _KIND.mjSENS_GEOMDIST
        _add_sensor(spec, name, kind, first, objtype=_GEOM, cutoff=DISTANCE_CUTOFF, **ends)


def _add_contact(spec: mujoco.MjSpec, name: str, geom: str, content: tuple[int, int, int]) -> None:
    """Add a sensor of the contact between a geom and the floor."""
    ends = {"objtype": _GEOM, "reftype": _GEOM, "refname": geom}
    _add_sensor(spec, name, _KIND.mjSENS_CONTACT, names.FLOOR, intprm=content, **ends)


def _add_sensor(
    spec: mujoco.MjSpec, name: str, kind: mujoco.mjtSensor, target: str, **settings
) -> None:
    """Add a sensor attached to an object, by default to a site."""
    spec.add_sensor(name=name, type=kind, objname=target, **{"objtype": _SITE} | settings)
