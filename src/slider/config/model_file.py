"""Links, axes and joints of a robot from its model file (MJCF or URDF) and a table of roles.

Frames are those of ``conf/robot``: parallel to the base's where joints are at zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.convert import from_dict
from slider.config.model_tree import (
    AXES,
    MAX_DIFFERENCE,
    MIRROR,
    Link,
    ModelTree,
    Roles,
    compiled,
    relative,
    rounded,
)
from slider.config.robot import LEAST_BEND, LINKS, TILTS
from slider.core.errors import require

_LIGHT = {"mass": 1e-3, "com": [0.0] * 3, "inertia": [1e-6] * 3, "products": [0.0] * 3}
_MAX_OFFSET = 1e-3  # of ankle and upper foot from the leg's axis [m]


@dataclass(frozen=True)
class ModelFile:
    """What a file and its roles give.

    Attributes:
        values: ``geometry``, ``links`` and ``joints`` of ``conf/robot``.
        held: joints without a role, with the mass that they carry [kg].
        differs: largest difference of the legs, and what has it.
        lateral: y of the base's centre, which counts as 0 [m].
        turned: by how much the pose turns the feet against the model's own zero [rad].
    """

    values: dict[str, Any]
    held: dict[str, float]
    differs: tuple[float, str]
    lateral: float
    turned: float


def read_model(path: Path, values: Mapping[str, Any]) -> ModelFile:
    """Values of a robot from the model file ``path``, with the plain values of :class:`Roles`.

    Raises:
        UserError: MuJoCo cannot read the file, or the file does not have what the roles ask for.
    """
    roles, model = from_dict(Roles, values, "robot.roles"), compiled(path)
    tree = ModelTree(model, roles)
    left, right = (_Leg(tree.order, tree.has_knee, *tree.leg(side)) for side in range(2))
    right = right.mirrored()
    length = float(np.linalg.norm(left.places["ankle"] - left.places["hip_pitch"]))
    differences = {}
    for name, place in left.places.items():
        links = right.links[name], left.links[name]
        differences[f"{LINKS[name]} links"] = links[0].difference(links[1], length)
        apart = relative(right.places[name] - place, length)
        turned = relative(right.directions[name] - left.directions[name], 1.0)
        differences[f"{name} axes"] = max(apart, turned)
        joints = [np.array(list(leg.joints[name].values())) for leg in (left, right)]
        size = np.maximum(*np.abs(joints)).clip(1e-9)
        what = f"range about roles.pose, damping or armature of {' and '.join(tree.names(name))}"
        differences[what] = relative((joints[1] - joints[0]) / size, 1.0)
    worst = max(differences, key=differences.__getitem__)
    difference = differences[worst]
    expected = "legs that are alike (also in roles.pose), or roles.side: left or right"
    alike = roles.side is not None or difference <= MAX_DIFFERENCE
    require(alike, "robot.model", expected, f"{worst} that differ by {difference:.1%}")
    leg = right if roles.side == "right" else left
    lateral = leg.places["ankle"][1]
    expected = "a left leg on the left, y > 0 (are left and right swapped?)"
    require(lateral > 0.0, "robot.roles.joints", expected, f"its ankle at y = {lateral:.3f} m")
    base, offset = tree.base()
    links = {"base": base.values(np.zeros(3)), **leg.described()}
    robot = {"geometry": leg.geometry(), "links": links, "joints": leg.joints}
    robot |= {"virtual_knee": None, "capstan": None} if leg.has_knee else {}
    return ModelFile(robot, tree.held(), (difference, worst), offset, tree.turned())


@dataclass(frozen=True)
class _Leg:
    """A leg in the base's frame: places of its axes [m], links and joints by role."""

    order: tuple[str, ...]
    has_knee: bool
    places: dict[str, np.ndarray]
    directions: dict[str, np.ndarray]
    links: dict[str, Link]
    joints: dict[str, dict[str, float]]

    def mirrored(self) -> "_Leg":
        """The right leg as a left one; its joints' ranges are those of ``ModelTree.leg``."""
        places = {name: place * MIRROR for name, place in self.places.items()}
        links = {name: link.mirrored() for name, link in self.links.items()}
        axes = self.directions.items()
        directions = {name: axis * MIRROR if name in TILTS else axis for name, axis in axes}
        return replace(self, places=places, directions=directions, links=links)

    def geometry(self) -> dict[str, Any]:
        """Axes of the hip in the frames above, leg length, height of an upper foot."""
        places, above, order = self.origins(), np.zeros(3), list(self.order)
        if "hip_yaw" not in order:
            order.insert(order.index("hip_roll"), "hip_yaw")
        axes: dict[str, Any] = {"order": order}
        for name in order:
            axes[name], above = rounded(places[name] - above), places[name]
        for name in TILTS:
            direction = self.directions.get(name, AXES[name])
            axes[name.removeprefix("hip_") + "_direction"] = rounded(direction)
        above = places["hip_pitch"]
        reach = places["ankle"] - above
        along = abs(reach[0]) <= _MAX_OFFSET and reach[2] < 0.0
        expected = "an ankle below the pitch axis in the nominal pose"
        found = f"{np.round(reach, 4).tolist()} m from it"
        if reach[2] < 0.0:
            turn = np.arctan2(reach[0], -reach[2])
            found += f"; in roles.pose turn the hip by {turn:.4f} rad about y, the ankle back"
        require(along, "robot.model", expected, found)
        geometry = {"axes": axes, "leg_length": rounded(-reach[2])}
        if self.has_knee:
            geometry["knee"] = rounded(places["slide"] - above)
            geometry["upper_foot_height"] = 1e-3  # the light link is at the knee
            ahead, expected = abs(geometry["knee"][0]), "a pose with bent knees"
            found = f"a knee {ahead:.3f} m off the line from hip to ankle"
            bent = ahead >= LEAST_BEND * geometry["leg_length"]
            require(bent, "robot.roles.pose", expected, found)
        if "upper_foot" in places:
            offset = places["upper_foot"] - above
            expected = "an upper foot above the pitch axis in the nominal pose"
            possible = float(np.abs(offset[:2]).max()) <= _MAX_OFFSET and offset[2] > 0.0
            require(possible, "robot.model", expected, f"{np.round(offset, 4).tolist()} m from it")
            geometry["upper_foot_height"] = rounded(places["upper_foot"][2] - above[2])
        return geometry

    def described(self) -> dict[str, Any]:
        """Links in the frames of their joints; light ones where there is no mass."""
        places = self.origins()
        heavy = {name: link for name, link in self.links.items() if link.mass > 0.0}
        described = {LINKS[name]: link.values(places[name]) for name, link in heavy.items()}
        return dict.fromkeys(LINKS.values(), _LIGHT) | described

    def origins(self) -> dict[str, np.ndarray]:
        """Of the joints' frames; a slide's is the pitch's, whose y, as a knee's, is the ankle's.

        The yaw of a machine that lacks it is on the roll axis.
        """
        places = {"hip_yaw": self.places["hip_roll"]} | self.places
        for name in ("hip_pitch", "slide"):  # an axis is along y: no matter where on it
            x, _, z = places[name if self.has_knee else "hip_pitch"]
            places[name] = np.array([x, places["ankle"][1], z])
        return places
