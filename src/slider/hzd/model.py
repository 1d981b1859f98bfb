"""The rooted robot's dynamics, measurements and impact, evaluated for batches of states.

States are q and q̇ (n, 11) of ``slider.gait.rooted``, in the frame of the stance foot's line: x
along it, z up, the middle of the sole at the origin, reflected in right stance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial

import casadi as ca
import numpy as np

from slider.config.robot import Mechanism
from slider.core.casadi_code import Source, interpreted
from slider.gait.contact import mirrored
from slider.gait.outputs import ANKLE, LEG, NUM_JOINTS
from slider.gait.rooted import NUM, RootedRobot

_POLAR, _AXIAL = ca.DM([1.0, -1.0, 1.0]), ca.DM([-1.0, 1.0, -1.0])  # sagittal reflection


@dataclass(frozen=True)
class Kinematics:
    """Measurements of n states for guard, phase and section.

    Attributes:
        hip, hip_rate: forward position and velocity of the base's origin (n,) [m], [m/s].
        com, com_rate: of the centre of mass (n, 3) [m], [m/s].
        height, height_rate: of the middle of the swing foot's line (n,) [m], [m/s].
    """

    hip: np.ndarray
    hip_rate: np.ndarray
    com: np.ndarray
    com_rate: np.ndarray
    height: np.ndarray
    height_rate: np.ndarray


@dataclass(frozen=True)
class PostImpactState:
    """n states just after an impact, in the next step's coordinates.

    Attributes:
        q, v: (n, 11).
        pitch: by which the ankle laid the new foot's line flat (n,) [rad].
        yaw: of the new foot's line in the old frame (n,) [rad].
    """

    q: np.ndarray
    v: np.ndarray
    pitch: np.ndarray
    yaw: np.ndarray

    @property
    def state(self) -> np.ndarray:
        """(n, 22)."""
        return np.concatenate([self.q, self.v], axis=1)


class Batch:
    """A function from vectors to matrices, evaluated for n rows of arguments."""

    def __init__(
        self,
        arguments: Sequence[ca.SX],
        results: Sequence[ca.SX],
        functions: Source = interpreted,
    ) -> None:
        self._shapes = [result.shape for result in results]
        stacked = ca.vertcat(*(ca.vec(ca.densify(result)) for result in results))
        derived = ca.Function("batch", list(arguments), [ca.cse(stacked)])
        function = functions(derived.serialize(), lambda: {"batch": derived})["batch"]
        self._mapped = cache(lambda n: function.map(n).buffer())
        sizes = np.cumsum([rows * columns for rows, columns in self._shapes])
        self._ends, self._size = sizes[:-1], int(sizes[-1])

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Results (n, rows, columns), a single column as (n, rows), of arguments (n, width)."""
        n = len(arguments[0])
        results = np.empty((n, self._size))
        if n:
            buffer, evaluate = self._mapped(n)
            rows = [np.ascontiguousarray(argument, dtype=float) for argument in arguments]
            for place, values in enumerate(rows):  # rows in NumPy's order are CasADi's columns
                buffer.set_arg(place, values.data)  # pyright: ignore[reportCallIssue]
            buffer.set_res(0, results.data)  # pyright: ignore[reportCallIssue]
            evaluate()
        parts = np.split(np.asfortranarray(results), self._ends, axis=1)  # by columns: fast to use
        return [
            part if columns == 1 else part.reshape(n, columns, rows).transpose(0, 2, 1)
            for part, (rows, columns) in zip(parts, self._shapes, strict=True)
        ]


def _levelled(up: ca.SX, axis: np.ndarray) -> ca.SX:
    """Angle of an ankle that lays the line of its foot flat.

    ``up`` (1, 3) is the vertical and ``axis`` (3,) the ankle's, both in the foot's frame.
    """
    ahead = np.eye(3)[0]
    along, down, rest = ahead - axis[0] * axis, np.cross(ahead, axis), axis[0] * axis
    across = up @ ca.sparsify(ca.DM(along)), up @ ca.sparsify(ca.DM(down))
    angle = ca.atan2(*across)
    if not axis[0]:
        return angle
    return angle + ca.asin(up @ ca.DM(rest) / ca.norm_2(ca.vertcat(*across)))


