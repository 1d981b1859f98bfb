"""What a gait must satisfy, as named symbolic expressions: at nodes and at touchdown.

Two steps make a walk. The second is written in reflected coordinates, so that the stance foot is
always the left one and the same functions serve both.
"""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.config.robot import Mechanism
from slider.gait import drives
from slider.gait.constraint import Constraint, at_least, between, equality
from slider.gait.costs import COSTS, NodeMotion
from slider.gait.symbols import NodeSymbols, StepEnd, mirrored
from slider.gait.tree import (
    GRAVITY,
    NUM_JOINTS,
    STANCE,
    SWING,
    BodyPose,
    PrismaticTree,
    StanceTree,
)
from slider.robot.knee_model import build_knee_model
from slider.robot.prismatic_model import build_prismatic_model

LENGTH_SCALE = 0.1  # [m]


def formulate(robot: Mechanism, config: FormulationConfig) -> "Formulation":
    """The formulation with the configured dynamics: the prismatic leg's or the virtual knee's."""
    knee = build_knee_model(robot.geometry, robot.links, robot.virtual_knee)
    length = robot.geometry.leg_length
    if config.dynamics == "knee":
        return Formulation(StanceTree(knee, length), config, robot)
    return Formulation(PrismaticTree(knee, length, build_prismatic_model(robot)), config, robot)


