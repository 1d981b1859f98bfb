"""The robot as a floating-base pinocchio model: independent dynamics.

Joints and inertias come from the parameter file, and nothing is shared with the models of the
optimisation. The prismatic leg is the leg as built; the knee leg is the virtual knee with the same
mass.
"""

# pinocchio lies below cmeel.prefix, where pyright does not look.
# pyright: reportMissingImports=false

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from slider.config.robot import Link, Mechanism
from slider.robot.knee_map import KneeLengths, Motion, all_joints, prismatic_motion, triangle
from slider.robot.names import (
    GAIT_JOINTS,
    LAST_JOINTS,
    LEG_GAIT_JOINTS,
    NUM_JOINTS,
    SIDES,
    other_side,
)
from slider.verification.stored import StepMotion

WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_BASE, _TURNS = 6, pin.JointModelRevoluteUnaligned
_LEFT, _UP = np.eye(3)[1:]
_LEGS = np.array([0, LEG_GAIT_JOINTS])  # first joint of each
_PITCH, _KNEE, _ANKLE = 2, 3, 4  # of a leg with a virtual knee
_TURN_BACK = ("hip_yaw", "hip_roll", "ankle_roll")
_DRIVEN = list(GAIT_JOINTS)


@dataclass(frozen=True)
class FloatingState:
    """Configuration (17,), velocity and acceleration (16,) of the floating-base model.

    For a robot with soles (19,) and (18,).
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


class PinRobot:
    """A robot whose bodies move as ``gait.dynamics`` says: ``prismatic`` or ``knee``.

    Frames ``left_sole`` and ``right_sole`` are the middles of the foot lines or soles. The model's
    joints are those of the slide or of the virtual knee, in which its bodies move; gaits are
    polynomials in the knee's. Eq. 1 (exact) maps them to the slide's: q̈_p = J q̈_k + J̇ q̇_k, and by
    virtual work τ_k = Jᵀ τ_p.

    Soles are always level about x: the roll of a step is that of the leg about the stance ankle's
    roll axis, and the swing ankle's roll follows from the motion of its leg.
    """

    def __init__(self, robot: Mechanism, dynamics: str) -> None:
        geometry, self._slides = robot.geometry, dynamics == "prismatic"
        self.soles = geometry.sole  # none where feet are lines
        self.lengths = KneeLengths.of(robot)
        leg = _prismatic_leg(robot) if self._slides else _knee_leg(robot)
        turn = np.diag([1.0, -1.0, 1.0])
        self.model = pin.Model()
        root = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
        self.model.appendBodyToJoint(root, _inertia_of(robot.links.base), pin.SE3.Identity())
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
            parent = root
            for name, joint in zip(geometry.leg_joints, leg, strict=False):
                place = pin.SE3(np.eye(3), joint.place * [1.0, sign, 1.0])
                # In the mirror yaw and roll change sign, and y of their axes flips; other angles
                # keep their sign, and x and z of their axes flip. A slide keeps its sign; y flips.
                turns_back = name in _TURN_BACK or joint.kind is not _TURNS
                flips = [1.0, sign, 1.0] if turns_back else [sign, 1.0, sign]
                axis = joint.axis * flips
                parent = self.model.addJoint(parent, joint.kind(axis), place, f"{side}_{name}")
                body = joint.body
                if side != SIDES[0]:
                    body = pin.Inertia(body.mass, turn @ body.lever, turn @ body.inertia @ turn)
                self.model.appendBodyToJoint(parent, body, pin.SE3.Identity())
            sole = pin.SE3(np.eye(3), np.array([0.0, 0.0, -geometry.sole_height]))
            self.model.addFrame(pin.Frame(f"{side}_sole", parent, 0, sole, pin.FrameType.OP_FRAME))
        both = leg * len(SIDES)
        self.model.armature = np.array([0.0] * _BASE + [joint.rotor for joint in both])
        self.damping = np.array([0.0] * _BASE + [joint.damping for joint in both])
        self.ends = np.array([[geometry.toe, 0.0, 0.0], [-geometry.heel, 0.0, 0.0]])
        self.data = self.model.createData()

    def joint_motion(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Motion:
        """Motion (..., 10) of the model's joints for a motion of the knee legs (..., 10)."""
        return prismatic_motion(q, v, a, self.lengths) if self._slides else (q, v, a)

    def work(self, q: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Torques of the knee's joints and efforts of the slide's (10,) from the model's forces.

        q (10,) are positions of the knee legs. Forces and efforts of a robot with soles: (12,).
        """
        if self.soles is not None:
            return forces[_DRIVEN], forces
        jacobian = np.eye(len(q)) if self.lengths is None else slide_jacobian(q, self.lengths)
        if self._slides:
            return jacobian.T @ forces, forces
        return forces, np.linalg.solve(jacobian.T, forces)

    def moving(
        self, motion: StepMotion, time: float, roll: np.ndarray | None = None
    ) -> FloatingState:
        """State at a time of a step; ``roll`` (3,) replaces the foot's stored one."""
        joints = self.joint_motion(*motion.joints_at(time))
        return self.standing(motion.roll_at(time) if roll is None else roll, *joints, motion.side)

    def free_roll(self, motion: StepMotion, time: float, roll: np.ndarray) -> float:
        """Acceleration [rad/s²] of roll and rate (2,) that leaves no moment about the roll's axis.

        The moment is linear in the acceleration.
        """
        moments = []
        for turn in (0.0, 1.0):
            state = self.moving(motion, time, np.array([*roll, turn]))
            efforts, wrench = self.inverse_dynamics(state, motion.side)
            moments.append(self.roll_moment(state, efforts, wrench, motion.side))
        return moments[0] / (moments[0] - moments[1])

    def roll_moment(
        self, state: FloatingState, efforts: np.ndarray, wrench: np.ndarray, side: str
    ) -> float:
        """Moment [N m] about the roll axis, from joint efforts and the ground wrench (6,).

        For a line foot the ground's; for a sole the ankle roll's rotor and damping less its effort.
        """
        if self.soles is None:
            return float(wrench[3])
        dof = _BASE + last_joint(side)
        own = self.model.armature[dof] * state.a[dof] + self.damping[dof] * state.v[dof]
        return float(own - efforts[dof - _BASE])

    def sole(self, side: str) -> int:
        """Frame of a sole."""
        return self.model.getFrameId(f"{side}_sole")

    def foot_ends(self, q: np.ndarray, side: str) -> np.ndarray:
        """Toe and heel (2, 3) of a foot line [m]."""
        pin.framesForwardKinematics(self.model, self.data, q)
        place = self.data.oMf[self.sole(side)]
        return self.ends @ place.rotation.T + place.translation

    def forces(self, state: FloatingState) -> np.ndarray:
        """Generalised forces (16,) of a motion [N, N m]: base (its own frame), then joints."""
        free = pin.rnea(self.model, self.data, state.q, state.v, state.a)
        return free + self.damping * state.v

    def jacobian(self, q: np.ndarray, side: str) -> np.ndarray:
        """Jacobian (6, 16) of the sole: linear, angular, world axes."""
        pin.computeJointJacobians(self.model, self.data, q)
        pin.framesForwardKinematics(self.model, self.data, q)
        return pin.getFrameJacobian(self.model, self.data, self.sole(side), WORLD)

    def standing(
        self, roll: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray, side: str = "left"
    ) -> FloatingState:
        """State whose stance sole is at the origin and only rolls: angle, rate, acceleration.

        A sole with a width does not roll, but its ankle rolls by the opposite angle.
        """
        if self.soles is not None:
            q, v, a = all_joints(np.array([q, v, a]))
            for values, stance in zip((q, v, a), roll, strict=True):
                values[last_joint(side)] = -stance
            roll = np.zeros(3)
        place = pin.SE3(pin.exp3(np.array([roll[0], 0.0, 0.0])), np.zeros(3))
        floating = np.concatenate([pin.neutral(self.model)[:7], q])
        pin.framesForwardKinematics(self.model, self.data, floating)
        base = place * self.data.oMf[self.sole(side)].inverse()
        floating[:7] = pin.SE3ToXYZQUAT(base)
        jacobian = self.jacobian(floating, side)
        rate = np.array([0, 0, 0, roll[1], 0, 0]) - jacobian[:, 6:] @ v
        velocity = np.concatenate([np.linalg.solve(jacobian[:, :6], rate), v])
        pin.forwardKinematics(self.model, self.data, floating, velocity, np.zeros(len(velocity)))
        frame = self.sole(side)
        bias = pin.getFrameClassicalAcceleration(self.model, self.data, frame, WORLD).vector
        turn = np.array([0, 0, 0, roll[2], 0, 0]) - jacobian[:, 6:] @ a - bias
        acceleration = np.concatenate([np.linalg.solve(jacobian[:, :6], turn), a])
        state = FloatingState(floating, velocity, acceleration)
        if self.soles is not None:
            self._level(state, other_side(side))
        return state

    def _level(self, state: FloatingState, side: str) -> None:
        """Set angle, rate and acceleration of the ankle's roll that keep a sole level."""
        joint, frame = last_joint(side), self.sole(side)
        pin.forwardKinematics(self.model, self.data, state.q)
        x, y, z = self.data.oMi[self.model.getJointId(f"{side}_ankle")].rotation.T
        flat = np.cross(_UP, x)
        state.q[7 + joint] = np.arctan2(flat @ z, flat @ y)
        row, _ = self.levelling(state.q, side)
        state.v[_BASE + joint] -= row @ state.v / row[_BASE + joint]
        pin.forwardKinematics(self.model, self.data, state.q, state.v, state.a)
        axis = pin.updateFramePlacement(self.model, self.data, frame).rotation[:, 1]
        rate = pin.getFrameVelocity(self.model, self.data, frame, WORLD).angular
        turn = pin.getFrameClassicalAcceleration(self.model, self.data, frame, WORLD).angular
        tilting = np.cross(turn, axis) + np.cross(rate, np.cross(rate, axis))
        state.a[_BASE + joint] -= tilting[2] / row[_BASE + joint]

    def levelling(self, q: np.ndarray, side: str) -> np.ndarray:
        """The function ``levelling`` for a side (2, 18)."""
        jacobian = self.jacobian(q, side)
        return levelling(self.data.oMf[self.sole(side)].rotation, jacobian, side)

    def inverse_dynamics(
        self, state: FloatingState, side: str = "left"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Forces (10,) or (12,) at its joints, ground force and moment (6,) at the stance sole."""
        return self._supported(self.forces(state), state.q, side)

    def _supported(
        self, total: np.ndarray, q: np.ndarray, side: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Split generalised forces, or impulses, into those at the joints and at the sole."""
        jacobian = self.jacobian(q, side)
        wrench = np.linalg.solve(jacobian[:, :_BASE].T, total[:_BASE])
        return total[_BASE:] - jacobian[:, _BASE:].T @ wrench, wrench

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Joint-space inertia (16, 16), rotors included."""
        upper = np.triu(pin.crba(self.model, self.data, q))
        return upper + np.triu(upper, 1).T

    def impact(self, q: np.ndarray, v: np.ndarray, side: str) -> np.ndarray:
        """Velocity (16,) or (18,) after the impact of a side's foot: see ``after_impact``."""
        lifted = None if self.soles is None else self.levelling(q, other_side(side))
        return after_impact(self.mass(q), self.jacobian(q, side), v, lifted)

    def impulse(
        self, q: np.ndarray, before: np.ndarray, after: np.ndarray, side: str
    ) -> np.ndarray:
        """Impulses (11,) [N m s] at the joints and about the foot line that a jump needs.

        They vanish in a plastic impact: neither motors nor a line contact can exert them. With
        soles they are those at the joints (11,), without the roll that keeps the lifted one level.
        """
        joints, wrench = self._supported(self.mass(q) @ (after - before), q, side)
        if self.soles is not None:
            return np.delete(joints, last_joint(other_side(side)))
        return np.append(joints, wrench[3])


def last_joint(side: str) -> int:
    """Index of an ankle's roll among the joints (12)."""
    return LAST_JOINTS[SIDES.index(side)]


def full(joints: np.ndarray) -> np.ndarray:
    """Values of all joints (..., 12) of a state's (..., 10) or, with soles, (..., 12)."""
    return joints if joints.shape[-1] == NUM_JOINTS else all_joints(joints)


def levelling(rotation: np.ndarray, jacobian: np.ndarray, side: str) -> np.ndarray:
    """Jacobian rows (2, n) of the slope of a sole's y axis, and of its ankle's roll.

    From the sole's rotation (3, 3) and Jacobian (6, n).
    """
    roll = np.eye(jacobian.shape[1])[_BASE + last_joint(side)]
    return np.stack([np.cross(rotation[:, 1], _UP) @ jacobian[3:], roll])


def after_impact(
    mass: np.ndarray, sole: np.ndarray, v: np.ndarray, lifted: np.ndarray | None
) -> np.ndarray:
    """Velocity (n,) after a plastic impact of a foot with Jacobian ``sole`` (6, n).

    A line foot keeps only its rate about x. A sole stops, and an impulse at the other ankle's roll
    keeps the lifted sole level: ``lifted`` is its ``levelling``.
    """
    held = along = sole[[0, 1, 2, 4, 5]]
    if lifted is not None:
        held, along = (np.vstack([sole, row]) for row in lifted)
    zero = np.zeros(len(held))
    system = np.block([[mass, -along.T], [held, np.diag(zero)]])
    return np.linalg.solve(system, np.concatenate([mass @ v, zero]))[: len(v)]


def slide_jacobian(q: np.ndarray, lengths: KneeLengths) -> np.ndarray:
    """Derivatives (10, 10) of the prismatic legs' joints by the knee legs' at q (10,): eq. 1."""
    matrix = np.eye(len(q))
    hip, ankle, slide = triangle(q[_LEGS + _KNEE], lengths.thigh, lengths.shank).rates
    for place, slope in ((_PITCH, -hip), (_KNEE, slide), (_ANKLE, -ankle)):
        matrix[_LEGS + place, _LEGS + _KNEE] = slope
    return matrix


class _LegJoint(NamedTuple):
    """A left joint, its axis and position in the frame above (3,) [m], and the body below it.

    ``rotor`` and ``damping`` [kg m², kg], [N m s/rad] act about or along the joint.
    """

    kind: type[pin.JointModel]
    axis: np.ndarray
    place: np.ndarray
    body: pin.Inertia
    rotor: float = 0.0
    damping: float = 0.0


def _inertia_of(link: Link, share: float = 1.0) -> pin.Inertia:
    """A link in the frame of its joint, or a part of it cut across the leg's axis.

    A part of a rod keeps the share s of mass, s³ of the inertia across and s of that along.
    """
    scale = np.array([share**3, share**3, share])
    inertia = np.diag(scale * link.inertia)
    for (i, j), product in zip(((0, 1), (0, 2), (1, 2)), link.products, strict=True):
        inertia[i, j] = inertia[j, i] = product  # no part of a tube has any
    return pin.Inertia(share * link.mass, np.array(link.com), inertia)


def _raised(body: pin.Inertia, height: float) -> pin.Inertia:
    """A body, seen from a frame ``height`` [m] below its own."""
    return pin.SE3(np.eye(3), height * _UP).act(body)


def _prismatic_leg(robot: Mechanism) -> list[_LegJoint]:
    """Hip, slide and ankle; the upper foot is fixed to the tube, rotors turn with their joints.

    Rotors of inertia I in both capstan motors, at angles s/r ± β/n, are equivalent to 2I/r² at the
    slide and 2I/n² at the ankle. Without a capstan a rotor turns with its joint alone.
    """
    links, geometry, capstan = robot.links, robot.geometry, robot.capstan
    rotors = {name: drive.inertia for name, drive in robot.drives.items()}
    if capstan is not None:
        pair = 2.0 * robot.drives["capstan"].inertia
        rotors |= {"slide": pair / capstan.drum_radius**2, "ankle": pair / capstan.foot_ratio**2}
    tube = _inertia_of(links.tube)
    if links.upper_foot is not None:
        tube = tube + _raised(_inertia_of(links.upper_foot), geometry.upper_foot_height)
    kind, axis = pin.JointModelPrismaticUnaligned, -_UP
    knee, ankle = np.zeros(3), -geometry.leg_length * _UP
    if geometry.knee is not None:
        kind, axis = _TURNS, np.array(geometry.knee_direction)
        knee = np.array(geometry.knee)
    order, below = geometry.axes.order, np.zeros(3)  # from the pitch axis to the last of the hip
    for name in order[order.index("hip_pitch") + 1 :]:
        below = below + getattr(geometry.axes, name)
    hip = _hip(robot)
    chain = {
        **{name: hip[name] for name in order},
        "slide": _LegJoint(kind, axis, knee - below, tube),
        "ankle": _LegJoint(
            _TURNS,
            np.array(geometry.ankle_direction),
            ankle - knee,
            _inertia_of(links.talus or links.foot),
        ),
    }
    if geometry.sole is not None:
        place = (geometry.sole.roll_height - geometry.ankle_height) * _UP
        chain["ankle_roll"] = _LegJoint(_TURNS, np.eye(3)[0], place, _inertia_of(links.foot))
    return [
        joint._replace(rotor=rotors[name] + own.armature, damping=own.damping)
        for name, joint in chain.items()
        for own in (robot.joints[name],)
    ]


def _hip(robot: Mechanism) -> dict[str, _LegJoint]:
    axes, joints = robot.geometry.axes, {}
    for name in ("yaw", "roll", "pitch"):
        axis, place = (np.array(getattr(axes, x)) for x in (f"{name}_direction", f"hip_{name}"))
        body = _inertia_of(getattr(robot.links, name))
        joints[f"hip_{name}"] = _LegJoint(_TURNS, axis, place, body)
    return joints


def _knee_leg(robot: Mechanism) -> list[_LegJoint]:
    """Hip, virtual knee and ankle, without rotors and friction."""
    links, knee, hip = robot.links, robot.sliding_leg, _hip(robot)
    shank_part = _inertia_of(links.tube, knee.shank_mass_fraction)
    shank_part.lever = -knee.shank_length / 2 * _UP
    hip["hip_pitch"] = hip["hip_pitch"]._replace(body=_thigh(robot))
    return [
        *(hip[name] for name in robot.geometry.axes.order),
        _LegJoint(_TURNS, -_LEFT, -knee.thigh_length * _UP, shank_part),
        _LegJoint(_TURNS, _LEFT, -knee.shank_length * _UP, _inertia_of(links.foot)),
    ]


def _thigh(robot: Mechanism) -> pin.Inertia:
    """Pitch link, upper foot and the rest of the tube.

    The rest is placed to balance the leg: at the nominal length, knee bent, the first moment
    of all links along the line from hip to ankle is that of the prismatic leg.
    """
    links, geometry, knee = robot.links, robot.geometry, robot.sliding_leg
    l1, l2, length = knee.thigh_length, knee.shank_length, geometry.leg_length
    along = (l1**2 + length**2 - l2**2) / (2 * l1 * length)  # cosine between thigh and leg
    fixed = _inertia_of(links.pitch)
    assert links.upper_foot is not None  # with a virtual knee
    fixed += _raised(_inertia_of(links.upper_foot), geometry.upper_foot_height)
    share = knee.shank_mass_fraction
    shank = -share * links.tube.mass * (l1 * along + length) / 2
    rest = _inertia_of(links.tube, 1.0 - share)
    above = fixed.mass * fixed.lever[2]
    balance = above + links.tube.mass * links.tube.com[2]
    rest.lever = (balance - above * along - shank) / (rest.mass * along) * _UP
    return fixed + rest