class RootedModel:
    """The rooted robot's functions on batches of states; ``functions`` may compile them."""

    def __init__(self, robot: Mechanism, functions: Source = interpreted) -> None:
        self.symbols, self.geometry = RootedRobot(robot), robot.geometry
        self._batch = partial(Batch, functions=functions)

    def constrained(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Terms for the coordinates without an output: roll, stance ankle and hip.

        Returns:
            The rows of roll and stance ankle of M (n, 2, 11) and of h (n, 2); ∇p (n, 11) of the
            hip's forward position p, and p̈ at q̈ = 0 (n,) [m/s²].
        """
        rows, bias, slope, bend = self._constrained(q, v)
        return rows, bias, slope, bend[:, 0]

    def measure(self, q: np.ndarray, v: np.ndarray) -> Kinematics:
        """Measurements for guard, phase and section."""
        hip, com, com_rate, height = self._measure(q, v)
        return Kinematics(hip[:, 0], hip[:, 1], com, com_rate, height[:, 0], height[:, 1])

    def impact_map(self, q: np.ndarray, v: np.ndarray) -> PostImpactState:
        """Plastic impact of the swing foot's line; the old foot leaves.

        Only the ground's forces on the new line are impulsive, without a moment about it: M(q⁺) q̇⁺
        is the momentum of q̇⁻ about the line and along the joints. A foot that lands with a small
        pitch is laid flat by its ankle; ``slider.gait.contact.impact`` assumes a flat landing.
        """
        place, mass, carried, angles = self._impact_map(q, v)
        rate = np.linalg.solve(mass, carried[:, :, None])[:, :, 0]
        return PostImpactState(place, rate, angles[:, 0], angles[:, 1])

    def placement(self, q: np.ndarray) -> np.ndarray:
        """D (n, 10, 2): displacement of the joints per forward and left metre of the swing sole.

        Only the swing leg moves [rad/m, m/m], at constant height, pitch and yaw of its sole.
        """
        (jacobian,) = self._swing(q)
        result = np.zeros((len(q), NUM_JOINTS, 2))
        result[:, LEG:] = np.linalg.solve(jacobian, np.eye(LEG)[None, :, :2])
        return result

    @cached_property
    def _constrained(self) -> Batch:
        s = self.symbols
        hip = s.poses(s.q)["base"].origin[0]
        slope = ca.gradient(hip, s.q)
        bend = ca.jtimes(ca.jtimes(hip, s.q, s.v), s.q, s.v)
        masses, biases = zip(*(s.equation(row) for row in (0, 1 + ANKLE)), strict=True)
        return self._batch([s.q, s.v], [ca.horzcat(*masses).T, ca.vertcat(*biases), slope, bend])

    @cached_property
    def _measure(self) -> Batch:
        s = self.symbols
        poses = s.poses(s.q)
        hip = poses["base"]
        sole = ca.horzcat(*s.tree.point(poses[f"swing_{s.tree.ground}"], s.tree.sole))
        rows = [ca.vertcat(hip.origin[0], hip.linear[0]), *s.center_of_mass, sole[2, :].T]
        return self._batch([s.q, s.v], rows)

    @cached_property
    def _impact_map(self) -> Batch:
        s = self.symbols
        landing = s.poses(s.q)["swing_foot"].rotation
        pitch = _levelled(landing[2, :], np.array(self.geometry.ankle_direction) * [-1, 1, -1])
        flat = s.q + pitch * ca.DM(np.eye(NUM)[1 + LEG + ANKLE])
        foot = s.poses(flat)["swing_foot"]
        roll = -ca.atan2(foot.rotation[2, 1], foot.rotation[2, 2])
        place = ca.vertcat(roll, mirrored(flat[1:], self.geometry))
        yaw = ca.atan2(foot.rotation[1, 0], foot.rotation[0, 0])

        rate = ca.SX.sym("after", NUM)
        new = s.tree.foot_pose(roll, rate[0])
        turning = new.angular - _AXIAL * foot.angular
        linear = new.rotation.T @ new.linear - _POLAR * (foot.rotation.T @ foot.linear)
        joints, after = s.tree.all_joints(roll, place[1:], (rate[0], rate[1:]))
        before = ca.vertcat(mirrored(s.v[1:], self.geometry), s.v[0])[: after.numel()]
        foot_jump = ca.SX.zeros(3), turning, linear
        jump = s.tree.newton_euler(foot_jump, joints, 0 * before, after - before)
        start, end = (s.q[0], s.v[0], s.q[1:], s.v[1:]), (roll, rate[0], place[1:], rate[1:])
        impulse = ca.vertcat(s.tree.roll_impulse(jump, start, end), jump.efforts)
        mass = ca.jacobian(impulse, rate)
        carried = -ca.substitute(impulse, rate, ca.SX.zeros(NUM))
        return self._batch([s.q, s.v], [place, mass, carried, ca.vertcat(pitch, yaw)])

    @cached_property
    def _swing(self) -> Batch:
        s = self.symbols
        foot = s.poses(s.q)[f"swing_{s.tree.ground}"]
        along = foot.rotation[:, 0]
        held = ca.vertcat(s.tree.point(foot, s.tree.sole)[0], along[2], along[1])
        return self._batch([s.q], [ca.jacobian(held, s.q)[:, 1 + LEG :]])
