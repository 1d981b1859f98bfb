"""Links, axes and joints of a robot from its model file (MJCF or URDF) and a table of roles.

MuJoCo compiles the file. Joints without a role are held, and their bodies are welded to the link
above. Frames are those of ``conf/robot``: parallel to the base's where joints are at zero.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from slider.core.errors import UserError, require

LINKS = {
    "hip_yaw": "yaw",
    "hip_roll": "roll",
    "hip_pitch": "pitch",
    "slide": "tube",
    "ankle": "foot",
    "upper_foot": "upper_foot",
}
"""Joint, and the link below it."""
ABSENT = ("hip_yaw", "upper_foot")
"""Joints that a machine may lack: a light link and a narrow range take their place."""
_AXES = dict.fromkeys(LINKS, (0.0, 1.0, 0.0)) | {
    "hip_yaw": (0.0, 0.0, 1.0),
    "hip_roll": (1.0, 0.0, 0.0),
    "slide": (0.0, 0.0, -1.0),
}
_MOVES = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
_LIGHT = {"mass": 0.01, "com": [0.0] * 3, "inertia": [1e-4] * 3, "products": [0.0] * 3}
_NARROW = {"lower": -0.005, "upper": 0.005, "damping": 0.2}
_ARMATURE = {"hip_yaw": 0.0, "upper_foot": 0.001}  # of a joint that the machine lacks [kg m²]
_SIDES = ("left", "right")
_MIRROR = np.array([1.0, -1.0, 1.0])
_MAX_TILT = 1e-3  # of an axis against the frame's [rad]
_MAX_OFFSET = 1e-3  # of ankle and upper foot from the leg's axis, of the base from its plane [m]
_MAX_DIFFERENCE = 0.01  # of left and right: relative; of places, by the leg's length


@dataclass(frozen=True)
class ModelFile:
    """What a file and its roles give.

    Attributes:
        values: ``geometry``, ``links`` and ``joints`` of ``conf/robot``.
        held: joints without a role, with the mass that they carry [kg].
        differs: largest difference of the legs, and what has it.
    """

    values: dict[str, Any]
    held: dict[str, float]
    differs: tuple[float, str]


@dataclass(frozen=True)
class _Link:
    """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it, axes of the base."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray

    def mirrored(self) -> "_Link":
        return _Link(self.mass, self.com * _MIRROR, self.inertia * np.outer(_MIRROR, _MIRROR))

    def difference(self, other: "_Link", length: float) -> float:
        """Largest of mass and moments, relative, and of the centre by ``length`` [m]."""
        if self.mass == other.mass == 0.0:
            return 0.0
        scale = max(self.mass, other.mass), length, np.abs(self.inertia).max()
        parts = self.mass - other.mass, self.com - other.com, self.inertia - other.inertia
        return max(_relative(part, size) for part, size in zip(parts, scale, strict=True))

    def values(self, origin: np.ndarray) -> dict[str, Any]:
        moments = self.inertia
        return {
            "mass": _rounded(self.mass),
            "com": _rounded(self.com - origin),
            "inertia": _rounded(np.diag(moments)),
            "products": _rounded(moments[[0, 0, 1], [1, 2, 2]]),
        }


