"""The part of the gait problem that all velocities share, with expressions for its rows and costs.

A walk has two steps. The second is written in reflected coordinates, so that the stance foot is
always the left one and the same functions serve both. The course (direction of travel) of a turning
walk has the commanded yaw rate ω: in a step of duration T it turns from −ω T/2 to ω T/2 relative to
the stance foot's line, and the next foot lands yawed by ω T. In the reflected step ω is negated.
"""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.config.robot import Mechanism, leg_scale
from slider.gait.dynamics import OwnTree, PrismaticTree, StanceTree
from slider.gait.tree import NUM_JOINTS, STANCE, SWING, rotation
from slider.robot.bodies import knee_bodies, own_bodies, total_mass
from slider.robot.names import GAIT_JOINTS, GRAVITY, LAST_JOINTS
from slider.robot.transmission import Transmission

_ORDER = [*GAIT_JOINTS, *LAST_JOINTS]


@dataclass(frozen=True)
class Formulation:
    """A robot with its dynamics, limits and settings.

    Attributes:
        robot, config: bodies and limits; settings.
        turning: whether the velocities have a yaw rate; else it is zero in all expressions.
    """

    robot: Mechanism
    config: FormulationConfig
    turning: bool = False

    @cached_property
    def tree(self) -> StanceTree:
        """Kinematics and dynamics in left stance, of the leg as built or of the virtual knee."""
        if self.robot.virtual_knee is None:
            return OwnTree(self.robot)
        return (StanceTree if self.config.dynamics == "knee" else PrismaticTree)(self.robot)

    @property
    def parameters(self) -> list[Any]:
        """All that its functions depend on."""
        return [asdict(self.robot), asdict(self.config), self.turning]

    @cached_property
    def weight(self) -> float:
        """m g [N]."""
        bodies = own_bodies if self.robot.virtual_knee is None else knee_bodies
        return total_mass(bodies(self.robot)) * GRAVITY

    @property
    def leg_scale(self) -> float:
        """Leg length as a multiple of SLIDER's."""
        return leg_scale(self.robot.geometry.leg_length)

    @property
    def foot_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Toe and heel in the foot frame (3,) [m]."""
        geometry, sole = self.robot.geometry, self.tree.sole
        return sole + [geometry.toe, 0.0, 0.0], sole - [geometry.heel, 0.0, 0.0]


@dataclass(frozen=True)
class NodeSymbols:
    """Variables of one node: roll of the stance foot, joints over normalised time, step time."""

    roll: ca.SX
    roll_rate: ca.SX
    roll_acceleration: ca.SX
    q: ca.SX
    q_phase: ca.SX
    q_phase2: ca.SX
    step_time: ca.SX

    SIZE = 3 + 3 * NUM_JOINTS + 1

    @classmethod
    def of(cls, x: ca.SX) -> "NodeSymbols":
        """Split a node vector (34,)."""
        q, q_phase, q_phase2 = ca.vertsplit(x[3:-1], NUM_JOINTS)
        return cls(x[0], x[1], x[2], q, q_phase, q_phase2, x[-1])

    @property
    def v(self) -> ca.SX:
        """Joint velocities (10,) [rad/s]."""
        return self.q_phase / self.step_time

    @property
    def a(self) -> ca.SX:
        """Joint accelerations (10,) [rad/s²]."""
        return self.q_phase2 / self.step_time**2


class StepEnd(NamedTuple):
    """State at the start or the end of a step."""

    roll: ca.SX
    roll_rate: ca.SX
    q: ca.SX
    v: ca.SX


class Node:
    """Expressions at a node of a step, as functions of its vector (34,).

    Attributes:
        form: the formulation of the gait.
        symbols: variables of the node.
        dynamics: joint torques and efforts.
        force, moment: ground reaction at the middle of the foot line [N], [N m], world axes.
        poses: of all bodies; ``base`` is the torso's.
        motor_torques, motor_speeds: both legs', stance first, from the hip down (m,)
            [N m], [rad/s]. The slide's force is a torque over |dl/dθ|, which vanishes for a
            straight leg: the knee's lower bound avoids it.
        torque_shares: motor torques / limits (m,) [-].
        voltage_shares: torque / stall torque + speed / no-load speed (m,): shares of the bus
            voltage [-].
        ankle_rolls: positions, velocities and efforts (2,) of both ankles' rolls, the stance leg
            first; zero where a foot is a line.
        yaw_rate, course: of the walk [rad/s], and its angle from the stance foot's line [rad].
    """

    def __init__(self, form: Formulation, x: ca.SX, turn: ca.SX) -> None:
        """``turn`` (2,): the course's yaw rate [rad/s] and the node's phase, from −½ to ½."""
        s, tree, motors = NodeSymbols.of(x), form.tree, Transmission.of(form.robot)
        self.form, self.symbols = form, s
        self.dynamics = tree.inverse_dynamics(
            s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a
        )
        self.roll_moment = tree.roll_wrench(s.roll, self.dynamics)[1][0]
        self.force, self.moment = tree.ground_wrench(s.roll, self.dynamics)
        self.poses = tree.poses(s.roll, s.roll_rate, s.q, s.v)
        self.base = self.poses["base"]
        self.ankle_rolls = self._ankle_rolls()
        speeds, torques = motors.matrix[:, _ORDER], motors.inverse[:, _ORDER]
        _, rates, efforts = self.ankle_rolls
        self.motor_torques = ca.DM(torques) @ ca.vertcat(self.dynamics.efforts, efforts)
        self.motor_speeds = ca.DM(speeds) @ ca.vertcat(tree.map.velocities(s.q, s.v), rates)
        self.torque_shares = self.motor_torques / ca.DM(motors.torque)
        stall, free = ca.DM(motors.stall), ca.DM(motors.speed)
        self.voltage_shares = self.motor_torques / stall + self.motor_speeds / free
        self.yaw_rate = turn[0] if form.turning else ca.SX(0)
        self.course = self.yaw_rate * turn[1] * s.step_time

    def along_course(self, vector: ca.SX) -> ca.SX:
        """Components (3,) of a world vector forward along the course, leftward and upward."""
        return rotate_back(vector, self.course)

    def foot_ends(self, leg: str) -> list[ca.SX]:
        """Toe and heel of ``STANCE`` or ``SWING`` (3,) [m]."""
        foot = self.poses[f"{leg}_{self.form.tree.ground}"]
        return [self.form.tree.point(foot, end)[0] for end in self.form.foot_ends]

    def leg_distances(self) -> list[ca.SX]:
        """Lateral distances, in the base frame, of the feet's ends and of the tubes' tops.

        The lateral coordinate is linear along a tube: tubes whose ends are apart are apart. A leg
        with a knee is taken as such a tube, on the line from the ankle through the hip.
        """
        feet = [self.foot_ends(leg) for leg in (STANCE, SWING)]
        tops, geometry, upper = [], self.form.robot.geometry, self.form.tree.upper_link
        for leg in (STANCE, SWING):  # the upper foot's axis is beyond the hip, seen from the ankle
            hip, ankle = self.poses[f"{leg}_{upper}"].origin, self.poses[f"{leg}_foot"].origin
            way = (geometry.leg_length + geometry.upper_foot_height) / ca.norm_2(hip - ankle)
            tops.append(ankle + way * (hip - ankle))
        pairs = [*((left, right) for left in feet[0] for right in feet[1]), tops]
        lateral = self.base.rotation[:, 1]
        return [ca.dot(lateral, left - right) for left, right in pairs]

    def _ankle_rolls(self) -> list[ca.SX]:
        s, tree = self.symbols, self.form.tree
        if tree.ground == "foot":
            return [ca.SX(2, 1)] * 3
        rates = (s.roll_rate, s.v), (s.roll_acceleration, s.a)
        swing = [values[NUM_JOINTS] for values in tree.all_joints(s.roll, s.q, *rates)[:2]]
        effort = tree.roll_inertia * s.roll_acceleration + tree.roll_damping * s.roll_rate
        stance = -s.roll, -s.roll_rate, -self.roll_moment - effort
        return [*map(ca.vertcat, stance, (*swing, self.dynamics.swing_roll))]

    def stored(self) -> list[ca.SX]:
        """Expressions that a gait stores for each node.

        Joint positions, velocities and torques of the virtual knee, efforts of the prismatic legs
        (10 each), base rotation (9, columns first), origin, velocity (world) and angular velocity
        (base), ground force and moment, swing foot, ``ankle_rolls``.
        """
        s, base, dynamics = self.symbols, self.base, self.dynamics
        tree = self.form.tree
        swing = tree.point(self.poses[f"{SWING}_{tree.ground}"], tree.sole)[0]
        motion = [ca.vec(base.rotation), base.origin, base.linear, base.angular]
        joints = [s.q, s.v, dynamics.torques, dynamics.efforts]
        rolls = ca.densify(ca.vertcat(*self.ankle_rolls))
        return [*joints, *motion, self.force, self.moment, swing, rolls]


def rotate_back(vectors: ca.SX, angle: ca.SX) -> ca.SX:
    """Vectors (3, n) in axes that are yawed by ``angle`` [rad]; unchanged for a 0."""
    return rotation(2, angle).T @ vectors
