"""Sensors of the prismatic MuJoCo model, by the names that the environment reads."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import mujoco

from slider.config.robot import Geometry
from slider.robot import names

DISTANCE_CUTOFF = 0.3  # legs further apart than this count as that far apart [m]
# Contact sensors: (data field bits, reduction, slots), as the XML attributes data, reduce and num.
_NET_FORCE = (1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1)
_FOUND = (1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1)


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Sense what controllers and rewards read: the base, motors, soles, forces on the feet."""
    site, sensor = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtSensor
    for name, kind in (
        ("base_linear_velocity", sensor.mjSENS_VELOCIMETER),
        ("base_angular_velocity", sensor.mjSENS_GYRO),
    ):
        spec.add_sensor(name=name, type=kind, objtype=site, objname=names.IMU)
    for motor in names.MOTORS:
        spec.add_sensor(
            name=f"{motor}_torque",
            type=sensor.mjSENS_ACTUATORFRC,
            objtype=mujoco.mjtObj.mjOBJ_ACTUATOR,
            objname=motor,
        )
    for side in names.SIDES:
        for name, kind in (
            ("position", sensor.mjSENS_FRAMEPOS),
            ("velocity", sensor.mjSENS_FRAMELINVEL),
        ):
            spec.add_sensor(
                name=f"{side}_sole_{name}", type=kind, objtype=site, objname=names.sole(side)
            )
        _add_contact_sensor(spec, f"{side}_foot_force", names.foot(side), _NET_FORCE)
    for body in (names.BASE, *(names.tube(side) for side in names.SIDES)):
        _add_contact_sensor(spec, f"{body}_contact", body, _FOUND)


def add_instruments(spec: mujoco.MjSpec, geometry: Geometry) -> None:
    """Sense what metrics need beyond that: heels and toes, turning feet, distances of legs."""
    sensor, site, geom = mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_GEOM
    for side in names.SIDES:
        _add_foot_ends(spec, geometry, side)
        spec.add_sensor(
            name=f"{side}_foot_turning",
            type=sensor.mjSENS_FRAMEANGVEL,
            objtype=site,
            objname=names.sole(side),
        )
    for first, second in names.LEG_PAIRS:
        spec.add_sensor(
            name=names.distance(first, second),
            type=sensor.mjSENS_GEOMDIST,
            objtype=geom,
            objname=first,
            reftype=geom,
            refname=second,
            cutoff=DISTANCE_CUTOFF,
        )


def _add_foot_ends(spec: mujoco.MjSpec, geometry: Geometry, side: str) -> None:
    """Sites in the middle of the capsule's round ends, and how they move."""
    sensor = mujoco.mjtSensor
    height = geometry.foot_radius - geometry.ankle_height
    for end, x in zip(names.FOOT_ENDS, (-geometry.heel, geometry.toe), strict=True):
        name = names.foot_end(side, end)
        spec.body(names.foot(side)).add_site(name=name, pos=[x, 0, height])
        for quantity, kind in (
            ("position", sensor.mjSENS_FRAMEPOS),
            ("velocity", sensor.mjSENS_FRAMELINVEL),
        ):
            spec.add_sensor(
                name=f"{name}_{quantity}",
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=name,
            )


def _add_contact_sensor(
    spec: mujoco.MjSpec, name: str, geom: str, content: tuple[int, int, int]
) -> None:
    """Sense the contact of a geom with the floor."""
    spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname=names.FLOOR,
        reftype=mujoco.mjtObj.mjOBJ_GEOM,
        refname=geom,
        intprm=content,
    )
