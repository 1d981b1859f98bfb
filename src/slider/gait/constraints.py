"""All constraints of a gait, in the order in which the solver has them, in SI units.

To add one, register a function of a node with ``bounded`` and bound it in ``gait.bounds``. The
constraints in the lists below are in every gait; the defects are in ``slider.gait.problem``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from slider.core.errors import UserError
from slider.gait.contact import end_loads, impact, mirrored
from slider.gait.formulation import Formulation, Node, StepEnd, rotate_back
from slider.gait.tree import SWING
from slider.robot.names import GAIT_JOINTS, LEG_GAIT_JOINTS, SIDES

ROLL_BOUNDS = (0.6, 6.0, 200.0)  # generous: solutions stay inside [rad, rad/s, rad/s²]
_LENGTH = 0.1  # scale of small lengths [m]

# A number for all rows, (n,), or, for rows of a node, a function that maps phases (S,) to (S, n).
Bound = float | np.ndarray | Callable[[np.ndarray], np.ndarray]
Rows = ca.SX | list[ca.SX]


@dataclass(frozen=True)
class Constraint:
    """A named group of symbolic rows with bounds.

    Attributes:
        name: under which residuals are reported.
        rows: (n,).
        lower, upper: bounds.
        scale: divisor of rows and bounds in the solver.
        node_lower: lower bound at the nodes, with a margin for the motion between them.
    """

    name: str
    rows: Rows
    lower: Bound
    upper: Bound
    scale: float = 1.0
    node_lower: Bound | None = None

    @property
    def expression(self) -> ca.SX:
        """The rows in one column."""
        return ca.vertcat(*self.rows) if isinstance(self.rows, list) else self.rows

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.expression.numel()

    def bounds(self, phase: np.ndarray, at_nodes: bool = True) -> list[np.ndarray]:
        """Scaled bounds (S, n), lower and upper, at phases (S,); ``at_nodes``: ``node_lower``."""
        lower = self.node_lower if at_nodes and self.node_lower is not None else self.lower
        sides = (side(phase) if callable(side) else side for side in (lower, self.upper))
        return [np.broadcast_to(side, (len(phase), self.size)) / self.scale for side in sides]


def equality(name: str, rows: Rows, scale: float) -> Constraint:
    """Rows that are zero."""
    return Constraint(name, rows, 0.0, 0.0, scale)


def at_least(name: str, rows: Rows, least: float, scale: float = 1.0) -> Constraint:
    """Rows bounded below."""
    return Constraint(name, rows, least, np.inf, scale)


def within(name: str, rows: Rows, bound: float | np.ndarray) -> Constraint:
    """Rows bounded in magnitude."""
    return Constraint(name, rows, -bound, bound)


def scaled_rows(constraints: Sequence[Constraint]) -> ca.SX:
    """All rows, scaled for the solver."""
    return ca.vertcat(*[c.expression / c.scale for c in constraints])


def scaled_bounds(
    constraints: Sequence[Constraint], phase: np.ndarray, at_nodes: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (S, rows) of all rows at phases (S,); see ``Constraint.bounds``."""
    lower, upper = zip(*(c.bounds(phase, at_nodes) for c in constraints), strict=True)
    return np.concatenate(lower, axis=1), np.concatenate(upper, axis=1)


NodeRows = Callable[[Node], ca.SX]
_BOUNDED: dict[str, NodeRows] = {}


def bounded(rows: NodeRows) -> NodeRows:
    """Register rows of a node; ``gait.bounds`` bounds them under the function's name."""
    _BOUNDED[rows.__name__] = rows
    return rows


@bounded
def base_height(node: Node) -> ca.SX:
    """Height of the base's origin above the stance foot's line [m]."""
    return node.base.origin[2]


def of_node(node: Node) -> list[Constraint]:
    """Constraints at every node of both steps.

    Raises:
        UserError: ``gait.bounds`` has a name that is not registered.
    """
    constraints = [*_loads(node), *_legs(node), *_torso(node)]
    for name, bound in node.form.config.bounds.items():
        if name not in _BOUNDED:
            raise UserError(f"gait.bounds: expected one of {', '.join(_BOUNDED)}, found {name}")
        constraints.append(Constraint(name, _BOUNDED[name](node), bound.lower, bound.upper))
    return constraints


