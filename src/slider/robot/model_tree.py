"""A robot's model file (MJCF or URDF), compiled by MuJoCo, in the nominal pose of its roles.

Joints without a role are held fixed, and their bodies are welded to the parent link.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Collection, Mapping
from dataclasses import field
from typing import Annotated, Any, Literal, NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from slider.config import types as t
from slider.config.robot import (
    HIP_JOINTS,
    LATERAL,
    LINKS,
    MAX_TURN,
    MIRROR,
    SOLE_LINKS,
    Body,
    axis_of,
)
from slider.core.errors import UserError, require
from slider.robot.model_foot import Foot
from slider.robot.model_motors import motor_of
from slider.robot.model_pose import LEVEL, LegPose

_KNEE = "knee"
LEAST_MASS = 1e-6  # bodies below this count as massless [kg]
LOCKED = {"lower": -0.005, "upper": 0.005, "damping": 0.2}
OPTIONAL_JOINTS = {
    "hip_yaw": LOCKED | {"armature": 0.0},
    "upper_foot": LOCKED | {"armature": 0.001},
}
"""Joints that a robot may lack, and the nearly locked joints of light links that replace them."""
AXES = dict.fromkeys(SOLE_LINKS, (0.0, 1.0, 0.0)) | {
    "hip_yaw": (0.0, 0.0, 1.0),
    "hip_roll": (1.0, 0.0, 0.0),
    "ankle_roll": (1.0, 0.0, 0.0),
    "slide": (0.0, 0.0, -1.0),
}
_MOVES = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
_SHOWN = 5e-5  # least offset of a joint that is printed [rad, m]
_MAX_TILT = 1e-3  # largest tilt of an axis that counts as parallel to a coordinate axis [rad]
_MAX_SKEW = np.deg2rad(0.5)  # largest tilt of the axes of slide, upper foot, ankle roll [rad]
_MAX_LATERAL = 5e-3  # largest distance of the base's centre from its plane of symmetry [m]
_MAX_PRODUCTS = 0.05  # largest Ixy and Iyz of the base, relative to its largest moment
_TURNS = {"x": 0.0, "y": -np.pi / 2, "-x": np.pi, "-y": np.pi / 2}  # [rad] about z


class Roles(t.Group):
    """Roles of the parts of a model file.

    Attributes:
        base: name of the base body.
        joints: left and right joint of each role, null for a role that the robot lacks;
            ``ankle_roll`` instead of ``upper_foot`` if the foot has a sole.
        pose: joint positions that are taken as zero, or at which joints are held. Missing or
            inconsistent values are solved: soles level by their geometry, ankles below the hips.
        bend: knee flexion in the pose [rad]; null: the typed one, that of the model, or 0.5 if
            the leg is straight there.
        side: leg to use if the two differ.
        forward: walking direction in the model's base frame.
        foot_y: y of the left foot's line in the base frame; by default that of the middle of the
            foot's geometry, else of the ankle's anchor; with a sole that of the roll axis.
        tolerance: accepted relative difference of left and right; positions relative to leg length.
    """

    base: t.Name
    joints: dict[str, tuple[t.Name, t.Name] | None]
    pose: dict[str, t.Number] = field(default_factory=dict)
    bend: Annotated[t.Number, Field(gt=0.0, lt=np.pi)] | None = None
    side: Literal["left", "right"] | None = None
    forward: Literal["x", "-x", "y", "-y"] = "x"
    foot_y: t.Metres | None = None
    tolerance: t.Share = 0.01


class Part(NamedTuple):
    """A driven joint in the base frame: position (3,) [m], axis (3,), moved body, properties.

    ``formula`` has its value in terms of the model's joint.
    """

    place: np.ndarray
    axis: np.ndarray
    body: Body
    joint: dict[str, float]
    formula: str


class ModelTree:
    """A compiled model in its nominal pose, with the base at the origin."""

    def __init__(self, model: mujoco.MjModel, roles: Roles, typed: Collection[str] = ()) -> None:
        self.has_knee, self._joints = _KNEE in roles.joints, _joints(model, roles)
        self.has_sole = "ankle_roll" in self._joints
        self._typed, self._tolerance, self.remarks = typed, roles.tolerance, list[str]()
        self._model, self._data = model, mujoco.MjData(model)
        self._roles = {index for pair in self._joints.values() for index in pair}
        self._base = _index(model, "body", roles.base, "robot.roles.base")
        require(self._base > 0, "robot.roles.base", "the body of the base", "world")
        self.order, other = (self._hip_order(side) for side in range(2))
        text = f"one order of both hips ({', '.join(self.order)})"
        require(self.order == other, "robot.roles.joints", text, ", ".join(other))
        self._zero, self.solved = np.zeros(model.njnt), dict[str, float]()
        for name, value in roles.pose.items():
            self._zero[_index(model, "joint", name, "robot.roles.pose")] = value
        moves = np.isin(model.jnt_type, _MOVES)
        self._data.qpos[model.jnt_qposadr[moves]] = self._zero[moves]
        along, across = np.cos(_TURNS[roles.forward]), np.sin(_TURNS[roles.forward])
        forward = np.array([[along, -across, 0.0], [across, along, 0.0], [0.0, 0.0, 1.0]])
        legs = []
        for side in range(2):
            joints = {name: pair[side] for name, pair in self._joints.items()}
            line = None if roles.foot_y is None or self.has_sole else roles.foot_y * (1 - 2 * side)
            leg = LegPose(model, self._data, self._base, joints, self.has_knee, forward, line)
            names = {name: model.joint(index).name for name, index in joints.items()}
            typed = [name for name in joints if names[name] in roles.pose]
            for name, angle in leg.solve(typed, roles.bend).items():
                given = self._zero[joints[name]]
                if name in typed and abs(angle - given) > LEVEL:
                    text = f"roles.pose: {names[name]} is {angle:.4f} rad in place of {given:g}"
                    self.remarks.append(f"{text}, for a level sole and the ankle below the hip")
                self._zero[joints[name]] = self.solved[names[name]] = angle
            legs.append(leg)
        if tilt := legs[0].levelled:
            text = f"the model's sole is tilted by {np.rad2deg(tilt):.1f}° in its zero pose"
            self.remarks.append(f"{text}; the pose levels it")
        mujoco.mj_kinematics(model, self._data)
        self.foot_rotation = legs[0].foot_rotation()
        mujoco.mj_comPos(model, self._data)
        self._turn = forward @ self._data.xmat[self._base].reshape(3, 3).T
        self._origin = self._data.xpos[self._base].copy()
        self._raise_origin()
        self._owners = self._find_owners()
        rubs = [k for k in self._roles if model.dof_frictionloss[model.jnt_dofadr[k]] > 0.0]
        if rubs:
            names = ", ".join(model.joint(k).name for k in sorted(rubs))
            self.remarks.append(f"ignored frictionloss of {names}")
        if ignored := self._check_constraints():
            self.remarks.append(f"ignored, as no leg has them: {', '.join(ignored)}")

    def _raise_origin(self) -> None:
        """Move the base origin up to the pitch axes if the model has it below mid-leg."""
        pairs = (self._joints[name] for name in ("hip_pitch", "ankle"))
        up = self._turn[2]
        hip, ankle = ((self._data.xanchor[list(k)] - self._origin).mean(0) @ up for k in pairs)
        if hip + ankle > 0.0:
            self._origin += hip * up
            text = f"the base's origin is {hip:.3f} m above that of the model, between the hips"
            self.remarks.append(text)

    def _find_owners(self) -> np.ndarray:
        """For each body, the joint with a role that moves it (nbody,); −1: base, −2: others."""
        model, owners = self._model, np.full(self._model.nbody, -2)
        for body in np.flatnonzero(model.body_rootid == model.body_rootid[self._base]):
            own = [index for index in self._joints_of(int(body)) if index in self._roles]
            parent = owners[model.body_parentid[body]]  # parents come first
            owners[body] = own[-1] if own else max(parent, -1)
        return owners

    def _check_constraints(self) -> list[str]:
        """Reject springs and constraints of the legs; return those of other parts (ignored)."""
        model, found = self._model, {True: list[str](), False: list[str]()}
        parts: list[tuple[str, str, list[int]]] = []
        bound = model.tendon_limited | (model.tendon_damping != 0) | (model.tendon_frictionloss > 0)
        for text, kind, acts in (
            ("spring", "joint", model.jnt_stiffness),
            ("spring", "tendon", model.tendon_stiffness),
            ("coupling", "tendon", bound),
        ):
            parts += [(text, kind, [int(index)]) for index in np.flatnonzero(acts)]
        for index in np.flatnonzero(model.eq_active0):
            name = mujoco.mjtEq(model.eq_type[index]).name.removeprefix("mjEQ_").lower()
            by_site = model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE
            kind = name if name in ("joint", "tendon") else "site" if by_site else "body"
            both = model.eq_obj1id[index], model.eq_obj2id[index]
            parts.append((f"{name} constraint", kind, [int(k) for k in both if k >= 0]))
        for text, kind, numbers in parts:
            owners = {self._owners[body] for k in numbers for body in self._bodies(kind, k)}
            names = " and ".join(getattr(model, kind)(k).name or f"{kind} {k}" for k in numbers)
            found[len(owners) > 1 and max(owners) >= 0].append(f"{text} of {names}")
        expected = "legs without springs, coupled joints and closed loops"
        require(not found[True], "robot.model", expected, ", ".join(found[True]))
        return found[False]

    def _bodies(self, kind: str, index: int) -> list[int]:
        """Bodies that a body, site, joint or tendon connects."""
        model = self._model
        if kind == "joint":
            return [model.jnt_bodyid[index], model.body_parentid[model.jnt_bodyid[index]]]
        if kind == "tendon":
            kinds = mujoco.mjtWrap
            of = {int(kinds.mjWRAP_JOINT): "joint", int(kinds.mjWRAP_SITE): "site"}
            start = model.tendon_adr[index]
            parts = slice(start, start + model.tendon_num[index])
            wraps = zip(model.wrap_type[parts], model.wrap_objid[parts], strict=True)
            return [body for wrap, k in wraps if wrap in of for body in self._bodies(of[wrap], k)]
        return [model.site_bodyid[index] if kind == "site" else index]

    def _joints_of(self, body: int) -> range:
        start = self._model.body_jntadr[body]
        return range(start, start + self._model.body_jntnum[body])

    def _hip_order(self, side: int) -> tuple[str, ...]:
        """Joints of a hip from the base down, after a check of the leg's joint order."""
        model, hip = self._model, ()
        moved = _KNEE if self.has_knee else "slide"
        for name in ("ankle", "upper_foot", "ankle_roll"):
            if name not in self._joints:
                continue
            chain, body = [], model.jnt_bodyid[self._joints[name][side]]
            while body > 0 and body != self._base:
                chain += reversed(self._joints_of(body))
                body = model.body_parentid[body]
            key = f"robot.roles.joints.{name}"
            require(body == self._base, key, "a joint below the base", model.joint(chain[0]).name)
            named = {pair[side]: role for role, pair in self._joints.items()}
            named[self._joints["slide"][side]] = moved
            order = [named[index] for index in reversed(chain) if index in named]
            hip = tuple(role for role in order if role in HIP_JOINTS)
            expected = [*hip, moved, *["ankle"] * (name == "ankle_roll"), name]
            end = model.joint(self._joints[name][side]).name
            for role in (role for role in (*HIP_JOINTS, "slide") if role in self._joints):
                own, other = self._joints[role][side], self._joints[role][1 - side]
                found = f"{model.joint(own).name} of another limb"
                found = f"left and right of {role} swapped" if other in chain else found
                require(own in chain, "robot.roles.joints", f"joints from the base to {end}", found)
            text = f"{', '.join(expected)} from the base to {end}"
            require(order == expected, "robot.roles.joints", text, ", ".join(order))
        return hip

    @property
    def reach(self) -> float:
        """Distance from left pitch axis to ankle in the sagittal plane [m]."""
        hip, ankle = (self._data.xanchor[self._joints[k][0]] for k in ("hip_pitch", "ankle"))
        return float(np.linalg.norm((self._turn @ (ankle - hip))[[0, 2]]))

    def names(self, role: str) -> list[str]:
        """Left and right joint of a role."""
        return [self._model.joint(index).name for index in self._joints.get(role, ())]

    def leg(self, side: int) -> dict[str, Part]:
        """Parts of a side's leg by role; those of the right leg are mirrored to the left."""
        parts = {}
        for name, pair in self._joints.items():
            place = self._turn @ (self._data.xanchor[pair[side]] - self._origin)
            body = self._joined(np.flatnonzero(self._owners == pair[side]))
            axis, sign = self._direction(name, side)
            joint = self._joint(name, side, sign)
            if side == 1:
                place, body = place * MIRROR, body.reflected
                axis = axis_of(name, axis, -1.0) if self._turns(name) else axis
            parts[name] = Part(place, axis, body, joint, self._formula(pair[side], sign))
        return parts

    def _formula(self, index: int, sign: float) -> str:
        """A joint of ours in terms of the model's joint, such as ``0.5000 − knee``."""
        zero, name = self._zero[index], self._model.joint(index).name
        if abs(zero) < _SHOWN:
            return name if sign > 0 else f"−{name}"
        if sign > 0:
            return f"{name} {'−' if zero > 0 else '+'} {abs(zero):.4f}"
        return f"{'−' if zero < 0 else ''}{abs(zero):.4f} − {name}"

    def foot(self, side: int) -> Foot:
        """Geometry of a side's foot in the base frame."""
        last = self._joints["ankle_roll" if self.has_sole else "ankle"][side]
        bodies = np.flatnonzero(self._owners == last)
        return Foot(self._data, bodies, self._origin, self._turn)

    def motors(self, side: int, speeds: Mapping[str, float]) -> dict[str, Any]:
        """Motors of a side by role, from :func:`motor_of`; slide and ankle are included only if
        each has its own motor.
        """
        own = self.has_knee or "capstan" in self._typed  # typed as null
        others = ("upper_foot",) if own else ("upper_foot", "slide", "ankle")
        names = [name for name in self._joints if name not in others]
        return {name: motor_of(self._model, self._joints[name][side], speeds) for name in names}

    def base(self) -> tuple[Body, float]:
        """The base with everything welded to it, made symmetric about y = 0; its original y."""
        base = self._joined(np.flatnonzero(self._owners == -1))
        if base.mass < LEAST_MASS:
            return base, 0.0
        most = max(_MAX_LATERAL, self._tolerance * self.reach)
        expected = f"a base whose centre has y = 0 within {most:.3g} m (roles.tolerance)"
        lateral = base.com[1]
        require(abs(lateral) <= most, "robot.model", expected, f"{lateral:.4f} m")
        products = np.array([base.inertia[0, 1], base.inertia[1, 2]])
        skewed = relative(products, np.abs(base.inertia).max())
        most = max(_MAX_PRODUCTS, self._tolerance)
        expected = f"a base with Ixy = Iyz = 0 within {most:.0%} of its moments (roles.tolerance)"
        found = f"{products[0]:.4g} and {products[1]:.4g} kg m², {skewed:.1%}"
        require(skewed <= most, "robot.model", expected, found)
        if skewed > 1e-3:
            text = f"the base's Ixy and Iyz, {skewed:.1%} of its largest moment, count as 0"
            self.remarks.append(text)
        symmetric = (base.inertia + base.reflected.inertia) / 2
        return Body(base.mass, base.com * [1.0, 0.0, 1.0], symmetric), float(lateral)

    def held(self) -> dict[str, float]:
        """Joints without a role, with the mass [kg] that each carries, including joints beyond it
        as seen from the base.
        """
        model, parents, owners, result = self._model, self._model.body_parentid, self._owners, {}
        holders: dict[int, str | None] = {self._base: None}
        bodies = [self._base]
        for near in bodies:  # outwards from the base, up and down the tree
            beyond = {*np.flatnonzero(parents == near), parents[near]} - holders.keys() - {0}
            for body in sorted(map(int, beyond)):
                joints = set(self._joints_of(near if body == parents[near] else body))
                held = [k for k in joints - self._roles if model.jnt_type[k] != _FREE]
                holder = holders[near] if owners[body] == owners[near] else None
                if held and holder is None:
                    holder = model.joint(min(held)).name or f"a joint of {model.body(body).name}"
                if holder is not None:
                    result[holder] = result.get(holder, 0.0) + float(model.body_mass[body])
                holders[body] = holder
                bodies.append(body)
        return result

    def _joint(self, name: str, side: int, sign: float) -> dict[str, float]:
        """Range and passive properties as of a left leg's joint; ``sign`` is its axis' sense."""
        model, index = self._model, self._joints[name][side]
        key, slides, text = self._key(name), not self._turns(name), model.joint(index).name
        if side == 1 and name in LATERAL:
            sign = -sign
        dof = model.jnt_dofadr[index]
        values = {"damping": model.dof_damping[dof], "armature": model.dof_armature[dof]}
        values = {name: rounded(value) for name, value in values.items()}
        if not model.jnt_limited[index]:
            ends = [f"joints.{name}.{end}" for end in ("lower", "upper")]
            expected = f"a joint with a range, or {' and '.join(ends)} in the robot's file"
            require(set(ends) <= set(self._typed), key, expected, f"{text} without")
            return values
        ends = sign * (model.jnt_range[index] - self._zero[index])
        most = np.inf if slides else 2 * np.pi
        expected = "a range that holds roles.pose" + ("" if slides else ", in rad")
        low, high = model.jnt_range[index]
        found = f"{text} from {low:.4g} to {high:.4g} and its pose {self._zero[index]:.4g}"
        possible = ends.min() <= 0.0 <= ends.max() and np.abs(ends).max() <= most
        require(bool(possible), key, expected, found)
        return {"lower": rounded(ends.min()), "upper": rounded(ends.max())} | values

    def _turns(self, name: str) -> bool:
        return name != "slide" or self.has_knee

    def _key(self, name: str) -> str:
        return f"robot.roles.joints.{_KNEE if name == 'slide' and self.has_knee else name}"

    def _direction(self, name: str, side: int) -> tuple[np.ndarray, float]:
        """Unit vector (3,) of an axis in the sense of its role; −1 if the file's is opposite."""
        index, key, slides = self._joints[name][side], self._key(name), not self._turns(name)
        expected = f"a joint that slides (else {_KNEE} in its place)" if slides else "a hinge"
        possible = self._model.jnt_type[index] == _MOVES[slides]
        require(possible, key, expected, self._model.joint(index).name)
        axis = self._turn @ self._data.xaxis[index]
        along = np.array(AXES["ankle" if name == "slide" and self.has_knee else name])
        sign = float(np.sign(axis @ along))
        tilts = self._turns(name) and name not in ("upper_foot", "ankle_roll")
        turn = np.arccos(np.clip(sign * axis @ along, -1.0, 1.0))
        most = np.deg2rad(MAX_TURN) if tilts else _MAX_SKEW
        letter = "xyz"[int(np.abs(along).argmax())]
        expected = f"an axis {f'within {MAX_TURN}° of' if tilts else 'along'} {letter}"
        joint = self._model.joint(index).name
        found = f"{joint} along {np.round(axis, 3).tolist()}"
        if name == "hip_roll":
            found += " (roles.forward says where the base looks)"
        if name == "ankle_roll":
            found += f", {np.rad2deg(turn):.1f}° off: upper_foot: null in its place holds it"
        require(bool(turn <= most), key, expected, found)
        if not tilts and turn > _MAX_TILT:
            self.remarks.append(f"{joint} counts as along {letter}, {np.rad2deg(turn):.2f}° off")
        return (along if turn <= (_MAX_TILT if tilts else _MAX_SKEW) else sign * axis), sign

    def _joined(self, bodies: np.ndarray) -> Body:
        """Several bodies as one, in the base frame."""
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
        return Body(mass, com, inertia)


