"""Tasks of the whole-body QP: desired accelerations of the parts of the body.

Torques are (n, 12) [N m or N], returned with a flag whether the QP has a solution (n,).
"""

import numpy as np

from slider.config.control import TaskConfig, WholeBodyConfig
from slider.config.robot import RobotConfig
from slider.control.whole_body.memory import FEET, Memory
from slider.control.whole_body.model import NUM_DOFS, Dynamics
from slider.control.whole_body.problem import Task, WholeBody
from slider.core.compiled import compiled
from slider.robot.kinematics import about_z

_LINE, _UP = 5, 2  # coordinates of a foot's line: place, pitch, yaw; its height. A sole rolls, too
Solved = tuple[np.ndarray, np.ndarray]


class BodyControl:
    """Turns references of n nominal robots into torques; all ways of stepping share it.

    ``search`` is the velocity at which feet without contact sink [m/s], ``height`` the height of
    the pendulum [m].
    """

    def __init__(
        self, robot: RobotConfig, config: WholeBodyConfig, search: float, height: float
    ) -> None:
        self._config, self._search, self._height = config, search, height
        self._whole_body = WholeBody(robot, config)
        self.has_soles = robot.geometry.sole is not None

    def on_both_feet(
        self,
        memory: Memory,
        robots: np.ndarray,
        dynamics: Dynamics,
        contact: np.ndarray,
        desired: np.ndarray,
    ) -> Solved:
        """Centre of mass as ``desired``; feet without ``contact`` (n, 2) search for the ground.

        ``desired`` (n, 2, 3): forward and leftward position from the middle of the feet [m],
        velocity, acceleration.
        """
        position = memory.to_heading(dynamics.com[:, :2], robots)
        velocity = memory.to_heading(dynamics.com_velocity[:, :2], robots)
        task = self._config.com
        error = desired[:, :, 0] - (position - memory.sway.middle[robots])
        flat = desired[:, :, 2] + task.kp * error + task.kd * (desired[:, :, 1] - velocity)
        flat = memory.to_world(flat, robots)
        ground = dynamics.foot_positions[:, :, 2].mean(axis=1)
        weight = np.ones(3) * max(task.weight)
        feet = np.tile(FEET, (len(robots), 1))
        sinking = np.where(contact, 0.0, self._search)
        tasks = [
            *self.body(memory, robots, dynamics, flat, ground, weight),
            self.stance(dynamics, feet, sinking),
        ]
        return self.solve(dynamics, tasks, feet, contact)

    def body(
        self,
        memory: Memory,
        robots: np.ndarray,
        dynamics: Dynamics,
        flat: np.ndarray,
        ground: np.ndarray,
        weight: np.ndarray,
        climb: np.ndarray | float = 0.0,
    ) -> list[Task]:
        """Tasks of base and centre of mass, with horizontal acceleration ``flat`` (n, 2).

        The ground height ``ground`` (n,) [m] under the centre of mass rises by ``climb`` [m/s].
        """
        task = self._config.com
        error = self._height - (dynamics.com[:, 2] - ground)
        lift = task.kp * error - task.kd * (dynamics.com_velocity[:, 2] - climb)
        acceleration = np.concatenate([flat, lift[:, None]], axis=1)
        return [
            (dynamics.com_jacobian, acceleration - dynamics.com_bias, weight),
            self.base(dynamics, memory.heading[robots], memory.yaw_rate(robots)),
        ]

    def solve(
        self,
        dynamics: Dynamics,
        tasks: list[Task],
        feet: np.ndarray,
        loaded: np.ndarray,
        idle: np.ndarray | None = None,
    ) -> Solved:
        """Torques for ``tasks`` on ``feet`` (n, k); only ``loaded`` ones have contact forces.

        Motors that are ``idle`` (n, m) have no torque.
        """
        return self._whole_body.solve(self._whole_body.build(dynamics, tasks, feet, loaded, idle))

    def base(self, dynamics: Dynamics, heading: np.ndarray, yaw_rate: np.ndarray) -> Task:
        """Base upright, looking along ``heading`` (n,) [rad] that turns with ``yaw_rate`` (n,)."""
        n, rotation = len(heading), dynamics.base_rotation
        rate = -(rotation @ dynamics.qvel[:, 3:6, None])[..., 0]
        rate[:, 2] += yaw_rate
        jacobian = np.zeros((n, 3, NUM_DOFS))
        jacobian[:, :, 3:6] = rotation  # base rates are in its own frame
        difference = about_z(heading) @ rotation.swapaxes(1, 2)  # a small turn, world axes
        skew = 0.5 * (difference - difference.swapaxes(1, 2))
        error = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
        return jacobian, *feedback(self._config.base, error, rate)

    def level(
        self, dynamics: Dynamics, foot: np.ndarray, gains: tuple[float, float], weight: float
    ) -> list[Task]:
        """The soles of feet (n,) do not roll; no task where a foot is a line.

        ``gains`` are of the roll and its rate [1/s²], [1/s].
        """
        if not self.has_soles:
            return []
        robots = np.arange(len(foot))
        rotation = dynamics.foot_rotations[robots, foot]
        axis = rotation[:, None, :, 0]
        turn = axis @ dynamics.foot_jacobians[robots, foot, 3:]
        bias = (axis @ dynamics.foot_bias[robots, foot, 3:, None])[..., 0]
        roll = np.arcsin(np.clip(rotation[:, 2, 1], -1.0, 1.0))[:, None]
        desired = -gains[0] * roll - gains[1] * point_velocity(turn, dynamics.qvel)
        return [(turn, desired - bias, np.array([weight]))]

    def stance(self, dynamics: Dynamics, feet: np.ndarray, sinking: np.ndarray) -> Task:
        """Lines or soles of ``feet`` (n, k) do not move; those in the air sink (n, k) [m/s]."""
        (n, count), rows = feet.shape, _LINE + self.has_soles
        jacobian, desired = np.empty((n, count, rows, NUM_DOFS)), np.empty((n, count, rows))
        terms = dynamics.foot_jacobians, dynamics.foot_bias, dynamics.foot_rotations
        task = self._config.stance
        _stance(terms, dynamics.qvel, feet, sinking, task.kd, jacobian, desired)
        turns = [*task.weight[1:], task.weight[1]][: rows - 3]
        weight = np.tile([task.weight[0]] * 3 + turns, count)
        return jacobian.reshape(n, -1, NUM_DOFS), desired.reshape(n, -1), weight