def _loads(node: Node) -> list[Constraint]:
    """Ground reaction of the stance foot [N, N m], motors [-] and joint positions [rad, m]."""
    form, weight = node.form, node.form.weight
    vertical, cone = end_loads(form, node.force, node.moment)
    least = form.config.contact.min_vertical * weight
    legs = ca.vertsplit(form.tree.map.positions(node.symbols.q), LEG_GAIT_JOINTS)
    sagittal, names = form.robot.geometry.sagittal, form.robot.geometry.leg_joints
    # Yaw and roll are bounded as variables.
    ranges = [form.robot.joints[names[place]] for place in sagittal] * len(SIDES)
    lower, upper = (np.array([getattr(r, side) for r in ranges]) for side in ("lower", "upper"))
    return [
        # A foot line cannot carry a moment about itself: the roll equation.
        equality("foot_line_moment", node.roll_moment, 10.0),
        *_within_sole(form, node.force, node.moment, least, weight),
        at_least("vertical_force", vertical, least, weight),
        at_least("friction", cone, 0.0, weight),
        within("motor_torque", node.torque_shares, 1.0),
        within("motor_voltage", node.voltage_shares, form.config.voltage),
        Constraint("position", [leg[list(sagittal)] for leg in legs], lower, upper),
        *_rolls(node),
    ]


def _rolls(node: Node) -> list[Constraint]:
    """Positions of both ankles' rolls [rad]."""
    robot = node.form.robot
    if robot.geometry.sole is None:
        return []
    limits = robot.joints["ankle_roll"]
    return [Constraint("ankle_roll", node.ankle_rolls[0], limits.lower, limits.upper)]


def _within_sole(
    form: Formulation, force: ca.SX, moment: ca.SX, least: float, scale: float
) -> list[Constraint]:
    """Vertical ground forces on both sides of a sole."""
    sole = form.robot.geometry.sole
    if sole is None:
        return []
    sides = [force[2] / 2 + sign * moment[0] / sole.width for sign in (-1, 1)]
    return [at_least("sole_width", sides, least, scale)]


def _legs(node: Node) -> list[Constraint]:
    """Swing foot above the ground, and legs that stay apart [m]."""
    posture = node.form.config.posture
    toe, heel = node.foot_ends(SWING)
    lateral = -((node.along_course(toe)[1] + node.along_course(heel)[1]) / 2)
    low = _arc(posture.clearance, posture.clearance_from)
    at_nodes = _arc(posture.clearance + posture.clearance_margin, posture.clearance_from)
    nearest, farthest = posture.foot_separation_min, posture.foot_separation_max
    return [
        Constraint("clearance", [toe[2], heel[2]], low, posture.swing_height, _LENGTH, at_nodes),
        Constraint("foot_separation", lateral, nearest, farthest),
        at_least("legs_apart", node.leg_distances(), posture.legs_apart),
    ]


def _arc(height: float, first: float) -> Callable[[np.ndarray], np.ndarray]:
    """Parabola over the step as a bound of toe and heel (S, 2) [m].

    Before phase ``first`` and after 1 − ``first`` the foot must only not scuff; at the very ends
    touchdown and lift-off have their own constraints. ``first`` does not depend on the mesh:
    otherwise each mesh would pose a different problem.
    """

    def bound(phase: np.ndarray) -> np.ndarray:
        away = np.minimum(phase, 1.0 - phase)
        arc = np.where(away > first - 1e-9, 4.0 * height * phase * (1.0 - phase), 0.0)
        return np.repeat(np.where(away > 0, arc, -np.inf)[:, None], 2, axis=1)

    return bound


def _torso(node: Node) -> list[Constraint]:
    """Sines of the torso's roll, pitch and yaw from the course, and its rates: else it rocks."""
    posture, base, r = node.form.config.posture, node.base, node.base.rotation
    rate = base.angular - r.T @ ca.vertcat(0, 0, node.yaw_rate)
    torso = np.array([posture.torso_roll, posture.torso_pitch, posture.torso_yaw])
    return [
        within("torso", [r[2, 1], -r[2, 0], node.along_course(r[:, 0])[1]], torso),
        within("torso_rate", rate, posture.torso_rate),
    ]