class Formulation:
    """Named constraints and cost of one node, and the touchdown between two steps."""

    def __init__(
        self,
        tree: StanceTree,
        config: FormulationConfig,
        robot: Mechanism,
    ) -> None:
        self.tree = tree
        self.config = config
        self.robot = robot
        self.weight = tree.model.mass * GRAVITY

    # --- nodes -----------------------------------------------------------------------------

    def node(self, x: ca.SX, weight: ca.SX) -> tuple[list[Constraint], ca.SX]:
        """Constraints at a node (34,) with quadrature weight, and its part of the scaled cost."""
        s = NodeSymbols.of(x)
        tree = self.tree
        dynamics = tree.inverse_dynamics(s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a)
        force, moment = tree.line_wrench(s.roll, dynamics)
        poses = tree.poses(s.roll, s.roll_rate, s.q, s.v)
        speeds = tree.map.velocities(s.q, s.v)
        motors = drives.Motors.of(dynamics.efforts, speeds, self.robot.capstan)
        constraints = [
            self._line_moment(moment),
            *self.contact(force, moment, self.config.contact.min_vertical * self.weight),
            drives.torque(motors, self.robot.drives),
            drives.voltage(motors, self.robot.drives, self.config.voltage),
            drives.position(s, tree.map, self.robot.joints),
            *self._swing_foot(poses["swing_foot"]),
            self._legs_apart(poses),
            *self._torso(poses["base"]),
        ]
        cost = COSTS[self.config.cost]
        motion = NodeMotion(dynamics.torques, motors, s.step_time, weight, self.weight)
        return constraints, cost.scale * cost.node(motion)

    def quantities(self, x: ca.SX) -> list[ca.SX]:
        """What a gait stores of a node (34,).

        Joint positions, velocities and torques of the virtual knee, efforts of the prismatic legs
        (10 each), base rotation (9, columns first), origin,
        velocity (world) and angular velocity (base), ground force and moment, swing foot.
        """
        s, tree = NodeSymbols.of(x), self.tree
        dynamics = tree.inverse_dynamics(s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a)
        force, moment = tree.line_wrench(s.roll, dynamics)
        poses = tree.poses(s.roll, s.roll_rate, s.q, s.v)
        base = poses["base"]
        swing = tree.point(poses["swing_foot"], np.array([0.0, 0.0, -tree.model.ankle_height]))[0]
        motion = [ca.vec(base.rotation), base.origin, base.linear, base.angular]
        return [s.q, s.v, dynamics.torques, dynamics.efforts, *motion, force, moment, swing]

    def _line_moment(self, moment: ca.SX) -> Constraint:
        """A foot line cannot carry a moment about itself: the roll equation."""
        return equality("foot_line_moment", "N m", "line contact", moment[0], 10.0)

    def contact(self, force: ca.SX, moment: ca.SX, least: float) -> list[Constraint]:
        """Unilateral toe and heel forces (centre of pressure on the line) and friction.

        Works on forces [N] and on impulses [N s]. The cone is an inner pyramid, μ/√2 per axis.
        """
        mu = self.config.contact.friction / np.sqrt(2.0)
        toe, heel = self.tree.model.toe, -self.tree.model.heel
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
        vertical = ca.vertcat(toe_z, heel_z)
        return [
            at_least("vertical_force", "N", "unilateral contact", vertical, least, self.weight),
            at_least("friction", "N", "Coulomb, inner pyramid", cone, 0.0, self.weight),
        ]

    def _swing_foot(self, foot: BodyPose) -> list[Constraint]:
        """Height over the step and lateral distance from the stance foot."""
        toe, heel = (self.tree.point(foot, end)[0] for end in self.foot_ends())
        posture = self.config.posture
        clearance = Constraint(
            "clearance",
            "m",
            "gait.posture.clearance, swing_height",
            ca.vertcat(toe[2], heel[2]),
            _arc(posture.clearance, self.config.nodes),
            np.full(2, posture.swing_height),
            LENGTH_SCALE,
            _arc(posture.clearance + posture.clearance_margin, self.config.nodes),
        )
        middle = (toe[1] + heel[1]) / 2
        distance = between(
            "foot_separation",
            "m",
            "gait.posture",
            [-middle],
            np.array([posture.foot_separation_min]),
            np.array([posture.foot_separation_max]),
            1.0,
        )
        return [clearance, distance]

    def _legs_apart(self, poses: dict[str, BodyPose]) -> Constraint:
        """Lateral distance, in the base's axes, of foot from foot and of tube top from tube top.

        A tube's lateral place is linear along it, so that tubes whose ends are apart are apart.
        """
        lateral = poses["base"].rotation[:, 1]
        feet = [
            [self.tree.point(poses[f"{leg}_foot"], end)[0] for end in self.foot_ends()]
            for leg in (STANCE, SWING)
        ]
        tops = [self._tube_top(poses, leg) for leg in (STANCE, SWING)]
        pairs = [(own, other) for own in feet[0] for other in feet[1]] + [(tops[0], tops[1])]
        rows = [ca.dot(lateral, own - other) for own, other in pairs]
        return at_least(
            "legs_apart", "m", "gait.posture", rows, self.config.posture.legs_apart, 1.0
        )

    def _tube_top(self, poses: dict[str, BodyPose], leg: str) -> ca.SX:
        """The upper foot's axis (3,) [m]: on the line from ankle to hip, beyond it."""
        hip, ankle = poses[f"{leg}_roll"].origin, poses[f"{leg}_foot"].origin
        geometry = self.robot.geometry
        way = (geometry.leg_length + geometry.upper_foot_height) / ca.norm_2(hip - ankle)
        return ankle + way * (hip - ankle)

    def _torso(self, base: BodyPose) -> list[Constraint]:
        """Bounds of the base's angles and angular velocity; without the latter it rocks."""
        r, posture = base.rotation, self.config.posture
        bound = np.array([posture.torso_roll, posture.torso_pitch, posture.torso_yaw])
        angles = [r[2, 1], -r[2, 0], r[1, 0]]  # sines of roll, pitch and yaw
        rate = np.full(3, posture.torso_rate)
        return [
            between("torso", "rad", "gait.posture", angles, -bound, bound, 1.0),
            between("torso_rate", "rad/s", "gait.posture", base.angular, -rate, rate, 1.0),
        ]

    def foot_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Toe and heel in the foot frame (3,) [m]."""
        model = self.tree.model
        return (
            np.array([model.toe, 0.0, -model.ankle_height]),
            np.array([-model.heel, 0.0, -model.ankle_height]),
        )

    # --- touchdown -------------------------------------------------------------------------

    def touchdown(self, before: StepEnd, after: StepEnd) -> list[Constraint]:
        """Impact, continuity and foot placement from one step's end to the next one's start.

        The impact is a Newton-Euler pass on the velocity jump, rooted at the new stance foot;
        torques cannot be impulsive, and the line carries no impulsive moment about itself.
        """
        tree = self.tree
        old = tree.poses(before.roll, before.roll_rate, before.q, before.v)
        new = tree.poses(after.roll, after.roll_rate, after.q, after.v)
        foot = old["swing_foot"]
        jump = self._jump(foot, before, after)
        force, moment = tree.line_wrench(after.roll, jump)
        sole = tree.point(foot, np.array([0.0, 0.0, -tree.model.ankle_height]))
        free = ca.vertcat(jump.torques, moment[0])
        flat = ca.vertcat(
            sole[0][2],
            foot.rotation[2, 0],
            foot.rotation[1, 0],
            ca.sin(after.roll) + foot.rotation[2, 1],
        )
        ends = [tree.point(foot, end)[1][2] for end in self.foot_ends()]
        lifted = [tree.point(new["swing_foot"], end)[1][2] for end in self.foot_ends()]
        limit = self.config.touchdown
        slow = np.array([limit.forward, limit.lateral, *[limit.angular] * 3])
        velocity = [sole[1][0], sole[1][1], *ca.vertsplit(foot.angular)]
        return [
            equality("impact", "N m s", "no impulsive torque", free, 1.0),
            equality("foot_flat", "m, rad", "foot placement", flat, LENGTH_SCALE),
            equality(
                "continuity", "rad", "impact keeps positions", after.q - mirrored(before.q), 1.0
            ),
            *[_impulsive(c) for c in self.contact(force, moment, 0.0)],
            between(
                "touchdown_speed",
                "m/s",
                "gait.touchdown",
                [-v for v in ends],
                np.full(2, limit.down_min),
                np.full(2, limit.down_max),
                1.0,
            ),
            at_least("lift_off", "m/s", "old stance foot leaves", ca.vertcat(*lifted), 0.0, 1.0),
            between(
                "touchdown_velocity", "m/s, rad/s", "gait.touchdown", velocity, -slow, slow, 1.0
            ),
        ]

    def _jump(self, foot: BodyPose, before: StepEnd, after: StepEnd):
        reflect = ca.DM(np.diag([1.0, -1.0, 1.0]))
        reflect_axial = ca.DM(np.diag([-1.0, 1.0, -1.0]))
        new = self.tree.foot_pose(after.roll, after.roll_rate)
        angular = new.angular - reflect_axial @ foot.angular
        linear = new.rotation.T @ (new.linear - reflect @ foot.linear)
        zero, rest = ca.SX.zeros(3), ca.SX.zeros(NUM_JOINTS)
        return self.tree.newton_euler(
            zero, angular, linear, after.q, rest, after.v - mirrored(before.v)
        )

    def step_vector(self, end: StepEnd) -> ca.SX:
        """Horizontal displacement (2,) [m] from the stance foot to the touched-down foot."""
        poses = self.tree.poses(end.roll, end.roll_rate, end.q, end.v)
        sole = np.array([0.0, 0.0, -self.tree.model.ankle_height])
        return self.tree.point(poses["swing_foot"], sole)[0][:2]


def _arc(height: float, nodes: int) -> Callable[[np.ndarray], np.ndarray]:
    """Parabola over the step as a bound of toe and heel (S, 2) [m].

    In the first and the last interval the foot has only not to scuff; at the very ends touchdown
    and lift-off have their own constraints.
    """
    first = 1.0 / (nodes - 1) - 1e-9

    def bound(phase: np.ndarray) -> np.ndarray:
        away = np.minimum(phase, 1.0 - phase)
        arc = np.where(away > first, 4.0 * height * phase * (1.0 - phase), 0.0)
        return np.repeat(np.where(away > 0, arc, -np.inf)[:, None], 2, axis=1)

    return bound


def _impulsive(constraint: Constraint) -> Constraint:
    """The same condition on impulses, which are of the order of 1 N s."""
    return replace(constraint, name=f"impact_{constraint.name}", unit="N s", scale=1.0)