def read_model(path: Path, roles: Mapping[str, Any]) -> ModelFile:
    """Values of a robot from the model file ``path``.

    ``roles`` has ``base``, the name of a body; ``joints``, for each role its left and its right
    joint (null for a role that the machine lacks); optional ``pose``, positions of joints that
    count as zero or are held there; optional ``side``, ``left`` or ``right``, the leg to take
    where the two differ.

    Raises:
        UserError: MuJoCo cannot read the file, or the file does not have what the roles ask for.
    """
    unknown = set(roles) - {"base", "joints", "pose", "side"}
    require(not unknown, "robot.roles", "base, joints, pose, side", ", ".join(map(str, unknown)))
    model = _compiled(path)
    joints = _joints(model, roles)
    tree = _Tree(model, roles, joints)
    legs = [tree.leg(side) for side in range(2)]
    length = float(np.linalg.norm(legs[0].places["ankle"] - legs[0].places["hip_pitch"]))
    differences = {
        f"{LINKS[name]} links": legs[1].links[name].mirrored().difference(link, length)
        for name, link in legs[0].links.items()
    }
    for name, place in legs[0].places.items():
        differences[f"{name} axes"] = _relative(legs[1].places[name] * _MIRROR - place, length)
        joints = [np.array(list(leg.joints[name].values())) for leg in legs]
        size = np.maximum(*np.abs(joints)).clip(1e-9)
        differences[f"{name} joints"] = _relative((joints[1] - joints[0]) / size, 1.0)
    worst = max(differences, key=differences.__getitem__)
    side = roles.get("side")
    require(side in (None, *_SIDES), "robot.roles.side", "left or right", side)
    expected = "legs that are alike, or roles.side: left or right"
    found = f"{worst} that differ by {differences[worst]:.1%}"
    require(
        side is not None or differences[worst] <= _MAX_DIFFERENCE, "robot.model", expected, found
    )
    leg = legs[0] if side != "right" else legs[1].mirrored()
    lateral = leg.places["ankle"][1]
    expected = "a left leg on the left, y > 0 (are left and right swapped?)"
    require(lateral > 0.0, "robot.roles.joints", expected, f"its ankle at y = {lateral:.3f} m")
    links = {"base": tree.base().values(np.zeros(3)), **leg.described()}
    values = {"geometry": leg.geometry(), "links": links, "joints": leg.joints}
    return ModelFile(values, tree.held(), (differences[worst], worst))


@dataclass(frozen=True)
class _Leg:
    """A leg in the base's frame: places of its axes [m], links and joints by role."""

    places: dict[str, np.ndarray]
    links: dict[str, _Link]
    joints: dict[str, dict[str, float]]

    def mirrored(self) -> "_Leg":
        """The right leg as a left one; its joints' ranges are those of ``_Tree.leg``."""
        places = {name: place * _MIRROR for name, place in self.places.items()}
        links = {name: link.mirrored() for name, link in self.links.items()}
        return _Leg(places, links, self.joints)

    def geometry(self) -> dict[str, Any]:
        """Axes of the hip in the frames above, leg length, height of an upper foot."""
        places, above = self._origins(), np.zeros(3)
        axes = {}
        for name in ("hip_yaw", "hip_roll", "hip_pitch"):
            axes[name], above = _rounded(places[name] - above), places[name]
        reach = places["ankle"] - above
        along = abs(reach[0]) <= _MAX_OFFSET and reach[2] < 0.0
        expected = "an ankle below the pitch axis in the nominal pose"
        require(along, "robot.model", expected, f"{np.round(reach, 4).tolist()} m from it")
        geometry = {"axes": axes, "leg_length": _rounded(-reach[2])}
        if "upper_foot" in places:
            offset = places["upper_foot"] - above
            expected = "an upper foot above the pitch axis in the nominal pose"
            possible = float(np.abs(offset[:2]).max()) <= _MAX_OFFSET and offset[2] > 0.0
            require(possible, "robot.model", expected, f"{np.round(offset, 4).tolist()} m from it")
            geometry["upper_foot_height"] = _rounded(places["upper_foot"][2] - above[2])
        return geometry

    def described(self) -> dict[str, Any]:
        """Links in the frames of their joints; light ones where there is no mass."""
        places = self._origins() | {"slide": self._origins()["hip_pitch"]}
        return {
            LINKS[name]: self.links[name].values(places[name])
            if self.links.get(name) and self.links[name].mass > 0.0
            else dict(_LIGHT)
            for name in LINKS
        }

    def _origins(self) -> dict[str, np.ndarray]:
        """The yaw of a machine that lacks it is on the roll axis; the pitch's y is the ankle's."""
        places = {"hip_yaw": self.places["hip_roll"]} | self.places
        pitch = places["hip_pitch"].copy()
        pitch[1] = places["ankle"][1]  # a pitch axis is along y: no matter where on it
        return places | {"hip_pitch": pitch}