def _joints(model: mujoco.MjModel, roles: Roles) -> dict[str, tuple[int, int]]:
    """Left and right joint of each role that the robot has."""
    table, key = dict(roles.joints), "robot.roles.joints"
    if _KNEE in table:
        require("slide" not in table, key, f"slide or {_KNEE}", "both")
        expected = f"null with a {_KNEE}"
        require(table.get("upper_foot") is None, f"{key}.upper_foot", expected, "joints")
        table["slide"] = table.pop(_KNEE)
    expected = f"{', '.join(LINKS)}, or {_KNEE} in place of slide, ankle_roll of upper_foot"
    wanted = set(SOLE_LINKS) - {"upper_foot" if "ankle_roll" in table else "ankle_roll"}
    require(set(table) == wanted, key, expected, ", ".join(roles.joints))
    lacks = [name for name, pair in roles.joints.items() if pair is None]
    lacks = [name for name in lacks if name not in OPTIONAL_JOINTS]
    expected = f"null for no other than {' and '.join(OPTIONAL_JOINTS)}"
    require(not lacks, key, expected, ", ".join(lacks))
    pairs = {
        name: (_index(model, "joint", pair[0], key), _index(model, "joint", pair[1], key))
        for name, pair in table.items()
        if pair is not None
    }
    used = [index for pair in pairs.values() for index in pair]
    require(len(set(used)) == len(used), key, "each joint once", "one for two roles")
    return pairs


def _index(model: mujoco.MjModel, kind: str, name: str, key: str) -> int:
    """Index of the joint or body with a name."""
    try:
        return getattr(model, kind)(name).id
    except KeyError as error:  # MuJoCo lists the names
        raise UserError(f"{key}: expected a {kind} of the model. {error.args[0]}") from None


def relative(difference: Any, size: float) -> float:
    """Largest absolute element divided by ``size``; infinite for NaN."""
    value = float(np.abs(difference).max() / size) if size > 0.0 else np.inf
    return value if np.isfinite(value) else np.inf


def rounded(value: Any) -> Any:
    """Round to nine digits and twelve decimals, so that values are equal on every machine."""
    if np.ndim(value):
        return [rounded(item) for item in value]
    return round(float(f"{value:.9g}"), 12) + 0.0
