"""Impact of the swing foot, and loads and friction cone of a foot on the ground."""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from slider.config.robot import Geometry
from slider.gait.dynamics import InverseDynamics, Motion
from slider.gait.formulation import Formulation, StepEnd, rotate_back
from slider.gait.tree import LEG_JOINTS, SWING, BodyPose
from slider.robot.names import mirror_sign


def mirrored(q: ca.SX, geometry: Geometry) -> ca.SX:
    """Joint vector (10,) in the next step's coordinates: legs swapped and reflected."""
    sign = ca.DM(mirror_sign(geometry)[:LEG_JOINTS])
    return ca.SX(ca.vertcat(sign * q[LEG_JOINTS:], sign * q[:LEG_JOINTS]))


def impact(
    form: Formulation,
    poses: Mapping[str, BodyPose],
    before: StepEnd,
    after: StepEnd,
    turn: ca.SX,
) -> tuple[InverseDynamics, Motion]:
    """Joint impulses and the impulse on the landing foot, which is yawed by ``turn`` [rad].

    A Newton-Euler pass on the velocity jump, rooted at the new stance foot. ``poses`` are those
    before the impact in the old step's coordinates; ``after`` is in the new, reflected ones. The
    second result is the velocity jump of the body on the ground, which stops.
    """
    tree = form.tree
    foot, landing = poses[f"{SWING}_foot"], poses[f"{SWING}_{tree.ground}"]
    reflect = ca.DM(np.diag([1.0, -1.0, 1.0]))
    reflect_axial = ca.DM(np.diag([-1.0, 1.0, -1.0]))
    new = tree.foot_pose(after.roll, after.roll_rate)
    angular = new.angular - reflect_axial @ foot.angular
    linear = new.rotation.T @ (new.linear - reflect @ rotate_back(foot.linear, turn))
    q, v = tree.all_joints(after.roll, after.q, (after.roll_rate, after.v))
    old = ca.vertcat(mirrored(before.v, form.robot.geometry), before.roll_rate)[: v.numel()]
    still = ca.SX.zeros(3)
    jump = tree.newton_euler((still, angular, linear), q, 0 * old, v - old)
    stopped = rotate_back(landing.linear, turn)
    return jump, (still, -reflect_axial @ landing.angular, -reflect @ stopped)


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
    pairs = (toe_z, toe_y), (heel_z, heel_y), (force[2], force[0])
    cone = [mu * normal + sign * tangent for normal, tangent in pairs for sign in (-1, 1)]
    return ca.vertcat(toe_z, heel_z), ca.vertcat(*cone)
