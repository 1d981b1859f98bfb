"""Expressions of constraints and costs: a node of a step, the end of a step, an impact."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.config.robot import Drive
from slider.gait.dynamics import InverseDynamics
from slider.gait.formulation import Formulation
from slider.gait.tree import LEG_JOINTS, NUM_JOINTS, STANCE, SWING, BodyPose, rotation
from slider.robot.names import LEG_MIRROR_SIGN, SIDES
from slider.robot.transmission import by_motor, leg_matrix


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
        n = NUM_JOINTS
        return cls(
            x[0], x[1], x[2], x[3 : 3 + n], x[3 + n : 3 + 2 * n], x[3 + 2 * n : 3 + 3 * n], x[-1]
        )

    @property
    def v(self) -> ca.SX:
        """Joint velocities (10,) [rad/s]."""
        return self.q_phase / self.step_time

    @property
    def a(self) -> ca.SX:
        """Joint accelerations (10,) [rad/s²]."""
        return self.q_phase2 / self.step_time**2


@dataclass(frozen=True)
class StepEnd:
    """State at the start or the end of a step."""

    roll: ca.SX
    roll_rate: ca.SX
    q: ca.SX
    v: ca.SX


def mirrored(q: ca.SX) -> ca.SX:
    """Joint vector (10,) in the next step's coordinates: legs swapped and reflected."""
    sign = ca.DM(LEG_MIRROR_SIGN[:LEG_JOINTS])
    return ca.SX(ca.vertcat(sign * q[LEG_JOINTS:], sign * q[:LEG_JOINTS]))


@dataclass(frozen=True)
class Node:
    """A node of a step, of its vector (34,).

    Attributes:
        form: the formulation of the gait.
        symbols: variables of the node.
        dynamics: joint torques and efforts.
        force, moment: of the ground at the middle of the foot line [N], [N m], world axes.
        poses: of all bodies.
        motor_torques, motor_speeds: both legs', stance first, in the order of ``LEG_MOTORS`` (10,)
            [N m], [rad/s]. The slide's force is work over |dl/dθ|, which vanishes for a straight
            leg: the knee's lower bound keeps away from it.
        course: of the walk, from the stance foot's line [rad].
        yaw_rate: of the course [rad/s].
    """

    form: Formulation
    symbols: NodeSymbols
    dynamics: InverseDynamics
    force: ca.SX
    moment: ca.SX
    poses: dict[str, BodyPose]
    motor_torques: ca.SX
    motor_speeds: ca.SX
    course: ca.SX
    yaw_rate: ca.SX

    @classmethod
    def of(cls, form: Formulation, x: ca.SX, turn: ca.SX) -> "Node":
        """Build the expressions of a node vector (34,).

        ``turn`` (2,) is the course's yaw rate [rad/s] and the node's phase, from −½ to ½.
        """
        s, tree = NodeSymbols.of(x), form.tree
        dynamics = tree.inverse_dynamics(s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a)
        force, moment = tree.line_wrench(s.roll, dynamics)
        poses = tree.poses(s.roll, s.roll_rate, s.q, s.v)
        matrix = np.kron(np.eye(len(SIDES)), leg_matrix(form.robot.capstan))
        torques = ca.DM(np.linalg.inv(matrix).T) @ dynamics.efforts
        speeds = ca.DM(matrix) @ tree.map.velocities(s.q, s.v)
        yaw_rate = turn[0] if form.turning else ca.SX(0)
        course = yaw_rate * turn[1] * s.step_time
        return cls(form, s, dynamics, force, moment, poses, torques, speeds, course, yaw_rate)

    @property
    def base(self) -> BodyPose:
        """The torso."""
        return self.poses["base"]

    @property
    def torque_shares(self) -> ca.SX:
        """Motor torques (10,) as shares of their limits [-]."""
        return self.motor_torques / ca.DM([drive.torque for drive in self._drives])

    @property
    def voltage_shares(self) -> ca.SX:
        """Torque / stall torque + speed / no-load speed (10,): shares of the bus voltage [-]."""
        stall = ca.DM([drive.stall_ratio * drive.torque for drive in self._drives])
        free = ca.DM([drive.speed for drive in self._drives])
        return self.motor_torques / stall + self.motor_speeds / free

    @property
    def _drives(self) -> list[Drive]:
        return by_motor(self.form.robot, self.form.robot.drives) * len(SIDES)

    def along_course(self, vector: ca.SX) -> ca.SX:
        """A world vector (3,) forward, leftward and upward of the course."""
        return turned_back(vector, self.course)

    def foot_ends(self, leg: str) -> list[ca.SX]:
        """Toe and heel of ``STANCE`` or ``SWING`` (3,) [m]."""
        foot = self.poses[f"{leg}_foot"]
        return [self.form.tree.point(foot, end)[0] for end in self.form.foot_ends]

    def tube_top(self, leg: str) -> ca.SX:
        """The upper foot's axis (3,) [m]: on the line from ankle to hip, beyond it."""
        hip, ankle = self.poses[f"{leg}_thigh"].origin, self.poses[f"{leg}_foot"].origin
        geometry = self.form.robot.geometry
        way = (geometry.leg_length + geometry.upper_foot_height) / ca.norm_2(hip - ankle)
        return ankle + way * (hip - ankle)

    def leg_distances(self) -> list[ca.SX]:
        """Lateral, in the base's axes, of foot ends from foot ends and of tube top from tube top.

        A tube's lateral place is linear along it, so that tubes whose ends are apart are apart.
        """
        lateral = self.base.rotation[:, 1]
        feet = [self.foot_ends(leg) for leg in (STANCE, SWING)]
        tops = [self.tube_top(leg) for leg in (STANCE, SWING)]
        pairs = [(left, right) for left in feet[0] for right in feet[1]] + [(tops[0], tops[1])]
        return [ca.dot(lateral, left - right) for left, right in pairs]

    def stored(self) -> list[ca.SX]:
        """Expressions that a gait stores of a node.

        Joint positions, velocities and torques of the virtual knee, efforts of the prismatic legs
        (10 each), base rotation (9, columns first), origin, velocity (world) and angular velocity
        (base), ground force and moment, swing foot.
        """
        s, base, dynamics = self.symbols, self.base, self.dynamics
        swing = self.form.tree.point(self.poses["swing_foot"], self.form.tree.sole)[0]
        motion = [ca.vec(base.rotation), base.origin, base.linear, base.angular]
        joints = [s.q, s.v, dynamics.torques, dynamics.efforts]
        return [*joints, *motion, self.force, self.moment, swing]


