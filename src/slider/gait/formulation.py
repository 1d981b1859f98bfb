"""What a gait must satisfy, as named symbolic expressions: at nodes and at touchdown.

Two steps make a walk. The second is written in reflected coordinates, so that the stance foot is
always the left one and the same functions serve both.
"""

from dataclasses import replace

import casadi as ca
import numpy as np

from slider.core.config.gait import FormulationConfig
from slider.core.config.robot import JointLimits
from slider.gait.constraint import Constraint, at_least, between, equality
from slider.gait.symbols import NodeSymbols, StepEnd, mirrored
from slider.gait.tree import (
    GRAVITY,
    LEG_JOINTS,
    NUM_JOINTS,
    BodyPose,
    StanceTree,
)

TORQUE_SCALE = 50.0  # [N m]
SPEED_SCALE = 10.0  # [rad/s]
LENGTH_SCALE = 0.1  # [m]
KNEE = 3


class Formulation:
    """Named constraints and cost of one node, and the touchdown between two steps."""

    def __init__(
        self,
        tree: StanceTree,
        config: FormulationConfig,
        limits: dict[str, JointLimits],
        leg_length: float,
    ) -> None:
        self.tree = tree
        self.leg_length = leg_length
        self.config = config
        self.limits = limits
        self.phase = np.linspace(0.0, 1.0, config.nodes)
        self.weight = tree.model.mass * GRAVITY

    # --- nodes -----------------------------------------------------------------------------

    def node(self, x: ca.SX) -> tuple[list[Constraint], ca.SX]:
        """Constraints at a node (34,) and the squared torque ‖τ‖² [N² m²]."""
        s = NodeSymbols.of(x)
        tree = self.tree
        dynamics = tree.inverse_dynamics(s.roll, s.roll_rate, s.roll_acceleration, s.q, s.v, s.a)
        force, moment = tree.line_wrench(s.roll, dynamics)
        poses = tree.poses(s.roll, s.roll_rate, s.q, s.v)
        constraints = [
            self._line_moment(moment),
            *self.contact(force, moment, self.config.contact.min_vertical * self.weight),
            *self._drives(s, dynamics.torques),
            *self._swing_foot(poses["swing_foot"]),
            self._torso(poses["base"]),
        ]
        return constraints, ca.sumsqr(dynamics.torques)

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

    def _drives(self, s: NodeSymbols, torques: ca.SX) -> list[Constraint]:
        """Efforts, speeds and positions of the prismatic leg's drives (eq. 1, exact)."""
        model = self.tree.model
        l1, l2 = model.thigh, model.shank
        effort, speed, place = [], [], []
        force_room = []
        for leg in (0, LEG_JOINTS):
            theta, rate = s.q[leg + KNEE], s.v[leg + KNEE]
            length = ca.sqrt(l1**2 + l2**2 + 2 * l1 * l2 * ca.cos(theta))
            hip = l2 * (l2 + l1 * ca.cos(theta)) / length**2
            ankle = l1 * (l1 + l2 * ca.cos(theta)) / length**2
            slide = l1 * l2 * ca.sin(theta) / length
            t = torques[leg : leg + LEG_JOINTS]
            v = s.v[leg : leg + LEG_JOINTS]
            effort += [t[0], t[1], t[2], t[4]]
            speed += [v[0], v[1], v[2] - hip * rate, v[4] - ankle * rate]
            work = t[3] + hip * t[2] + ankle * t[4]
            reach = self.limits["slide"].effort * slide
            force_room += [reach - work, reach + work]
            hip_shift = ca.atan2(l2 * ca.sin(theta), l1 + l2 * ca.cos(theta))
            q = s.q[leg : leg + LEG_JOINTS]
            place += [q[2] - hip_shift, q[4] - (theta - hip_shift), length]
            speed.append(slide * rate)
        rotary = ("hip_yaw", "hip_roll", "hip_pitch", "ankle")
        efforts = np.tile([self.limits[name].effort for name in rotary], 2)
        speeds = np.tile([*(self.limits[name].speed for name in rotary), 0.0], 2)
        speeds[4::5] = self.limits["slide"].speed
        return [
            between("torque", "N m", "robot.limits", effort, -efforts, efforts, TORQUE_SCALE),
            at_least(
                "slide_force",
                "N m",
                "robot.limits.slide.effort · |dl/dθ|",
                ca.vertcat(*force_room),
                0.0,
                TORQUE_SCALE,
            ),
            between("speed", "rad/s, m/s", "robot.limits", speed, -speeds, speeds, SPEED_SCALE),
            self._places(place),
        ]

    def _places(self, place: list[ca.SX]) -> Constraint:
        pitch, ankle, slide = (self.limits[name] for name in ("hip_pitch", "ankle", "slide"))
        nominal = self.leg_length
        lower = np.tile([pitch.lower, ankle.lower, nominal + slide.lower], 2)
        upper = np.tile([pitch.upper, ankle.upper, nominal + slide.upper], 2)
        return between("position", "rad, m", "robot.limits", place, lower, upper, 1.0)

    def _swing_foot(self, foot: BodyPose) -> list[Constraint]:
        """Height over the step and lateral distance from the stance foot."""
        toe, heel = (self.tree.point(foot, end)[0] for end in self.foot_ends())
        posture = self.config.posture
        arc = 4.0 * posture.clearance * self.phase * (1.0 - self.phase)
        lower = np.repeat(arc[:, None], 2, axis=1)
        lower[[0, -1]] = -np.inf  # touchdown and lift-off have their own constraints
        height = ca.vertcat(toe[2], heel[2])
        clearance = Constraint(
            "clearance",
            "m",
            "gait.posture.clearance, swing_height",
            height,
            lower,
            np.full_like(lower, posture.swing_height),
            LENGTH_SCALE,
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

    def _torso(self, base: BodyPose) -> Constraint:
        r, posture = base.rotation, self.config.posture
        bound = np.array([posture.torso_roll, posture.torso_pitch, posture.torso_yaw])
        angles = [r[2, 1], -r[2, 0], r[1, 0]]  # sines of roll, pitch and yaw
        return between("torso", "rad", "gait.posture", angles, -bound, bound, 1.0)

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


def _impulsive(constraint: Constraint) -> Constraint:
    """The same condition on impulses, which are of the order of 1 N s."""
    return replace(constraint, name=f"impact_{constraint.name}", unit="N s", scale=1.0)
