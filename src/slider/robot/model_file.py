"""Links, axes and joints of a robot from its model file (MJCF or URDF) and a table of roles.

Frames are those of ``conf/robot``: parallel to the base frame when all joints are at zero.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.robot import HIP_JOINTS, LINKS, SOLE_LINKS, Body
from slider.core.errors import require
from slider.robot.model_compile import compiled
from slider.robot.model_motors import drives
from slider.robot.model_pose import MAX_OFFSET, MAX_TILT
from slider.robot.model_tree import (
    AXES,
    LEAST_MASS,
    OPTIONAL_JOINTS,
    ModelTree,
    Part,
    Roles,
    relative,
    rounded,
)

_LIGHT = {"mass": 1e-3, "com": [0.0] * 3, "inertia": [1e-6] * 3, "products": [0.0] * 3}
_ROUNDING = 1e-12  # of moments of inertia [kg m²]
_AHEAD = 2e-3  # least forward offset of a foot [m]
_SAME_MOTOR = 0.01  # largest relative difference of the motors of both legs
APART = 5e-3  # largest distance of a foot's middle from its line or its roll axis [m]


@dataclass(frozen=True)
class ModelFile:
    """Robot parameters from a model file and its roles.

    Attributes:
        values: ``geometry``, ``links`` and ``joints`` of ``conf/robot``.
        held: fixed joints (without a role), with the mass that they carry [kg].
        differs: largest relative difference between the legs, and its quantity.
        lateral: y of the base's centre of mass, which is set to 0 [m].
        foot_rotation: rotation of the feet between the pose and the model's zero pose [rad].
        pose: joint positions of the pose that were solved, by joint.
        remarks: texts about what was ignored, rounded or assumed.
        foot: position of the sole, as returned by :meth:`Foot.line`; empty without geometry.
        outlines: outlines of the left foot, as returned by :meth:`Foot.outlines`.
        formulas: left and right joint of each role in terms of the model's joints.
        motors: source of each value of ``drives`` and ``gains``, by dotted key.
    """

    values: dict[str, Any]
    held: dict[str, float]
    differs: tuple[float, str]
    lateral: float
    foot_rotation: float
    pose: dict[str, float]
    remarks: list[str]
    foot: dict[str, float]
    outlines: list[Any]
    formulas: dict[str, str]
    motors: dict[str, str]


def read_model(
    path: Path, values: Mapping[str, Any], typed: Mapping[str, Any] | None = None
) -> ModelFile:
    """Values of a robot from the model file ``path``, with the plain values of :class:`Roles`.

    ``typed`` are values of the robot file by dotted key, which take precedence over the model's.

    Raises:
        UserError: MuJoCo cannot read the file, or the file lacks what the roles refer to.
    """
    roles = from_dict(Roles, values, "robot.roles")
    model, told, speeds = compiled(path, roles)
    typed = typed or {}
    tree = ModelTree(model, roles, typed)
    tree.remarks += told
    left, right = tree.leg(0), tree.leg(1)
    differs = _compare(left, right, tree, roles)
    leg = right if roles.side == "right" else left
    shape, lateral = tree.foot(int(leg is right)), leg["ankle"].place[1]
    foot = shape.line(leg["ankle"].place, -1.0 if leg is right else 1.0) if shape else {}
    _check_side(lateral, leg["ankle_roll" if tree.has_sole else "ankle"], foot, roles.forward)
    if not shape and roles.foot_y is None and not tree.has_sole:
        other = (left if leg is right else right)["ankle"].place[1]
        text = f"its line is at the ankle's anchor, y = {lateral:.3f} m ({other:.3f} on the other"
        text = f"no geometry of a foot that can be read: {text} side); roles.foot_y types it"
        tree.remarks.append(text)
    line = roles.foot_y if roles.foot_y is not None else foot.get("y") or lateral
    if tree.has_sole:
        middle, line = line, leg["ankle_roll"].place[1]
        expected = f"an axis within {APART:g} m of the foot's middle, y = {middle:.3f} m"
        within = abs(line - middle) <= APART or not (shape or roles.foot_y is not None)
        require(within, "robot.roles.joints.ankle_roll", expected, f"y = {line:.3f} m")
    require(line > 0.0, "robot.roles.foot_y", "y > 0 of the left foot", f"{line:.3f} m")
    (base, offset), places = tree.base(), _origins(leg, tree.has_knee, line)
    if abs((places["ankle"] - places["hip_pitch"])[0]) > MAX_OFFSET:
        places = _origins(leg, tree.has_knee, lateral)  # tilted axes: the pose differs
    below = SOLE_LINKS if tree.has_sole else LINKS
    bodies = {below[name]: (part.body, places[name]) for name, part in leg.items()}
    bodies["base"] = base, np.zeros(3)
    links = dict.fromkeys(("base", *below.values()), _LIGHT)
    links |= {name: _values(*b) for name, b in bodies.items() if b[0].mass > LEAST_MASS}
    if light := [name for name in bodies if links[name] is _LIGHT]:
        tree.remarks.append(f"no mass in the model, 1 g here: {', '.join(light)}")
    joints = {name: part.joint for name, part in leg.items()}
    joints |= {name: joint for name, joint in OPTIONAL_JOINTS.items() if name not in leg}
    robot = {"geometry": _geometry(leg, places, tree), "links": links, "joints": joints}
    if tree.has_knee or tree.has_sole:
        robot |= {"virtual_knee": None} | ({"capstan": None} if tree.has_knee else {})
    if tree.has_sole:
        robot |= {name: robot[name] | {"upper_foot": None} for name in ("links", "joints")}
    if shape and abs(tilt := shape.tilt()) > MAX_TILT:
        text = f"turn the ankle by {tilt:.2f} rad about y"
        tree.remarks.append(f"the model's sole is not level in roles.pose: {text}")
        foot = {name: foot[name] for name in ("y", "width")}
    ends = {name: rounded(foot[name]) for name in ("ankle_height", "toe", "heel") if name in foot}
    robot["geometry"] |= {name: value for name, value in ends.items() if value > 0.0}
    if tree.has_sole:
        robot["geometry"]["sole"] = _sole(places, foot, typed)
    found = [tree.motors(side, speeds) for side in (int(leg is right), int(leg is left))]
    tree.remarks += _motors_apart(*found)
    values, motors = drives(found[0], typed)
    told = tree.foot_rotation, tree.solved, tree.remarks, foot
    drawn = shape.outlines() if shape else []
    formulas = {name: f"{part.formula}, {right[name].formula}" for name, part in left.items()}
    return ModelFile(robot | values, tree.held(), differs, offset, *told, drawn, formulas, motors)


def _compare(
    left: Mapping[str, Part], right: Mapping[str, Part], tree: ModelTree, roles: Roles
) -> tuple[float, str]:
    """Largest difference between the legs and its quantity; limited if ``roles.side`` is null."""
    differences, length = {}, tree.reach
    for name, part in left.items():
        other = right[name]
        link = (SOLE_LINKS if tree.has_sole else LINKS)[name]
        differences[f"{link} links"] = _difference(other.body, part.body, length)
        away = other.place - part.place
        across = away - (away @ part.axis) * part.axis  # the position along the axis is arbitrary
        apart = 0.0 if name == "slide" and not tree.has_knee else relative(across, length)
        differences[f"{name} axes"] = max(apart, relative(other.axis - part.axis, 1.0))
        common = [key for key in part.joint if key in other.joint]
        joints = [np.array([each.joint[key] for key in common]) for each in (part, other)]
        size = np.maximum(*np.abs(joints)).clip(1e-9)
        what = f"range about roles.pose, damping or armature of {' and '.join(tree.names(name))}"
        differences[what] = relative((joints[1] - joints[0]) / size, 1.0)
    worst = max(differences, key=differences.__getitem__)
    expected = "legs that are alike (also in roles.pose), roles.side: left or right, or a larger "
    expected += f"roles.tolerance than {roles.tolerance:g}"
    alike = roles.side is not None or differences[worst] <= roles.tolerance
    require(alike, "robot.model", expected, f"{worst} that differ by {differences[worst]:.1%}")
    return differences[worst], worst


def _check_side(lateral: float, last: Part, foot: Mapping[str, float], forward: str) -> None:
    """Reject a left leg on the right; the foot, below joint ``last``, shows the probable cause."""
    heavy = last.body.mass > LEAST_MASS
    ahead = foot["toe"] - foot["heel"] if foot else (last.body.com - last.place)[0] * heavy
    other = forward[1:] if forward.startswith("-") else f"-{forward}"
    looks = f"the base looks along {other.replace('-', '−')}: roles.forward: {other}"
    cause = "left and right are swapped"
    if abs(ahead) <= _AHEAD:
        cause = f"{cause}, or {looks}"
    elif ahead < 0.0:
        cause = looks
    found = f"its ankle at y = {lateral:.3f} m ({cause})"
    require(lateral > 0.0, "robot.roles.joints", "a left leg at y > 0", found)


def _motors_apart(motors: Mapping[str, Any], others: Mapping[str, Any]) -> Iterator[str]:
    """Remarks on quantities of motors that differ between the legs."""
    for name, motor in motors.items():
        for quantity in sorted(motor.keys() & others[name].keys()):
            here, there = motor[quantity][0], others[name][quantity][0]
            if relative(here - there, max(here, there, 1e-9)) > _SAME_MOTOR:
                yield f"{quantity} of {name} is {here:g}, on the other leg {there:g}"


def _geometry(
    leg: Mapping[str, Part], places: Mapping[str, np.ndarray], tree: ModelTree
) -> dict[str, Any]:
    """Hip axes in their parent frames, leg length, knee, and height of an upper foot."""
    above, order = np.zeros(3), list(tree.order)
    if "hip_yaw" not in order:
        order.insert(order.index("hip_roll"), "hip_yaw")
    axes: dict[str, Any] = {"order": order}
    for name in order:
        axes[name], above = rounded(places[name] - above), places[name]
    for name in HIP_JOINTS:
        direction = leg[name].axis if name in leg else AXES[name]
        axes[name.removeprefix("hip_") + "_direction"] = rounded(direction)
    above = places["hip_pitch"]
    reach = places["ankle"] - above
    expected = "an ankle below the pitch axis in the nominal pose"
    require(reach[2] < 0.0, "robot.model", expected, f"{np.round(reach, 4).tolist()} m from it")
    geometry = {"axes": axes, "leg_length": rounded(-reach[2])}
    geometry["ankle_direction"] = rounded(leg["ankle"].axis)
    if tree.has_knee:
        geometry["knee_direction"] = rounded(leg["slide"].axis)
        geometry["knee"] = rounded(places["slide"] - above)
        geometry["upper_foot_height"] = 1e-3  # the light link is at the knee
    if "upper_foot" in leg:
        offset = places["upper_foot"] - above
        expected = "an upper foot above the pitch axis in the nominal pose"
        possible = float(np.abs(offset[:2]).max()) <= MAX_OFFSET and offset[2] > 0.0
        require(possible, "robot.model", expected, f"{np.round(offset, 4).tolist()} m from it")
        geometry["upper_foot_height"] = rounded(offset[2])
    return geometry


def _sole(
    places: Mapping[str, np.ndarray], foot: Mapping[str, float], typed: Mapping[str, Any]
) -> dict[str, float]:
    """Height of the roll axis and width; values of the robot file take precedence."""
    keys = {"geometry.ankle_height": "ankle_height", "geometry.sole.width": "width"}
    found = {key: foot[name] for key, name in keys.items() if name in foot} | dict(typed)
    for key in keys:
        expected = "a number in the robot's file, or the geometry of a level sole"
        require(isinstance(found.get(key), int | float), f"robot.{key}", expected, "neither")
    height = found["geometry.ankle_height"] + (places["ankle_roll"] - places["ankle"])[2]
    return {"roll_height": rounded(height), "width": rounded(found["geometry.sole.width"])}


def _origins(leg: Mapping[str, Part], has_knee: bool, line: float) -> dict[str, np.ndarray]:
    """Origins of joint frames; those of pitch, slide, ankle and upper foot have the foot line's y.

    A slide has the origin of the pitch. A missing yaw joint is placed on the roll axis.
    """
    places = {"hip_yaw": leg["hip_roll"].place} | {name: part.place for name, part in leg.items()}
    for name in ("hip_pitch", "slide", "ankle", "upper_foot"):  # positions along axes are arbitrary
        if part := leg.get("hip_pitch" if name == "slide" and not has_knee else name):
            places[name] = part.place + part.axis * (line - part.place[1]) / part.axis[1]
            places[name][1] = line
    if roll := leg.get("ankle_roll"):
        ahead = (places["ankle"] - roll.place)[0]
        places["ankle_roll"] = roll.place + roll.axis * ahead / roll.axis[0]
    return places


def _difference(link: Body, other: Body, length: float) -> float:
    """Largest relative difference of mass, inertia, and centre of mass (by ``length`` [m])."""
    if max(link.mass, other.mass) < LEAST_MASS:
        return 0.0
    scale = max(link.mass, other.mass), length, np.abs(link.inertia).max()
    parts = link.mass - other.mass, link.com - other.com, link.inertia - other.inertia
    return max(relative(part, size) for part, size in zip(parts, scale, strict=True))


def _values(link: Body, origin: np.ndarray) -> dict[str, Any]:
    """Values of a link of ``conf/robot``, relative to ``origin`` (3,) [m]."""
    moments, products = np.diag(link.inertia), link.inertia[[0, 0, 1], [1, 2, 2]]
    values = {"mass": link.mass, "com": link.com - origin, "products": products}
    least, middle, greatest = np.linalg.eigvalsh(link.inertia)
    is_plate = greatest - least - middle > -_ROUNDING  # if turned, MuJoCo may refuse its rounding
    if is_plate and np.abs(products).max() > _ROUNDING:
        moments = moments + 4.0 * _ROUNDING
    return {name: rounded(value) for name, value in (values | {"inertia": moments}).items()}