class _Tree:
    """A compiled model in its nominal pose, the base at the origin."""

    def __init__(
        self, model: mujoco.MjModel, roles: Mapping[str, Any], joints: dict[str, tuple[int, int]]
    ) -> None:
        self._model, self._data, self._joints = model, mujoco.MjData(model), joints
        self._base = _body(model, roles.get("base"))
        require(self._base > 0, "robot.roles.base", "the body of the base", "world")
        self._zero = self._pose(roles.get("pose") or {})
        mujoco.mj_kinematics(model, self._data)
        mujoco.mj_comPos(model, self._data)
        self._turn = self._data.xmat[self._base].reshape(3, 3).T
        self._owners = self._find_owners()
        for side in range(2):
            self._check_order(side)

    def _pose(self, pose: Mapping[str, float]) -> np.ndarray:
        """Positions (njnt,) that count as zero."""
        model, zero = self._model, np.zeros(self._model.njnt)
        require(isinstance(pose, Mapping), "robot.roles.pose", "a position per joint", pose)
        for name, value in pose.items():
            possible = isinstance(value, int | float) and np.isfinite(value)
            require(possible, f"robot.roles.pose.{name}", "a number in rad or m", value)
            zero[_joint(model, name)] = value
        for index in range(model.njnt):
            if model.jnt_type[index] in _MOVES:
                self._data.qpos[model.jnt_qposadr[index]] = zero[index]
        return zero

    def _find_owners(self) -> np.ndarray:
        """Joint with a role (nbody,) that moves each body, −1 for the base, −2 for others."""
        model, owners = self._model, np.full(self._model.nbody, -2)
        roles = {index for pair in self._joints.values() for index in pair}
        root = model.body_rootid[self._base]
        for body in range(1, model.nbody):  # parents come first
            if model.body_rootid[body] != root:
                continue
            start, count = model.body_jntadr[body], model.body_jntnum[body]
            own = [index for index in range(start, start + count) if index in roles]
            parent = owners[model.body_parentid[body]]
            owners[body] = own[-1] if own else max(parent, -1)
        return owners

    def _check_order(self, side: int) -> None:
        """Joints with a role follow one another from the base to the ankle."""
        model = self._model
        for name in ("ankle", "upper_foot"):
            if name not in self._joints:
                continue
            chain, body = [], model.jnt_bodyid[self._joints[name][side]]
            while body > 0 and body != self._base:
                start, count = model.body_jntadr[body], model.body_jntnum[body]
                chain += reversed(range(start, start + count))
                body = model.body_parentid[body]
            key = f"robot.roles.joints.{name}"
            require(body == self._base, key, "a joint below the base", model.joint(chain[0]).name)
            named = {pair[side]: role for role, pair in self._joints.items()}
            order = [named[index] for index in reversed(chain) if index in named]
            expected = [role for role in LINKS if role in self._joints]
            expected = [r for r in expected if r == name or r not in ("ankle", "upper_foot")]
            require(order == expected, key, ", ".join(expected), ", ".join(order))

    def leg(self, side: int) -> _Leg:
        """The left or the right leg."""
        places, links, joints = {}, {}, {}
        for name, pair in self._joints.items():
            places[name] = self._turn @ (self._data.xanchor[pair[side]] - self._origin)
            links[name] = self._joined(np.flatnonzero(self._owners == pair[side]))
            joints[name] = self._joint(name, side)
        return _Leg(
            places,
            links,
            joints | {n: _NARROW | {"armature": _ARMATURE[n]} for n in LINKS if n not in joints},
        )

    @property
    def _origin(self) -> np.ndarray:
        return self._data.xpos[self._base]

    def base(self) -> _Link:
        """The base and all that is welded to it, with the plane of symmetry at y = 0."""
        base = self._joined(np.flatnonzero(self._owners == -1))
        plane = abs(base.com[1]) <= _MAX_OFFSET
        expected = f"a base whose centre has y = 0 within {_MAX_OFFSET} m"
        require(plane, "robot.model", expected, f"{base.com[1]:.4f} m")
        skewed = _relative(base.inertia - base.mirrored().inertia, np.abs(base.inertia).max())
        expected = f"a base with Ixy = Iyz = 0 within {_MAX_DIFFERENCE:.0%} of its moments"
        found = f"{base.inertia[0, 1]:.4g} and {base.inertia[1, 2]:.4g} kg m²"
        require(skewed <= 2 * _MAX_DIFFERENCE, "robot.model", expected, found)
        symmetric = (base.inertia + base.mirrored().inertia) / 2
        return _Link(base.mass, base.com * [1.0, 0.0, 1.0], symmetric)

    def held(self) -> dict[str, float]:
        """Joints without a role, and the mass below them [kg]."""
        model, roles = self._model, {index for pair in self._joints.values() for index in pair}
        root = model.body_rootid[self._base]
        return {
            model.joint(index).name
            or f"a joint of {model.body(model.jnt_bodyid[index]).name}": float(
                model.body_subtreemass[model.jnt_bodyid[index]]
            )
            for index in range(model.njnt)
            if index not in roles
            and model.jnt_type[index] != _FREE
            and model.body_rootid[model.jnt_bodyid[index]] == root
        }

    def _joint(self, name: str, side: int) -> dict[str, float]:
        """Range and passive properties, of a left leg."""
        model, index = self._model, self._joints[name][side]
        key = f"robot.roles.joints.{name}"
        slides, found = name == "slide", model.jnt_type[index]
        kind = _MOVES[slides]
        text = model.joint(index).name
        require(found == kind, key, "a slide" if slides else "a hinge", text)
        axis = self._turn @ self._data.xaxis[index]
        sign = float(np.sign(axis @ _AXES[name]))
        turned = np.abs(sign * axis - _AXES[name]).max()
        expected = f"an axis along {'xyz'[int(np.abs(_AXES[name]).argmax())]}"
        possible = turned <= _MAX_TILT
        require(possible, key, expected, f"{text} along {np.round(axis, 3).tolist()}")
        require(bool(model.jnt_limited[index]), key, "a joint with a range", f"{text} without")
        if side == 1 and name in ("hip_yaw", "hip_roll"):
            sign = -sign  # the reflection turns these
        ends = sign * (model.jnt_range[index] - self._zero[index])
        most = np.inf if slides else 2 * np.pi
        expected = "a range that holds the nominal pose" + ("" if slides else ", in rad")
        found = f"{text} from {ends.min():.4g} to {ends.max():.4g}"
        possible = ends.min() <= 0.0 <= ends.max() and np.abs(ends).max() <= most
        require(bool(possible), key, expected, found)
        dof = model.jnt_dofadr[index]
        return {
            "lower": _rounded(ends.min()),
            "upper": _rounded(ends.max()),
            "damping": _rounded(model.dof_damping[dof]),
            "armature": _rounded(model.dof_armature[dof]),
        }

    def _joined(self, bodies: np.ndarray) -> _Link:
        """Bodies as one, in the base's frame."""
        model, data = self._model, self._data
        masses = model.body_mass[bodies]
        mass = float(masses.sum())
        places = (data.xipos[bodies] - self._origin) @ self._turn.T
        com = masses @ places / mass if mass > 0.0 else np.zeros(3)
        inertia = np.zeros((3, 3))
        for body, place in zip(bodies, places - com, strict=True):
            turn = self._turn @ data.ximat[body].reshape(3, 3)
            inertia += turn @ np.diag(model.body_inertia[body]) @ turn.T
            spread = (place @ place) * np.eye(3) - np.outer(place, place)
            inertia += model.body_mass[body] * spread
        return _Link(mass, com, inertia)