def of_touchdown(
    form: Formulation, before: StepEnd, after: StepEnd, turn: ca.SX
) -> list[Constraint]:
    """Impact, continuity and foot placement from one step's end to the next one's start.

    The foot lands yawed by ``turn`` [rad] from the old one, in the first step's coordinates.
    Torques cannot be impulsive, and the line carries no impulsive moment about itself.
    """
    tree, limit = form.tree, form.config.touchdown
    poses, ground = tree.poses(*before), f"{SWING}_{tree.ground}"
    foot, landing, lifting = poses[f"{SWING}_foot"], poses[ground], tree.poses(*after)[ground]
    jump, sole = impact(form, poses, before, after, turn)
    force, moment = tree.ground_wrench(after.roll, jump, sole)
    vertical, cone = end_loads(form, force, moment)
    place, velocity = tree.point(landing, tree.sole)
    velocity, axes = rotate_back(velocity, turn), rotate_back(foot.rotation, turn)
    level = [axes[2, 0], axes[1, 0], ca.sin(after.roll) + axes[2, 1]]
    down = [-tree.point(landing, end)[1][2] for end in form.foot_ends]
    up = [tree.point(lifting, end)[1][2] for end in form.foot_ends]
    slow = np.array([limit.forward, limit.lateral, *[limit.angular] * 3])
    return [
        equality("impact", [jump.torques, tree.roll_impulse(jump, before, after)], 1.0),
        equality("foot_flat", [place[2], *level], _LENGTH),
        equality("continuity", after.q - mirrored(before.q, form.robot.geometry), 1.0),
        # The conditions of contact on impulses, which are of the order of 1 N s.
        at_least("impact_vertical_force", vertical, 0.0),
        at_least("impact_friction", cone, 0.0),
        *_within_sole(form, force, moment, 0.0, 1.0),
        Constraint("touchdown_speed", down, limit.down_min, limit.down_max),
        at_least("lift_off", up, 0.0),
        within("touchdown_velocity", [velocity[0], velocity[1], landing.angular], slow),
    ]


def of_walk(
    form: Formulation,
    starts: list[StepEnd],
    ends: list[StepEnd],
    times: list[ca.SX],
    velocity: ca.SX,
) -> list[Constraint]:
    """Both touchdowns, mean velocity, equal step times [s] and forward step lengths [m].

    ``velocity`` (3,): vx, vy [m/s], yaw rate [rad/s]. Without equal lengths the cheapest slow walk
    keeps one foot 0.4 m ahead of the other. Steps of a turning walk are equal along the course at
    touchdown; the strides of the inner and the outer foot then differ.
    """
    turns, steps, poses = [ca.SX(0), ca.SX(0)], [], form.tree.poses
    if form.turning:
        turns = [sign * velocity[2] * time for sign, time in zip((1, -1), times, strict=True)]
    for end, turn in zip(ends, turns, strict=True):  # along the course at touchdown
        foot = form.tree.point(poses(*end)[f"{SWING}_{form.tree.ground}"], form.tree.sole)[0]
        steps.append(rotate_back(foot, turn / 2)[:2])
    travel = steps
    if form.turning:  # feet and base move along different arcs
        pairs = zip(starts, ends, strict=True)
        bases = [[poses(*side)["base"].origin for side in pair] for pair in pairs]
        travel = [(last - first)[:2] for first, last in bases]
    walk = times[0] + times[1]
    mean = [
        travel[0][0] + travel[1][0] - velocity[0] * walk,
        travel[0][1] - travel[1][1] - velocity[1] * walk,  # the second step is reflected
    ]
    return [
        *of_touchdown(form, ends[0], starts[1], turns[0]),
        *of_touchdown(form, ends[1], starts[0], turns[1]),
        equality("mean_velocity", mean, 0.1),
        equality("equal_step_times", times[0] - times[1], 1.0),
        equality("equal_step_lengths", steps[0][0] - steps[1][0], 0.1),
    ]


def joint_bounds(form: Formulation) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of the joint variables (10,) [rad, m]; ``position`` bounds hip pitch and ankle.

    ``posture`` bounds the knee's flexion; a robot's own knee joint is zero at the nominal flexion.
    A slide without a virtual knee has its own range.
    """
    posture, geometry = form.config.posture, form.robot.geometry
    bounds, bend = form.robot.joint_ranges[:, GAIT_JOINTS], geometry.bend
    knee = np.array([posture.knee_min, posture.knee_max])
    if bend:
        knee = np.sort(np.sign(bend) * knee - bend)
    pitch, extension, ankle = geometry.sagittal
    if bend or form.robot.virtual_knee is not None:
        bounds[:, extension::LEG_GAIT_JOINTS] = knee[:, None]
    for place in (pitch, ankle):
        bounds[:, place::LEG_GAIT_JOINTS] = [[-np.pi], [np.pi]]
    return bounds[0], bounds[1]