@compiled
def _stance(
    terms: tuple[np.ndarray, np.ndarray, np.ndarray],
    qvel: np.ndarray,
    feet: np.ndarray,
    sinking: np.ndarray,
    kd: float,
    jacobian: np.ndarray,
    desired: np.ndarray,
) -> None:
    """J (n, k, rows, 18) of place, pitch, yaw and maybe roll, and −kd (J q̇ + sinking) − J̇ q̇."""
    jacobians, biases, rotations = terms
    for robot in range(len(feet)):
        for place, foot in enumerate(feet[robot]):
            foot_jacobian, bias = jacobians[robot, foot], biases[robot, foot]
            x, y = rotations[robot, foot, 0, 0], rotations[robot, foot, 1, 0]
            length = np.sqrt(x * x + y * y)
            rows, rate = jacobian[robot, place], desired[robot, place]
            for dof in range(NUM_DOFS):
                for axis in range(3):
                    rows[axis, dof] = foot_jacobian[axis, dof]
                rows[3, dof] = (x * foot_jacobian[4, dof] - y * foot_jacobian[3, dof]) / length
                rows[4, dof] = foot_jacobian[5, dof]
                if len(rows) > _LINE:
                    rows[5, dof] = (x * foot_jacobian[3, dof] + y * foot_jacobian[4, dof]) / length
            for axis in range(3):
                rate[axis] = -bias[axis]
            rate[3], rate[4] = -(x * bias[4] - y * bias[3]) / length, -bias[5]
            if len(rows) > _LINE:
                rate[5] = -(x * bias[3] + y * bias[4]) / length
            rate[_UP] -= kd * sinking[robot, place]
            for row in range(len(rows)):
                rate[row] -= kd * np.dot(rows[row], qvel[robot])


def pitch_and_yaw(rotation: np.ndarray) -> np.ndarray:
    """World axes (…, 2, 3) about which a foot pitches and yaws: horizontal leftward, vertical."""
    along = rotation[..., :2, 0] / np.linalg.norm(rotation[..., :2, 0], axis=-1, keepdims=True)
    axes = np.zeros((*rotation.shape[:-2], 2, 3))
    axes[..., 0, 0], axes[..., 0, 1] = -along[..., 1], along[..., 0]
    axes[..., 1, 2] = 1.0
    return axes


def feedback(
    task: TaskConfig, error: np.ndarray, rate: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Desired accelerations of errors (n, r) and their rates, and the weights (r,)."""
    return task.kp * error + task.kd * rate, np.array(task.weight)


def point_velocity(jacobian: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """Velocities (n, r) of tasks with Jacobians (n, r, 18)."""
    return (jacobian @ qvel[:, :, None])[..., 0]


def wrapped(angle: np.ndarray) -> np.ndarray:
    """Angles within ±π."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