def _compiled(path: Path) -> mujoco.MjModel:
    """The model without meshes, sensors and actuators."""
    require(path.is_file(), "robot.model", "a model file (MJCF or URDF)", f"none at {path}")
    warn, warnings = mujoco.get_mju_user_warning(), []
    mujoco.set_mju_user_warning(warnings.append)  # else into a file in the working directory
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _strip(spec, path.suffix == ".urdf")
        model = spec.compile()
    except (ValueError, OSError) as error:
        text = " ".join([*str(error).split(), *" ".join(warnings).split()])
        raise UserError(f"robot.model: {path.name}: {text}") from None
    finally:
        mujoco.set_mju_user_warning(warn)
    finite = np.isfinite(model.body_mass).all() and np.isfinite(model.body_inertia).all()
    require(bool(finite), "robot.model", "finite masses and inertias", "others")
    return model


def _strip(spec: mujoco.MjSpec, urdf: bool) -> None:
    """Delete what needs further files, or names what is deleted."""
    from_geoms = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    expected = "masses of inertial elements"
    require(not from_geoms, "robot.model", expected, 'inertiafromgeom="true"')
    for geom in list(spec.geoms):
        geom.material, body = "", geom.parent
        shaped = geom.type in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD)
        weighs = body.explicitinertial or body == spec.worldbody
        text = f"{body.name} without"
        require(weighs or not (shaped or urdf), "robot.model", f"{expected} in bodies", text)
        if shaped:
            spec.delete(geom)
    for part in [*spec.sensors, *spec.actuators, *spec.tendons, *spec.keys, *spec.pairs]:
        spec.delete(part)
    for part in [*spec.skins, *spec.meshes, *spec.excludes, *spec.equalities]:
        spec.delete(part)
    for part in [*spec.hfields, *spec.materials, *spec.textures]:
        spec.delete(part)
    spec.compiler.fusestatic = False  # a URDF's root would be part of the world