def turned_back(vectors: ca.SX, angle: ca.SX) -> ca.SX:
    """Vectors (3, n) as axes that are yawed by ``angle`` [rad] see them; unchanged for a 0."""
    return rotation(2, angle).T @ vectors


def impact(
    form: Formulation, foot: BodyPose, before: StepEnd, after: StepEnd, turn: ca.SX
) -> InverseDynamics:
    """Impulsive torques and impulses on the foot that lands, yawed by ``turn`` [rad].

    A Newton-Euler pass on the velocity jump, rooted at the new stance foot. ``foot`` is its pose in
    the old step's coordinates; those of ``after`` are reflected.
    """
    reflect = ca.DM(np.diag([1.0, -1.0, 1.0]))
    reflect_axial = ca.DM(np.diag([-1.0, 1.0, -1.0]))
    new = form.tree.foot_pose(after.roll, after.roll_rate)
    angular = new.angular - reflect_axial @ foot.angular
    linear = new.rotation.T @ (new.linear - reflect @ turned_back(foot.linear, turn))
    zero, rest = ca.SX.zeros(3), ca.SX.zeros(NUM_JOINTS)
    return form.tree.newton_euler(
        zero, angular, linear, after.q, rest, after.v - mirrored(before.v)
    )


def end_loads(form: Formulation, force: ca.SX, moment: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Vertical forces at toe and heel (2,), and slack of the friction cone (6,) [N].

    Works on forces [N] and on impulses [N s]. The cone is an inner pyramid, μ/√2 per axis.
    """
    mu = form.config.contact.friction / np.sqrt(2.0)
    toe, heel = form.robot.geometry.toe, -form.robot.geometry.heel
    toe_z = (-moment[1] - heel * force[2]) / (toe - heel)
    heel_z = force[2] - toe_z
    toe_y = (moment[2] - heel * force[1]) / (toe - heel)
    heel_y = force[1] - toe_y
    cone = ca.vertcat(
        mu * toe_z - toe_y,
        mu * toe_z + toe_y,
        mu * heel_z - heel_y,
        mu * heel_z + heel_y,
        mu * force[2] - force[0],
        mu * force[2] + force[0],
    )
    return ca.vertcat(toe_z, heel_z), cone


def step_vector(form: Formulation, end: StepEnd, course: ca.SX) -> ca.SX:
    """Displacement (2,) [m] from the stance foot to the touched-down foot, along the course."""
    poses = form.tree.poses(end.roll, end.roll_rate, end.q, end.v)
    return turned_back(form.tree.point(poses["swing_foot"], form.tree.sole)[0], course)[:2]


def base_displacement(form: Formulation, start: StepEnd, end: StepEnd) -> ca.SX:
    """Horizontal displacement (2,) [m] of the base in a step, along the stance foot's line."""
    first, last = (form.tree.poses(s.roll, s.roll_rate, s.q, s.v) for s in (start, end))
    return (last["base"].origin - first["base"].origin)[:2]
