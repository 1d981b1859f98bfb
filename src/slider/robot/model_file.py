"""Links, axes and joints of a robot from its model file (MJCF or URDF) and a table of roles.

Frames are those of ``conf/robot``: parallel to the base's where joints are at zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.robot import HIP_JOINTS, LINKS, Body
from slider.core.errors import require
from slider.robot.model_pose import MAX_OFFSET
from slider.robot.model_tree import (
    AXES,
    MAX_DIFFERENCE,
    OPTIONAL_JOINTS,
    ModelTree,
    Part,
    Roles,
    compiled,
    relative,
    rounded,
)

_LIGHT = {"mass": 1e-3, "com": [0.0] * 3, "inertia": [1e-6] * 3, "products": [0.0] * 3}


@dataclass(frozen=True)
class ModelFile:
    """What a file and its roles give.

    Attributes:
        values: ``geometry``, ``links`` and ``joints`` of ``conf/robot``.
        held: joints without a role, with the mass that they carry [kg].
        differs: largest difference of the legs, and what has it.
        lateral: y of the base's centre, which counts as 0 [m].
        foot_rotation: angle of the feet between the pose and the model's own zero [rad].
        pose: what was solved of the pose, by joint.
        ignored: springs and constraints that do not touch a leg.
    """

    values: dict[str, Any]
    held: dict[str, float]
    differs: tuple[float, str]
    lateral: float
    foot_rotation: float
    pose: dict[str, float]
    ignored: list[str]


def read_model(path: Path, values: Mapping[str, Any]) -> ModelFile:
    """Values of a robot from the model file ``path``, with the plain values of :class:`Roles`.

    Raises:
        UserError: MuJoCo cannot read the file, or the file does not have what the roles ask for.
    """
    roles, model = from_dict(Roles, values, "robot.roles"), compiled(path)
    tree = ModelTree(model, roles)
    left, right = tree.leg(0), tree.leg(1)
    length = float(np.linalg.norm(left["ankle"].place - left["hip_pitch"].place))
    differences = {}
    for name, part in left.items():
        other = right[name]
        differences[f"{LINKS[name]} links"] = _difference(other.body, part.body, length)
        apart = relative(other.place - part.place, length)
        differences[f"{name} axes"] = max(apart, relative(other.axis - part.axis, 1.0))
        joints = [np.array(list(each.joint.values())) for each in (part, other)]
        size = np.maximum(*np.abs(joints)).clip(1e-9)
        what = f"range about roles.pose, damping or armature of {' and '.join(tree.names(name))}"
        differences[what] = relative((joints[1] - joints[0]) / size, 1.0)
    worst = max(differences, key=differences.__getitem__)
    difference = differences[worst]
    expected = "legs that are alike (also in roles.pose), or roles.side: left or right"
    alike = roles.side is not None or difference <= MAX_DIFFERENCE
    require(alike, "robot.model", expected, f"{worst} that differ by {difference:.1%}")
    leg = right if roles.side == "right" else left
    lateral = leg["ankle"].place[1]
    expected = "a left leg at y > 0 (are left and right swapped, or does the base look along −x?)"
    require(lateral > 0.0, "robot.roles.joints", expected, f"its ankle at y = {lateral:.3f} m")
    (base, offset), places = tree.base(), _origins(leg, tree.has_knee)
    links = {"base": _values(base, np.zeros(3))} | dict.fromkeys(LINKS.values(), _LIGHT)
    heavy = {name: part.body for name, part in leg.items() if part.body.mass > 0.0}
    links |= {LINKS[name]: _values(body, places[name]) for name, body in heavy.items()}
    joints = {name: part.joint for name, part in leg.items()}
    joints |= {name: joint for name, joint in OPTIONAL_JOINTS.items() if name not in leg}
    robot = {"geometry": _geometry(leg, places, tree), "links": links, "joints": joints}
    robot |= {"virtual_knee": None, "capstan": None} if tree.has_knee else {}
    differs = difference, worst
    angle = tree.foot_rotation()
    return ModelFile(robot, tree.held(), differs, offset, angle, tree.solved, tree.ignored)


def _geometry(
    leg: Mapping[str, Part], places: Mapping[str, np.ndarray], tree: ModelTree
) -> dict[str, Any]:
    """Axes of the hip in the frames above, leg length, height of an upper foot."""
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


def _origins(leg: Mapping[str, Part], has_knee: bool) -> dict[str, np.ndarray]:
    """Of the joints' frames; a slide's is the pitch's, whose y, as a knee's, is the ankle's.

    The yaw of a machine that lacks it is on the roll axis.
    """
    places = {"hip_yaw": leg["hip_roll"].place} | {name: part.place for name, part in leg.items()}
    for name in ("hip_pitch", "slide"):  # no matter where on an axis
        part = leg[name if has_knee else "hip_pitch"]
        sideways = places["ankle"][1] - part.place[1]
        places[name] = part.place + part.axis * sideways / part.axis[1]
        places[name][1] = places["ankle"][1]
    return places


def _difference(link: Body, other: Body, length: float) -> float:
    """Largest of mass and moments, relative, and of the centre by ``length`` [m]."""
    if link.mass == other.mass == 0.0:
        return 0.0
    scale = max(link.mass, other.mass), length, np.abs(link.inertia).max()
    parts = link.mass - other.mass, link.com - other.com, link.inertia - other.inertia
    return max(relative(part, size) for part, size in zip(parts, scale, strict=True))


def _values(link: Body, origin: np.ndarray) -> dict[str, Any]:
    """As in ``conf/robot``, about ``origin`` (3,) [m]."""
    moments, products = np.diag(link.inertia), link.inertia[[0, 0, 1], [1, 2, 2]]
    values = {"mass": link.mass, "com": link.com - origin, "inertia": moments}
    return {name: rounded(value) for name, value in (values | {"products": products}).items()}