def _joints(model: mujoco.MjModel, roles: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Left and right joint of each role that the machine has."""
    table, key = roles.get("joints"), "robot.roles.joints"
    if not isinstance(table, Mapping):
        raise UserError(f"{key}: expected {', '.join(LINKS)}, found {table}")
    require(set(table) == set(LINKS), key, ", ".join(LINKS), ", ".join(map(str, table)))
    pairs: dict[str, tuple[int, int]] = {}
    for name, pair in table.items():
        if pair is None and name in ABSENT:
            continue
        if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
            expected = "the names of a left and a right joint" + (", or null" * (name in ABSENT))
            raise UserError(f"{key}.{name}: expected {expected}, found {pair}")
        pairs[name] = _joint(model, pair[0]), _joint(model, pair[1])
    used = [index for pair in pairs.values() for index in pair]
    require(len(set(used)) == len(used), key, "each joint once", "one for two roles")
    return pairs


def _joint(model: mujoco.MjModel, name: Any) -> int:
    return _index(model, mujoco.mjtObj.mjOBJ_JOINT, name, "robot.roles.joints", "joint")


def _body(model: mujoco.MjModel, name: Any) -> int:
    return _index(model, mujoco.mjtObj.mjOBJ_BODY, name, "robot.roles.base", "body")


def _index(model: mujoco.MjModel, kind: mujoco.mjtObj, name: Any, key: str, what: str) -> int:
    index = mujoco.mj_name2id(model, kind, name) if isinstance(name, str) else -1
    count = {"joint": model.njnt, "body": model.nbody}[what]
    names = [mujoco.mj_id2name(model, kind, i) or "" for i in range(count)]
    known = ", ".join(n for n in names if n and n != "world")
    require(index >= 0, key, f"a {what} of the model: {known}", name)
    return index


def _relative(difference: Any, size: float) -> float:
    """Largest element in units of ``size``; infinite where it is no number."""
    value = float(np.abs(difference).max() / size) if size > 0.0 else np.inf
    return value if np.isfinite(value) else np.inf


def _rounded(value: Any) -> Any:
    """Numbers of nine digits and twelve decimals, so that they are the same on every machine."""
    if np.ndim(value):
        return [_rounded(item) for item in value]
    return round(float(f"{value:.9g}"), 12) + 0.0
