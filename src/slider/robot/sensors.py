"""Sensors of the prismatic MuJoCo model, by the names that the environment reads."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import mujoco

from slider.config.robot import Geometry
from slider.robot import names

DISTANCE_CUTOFF = 0.3  # legs further apart than this count as that far apart [m]
_SITE, _GEOM = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_GEOM
_KIND = mujoco.mjtSensor
_MOTION = (("position", _KIND.mjSENS_FRAMEPOS), ("velocity", _KIND.mjSENS_FRAMELINVEL))
# Contact sensors: (data field bits, reduction, slots), as the XML attributes data, reduce and num.
_NET_FORCE = (1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1)
_FOUND = (1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1)


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add sensors for controllers and rewards: base, motors, soles, forces on the feet."""
    _add(spec, "base_linear_velocity", _KIND.mjSENS_VELOCIMETER, names.IMU)
    _add(spec, "base_angular_velocity", _KIND.mjSENS_GYRO, names.IMU)
    for motor in names.MOTORS:
        actuator = mujoco.mjtObj.mjOBJ_ACTUATOR
        _add(spec, f"{motor}_torque", _KIND.mjSENS_ACTUATORFRC, motor, objtype=actuator)
    for side in names.SIDES:
        for quantity, kind in _MOTION:
            _add(spec, f"{side}_sole_{quantity}", kind, names.sole(side))
        _add_contact(spec, f"{side}_foot_force", names.foot(side), _NET_FORCE)
    for body in (names.BASE, *(names.tube(side) for side in names.SIDES)):
        _add_contact(spec, f"{body}_contact", body, _FOUND)


def add_instruments(spec: mujoco.MjSpec, geometry: Geometry) -> None:
    """Add sensors for metrics: heels and toes, turning feet, distances of legs."""
    height = geometry.foot_radius - geometry.ankle_height
    for side in names.SIDES:
        for end, x in zip(names.FOOT_ENDS, (-geometry.heel, geometry.toe), strict=True):
            name = names.foot_end(side, end)  # in the middle of the capsule's round end
            spec.body(names.foot(side)).add_site(name=name, pos=[x, 0, height])
            for quantity, kind in _MOTION:
                _add(spec, f"{name}_{quantity}", kind, name)
        _add(spec, f"{side}_foot_turning", _KIND.mjSENS_FRAMEANGVEL, names.sole(side))
    for first, second in names.LEG_PAIRS:
        name, ends = names.distance(first, second), {"reftype": _GEOM, "refname": second}
        kind = _KIND.mjSENS_GEOMDIST
        _add(spec, name, kind, first, objtype=_GEOM, cutoff=DISTANCE_CUTOFF, **ends)


def _add_contact(spec: mujoco.MjSpec, name: str, geom: str, content: tuple[int, int, int]) -> None:
    """Add a sensor of the contact of a geom with the floor."""
    ends = {"objtype": _GEOM, "reftype": _GEOM, "refname": geom}
    _add(spec, name, _KIND.mjSENS_CONTACT, names.FLOOR, intprm=content, **ends)


def _add(spec: mujoco.MjSpec, name: str, kind: mujoco.mjtSensor, target: str, **settings) -> None:
    """Add a sensor of an object, by default of a site."""
    spec.add_sensor(name=name, type=kind, objname=target, **{"objtype": _SITE} | settings)
