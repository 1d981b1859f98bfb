"""Steps of the MPC baseline: start, end, footholds, swing foot and torques in single support.

References of the swing foot are quintics, replanned at every tick from the current reference.
Horizontally they come to rest at the planned foothold; vertically they reach the apex at half of
the step time, then the ground with a touchdown velocity. After the step time the foot sinks on.
"""

import numpy as np

from slider.config.control import MpcConfig, SwingConfig
from slider.config.robot import RobotConfig
from slider.control.footsteps import FootstepPlanner, Pendulum
from slider.control.whole_body.controller import PlantModel, Stepping, WalkingController
from slider.control.whole_body.memory import LEFT, Memory, Orbit
from slider.control.whole_body.model import Dynamics
from slider.control.whole_body.observer import Observer
from slider.control.whole_body.references import ReferenceVelocity, quintic
from slider.control.whole_body.tasks import (
    Solved,
    Task,
    feedback,
    pitch_and_yaw,
    point_velocity,
    wrapped,
)
from slider.robot.kinematics import yaw_of


def mpc_controller(
    robot: RobotConfig, config: MpcConfig, period: float, observer: Observer | None = None
) -> WalkingController:
    """The baseline for a nominal robot, with ticks of ``period`` [s]."""
    plant = PlantModel(robot, config, config.swing.search_velocity, period)
    return WalkingController(plant, MpcSteps(config, plant), observer)


class MpcSteps(Stepping):
    """Plans and advances steps on a nominal robot."""

    def __init__(self, config: MpcConfig, plant: PlantModel) -> None:
        self._config, self._period = config, plant.period
        self._velocity = ReferenceVelocity(config.velocity, plant.period)
        self._planner = FootstepPlanner(config.step, config.planner, plant.omega)
        self._omega, self._body = plant.omega, plant.body
        self._ticks_per_plan = max(1, round(config.planner.period / plant.period))

    def set_velocity(self, memory: Memory, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from now on."""
        self._velocity.change(memory, velocity)

    def orbit(self, velocity: np.ndarray, stance: np.ndarray) -> Orbit:
        """Lateral orbits of first steps, stance feet ``stance`` (n,), towards velocities (n, 3)."""
        end = np.full(len(velocity), self._config.step.width / 2)
        return Orbit(end, self._planner.nominal_time(np.zeros_like(velocity)))

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """Begin a new step with stance feet ``stance`` (n,)."""
        if not len(robots):
            return
        memory.stance[robots] = stance
        memory.elapsed[robots] = 0.0
        start = dynamics.foot_positions[np.arange(len(robots)), 1 - stance]
        memory.swing[robots] = swing_at_rest(start)
        memory.steps[robots] += 1
        self._velocity.correct(memory, robots, dynamics.com[:, :2])
        planned = self._velocity.planned(memory, robots)
        memory.duration[robots] = self._planner.nominal_time(planned)
        self._plan(memory, robots, dynamics, np.arange(len(robots)))

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,); ``contact`` (n,) is that of the swing feet."""
        step, elapsed = self._config.step, memory.elapsed[robots] + 1e-9
        duration = memory.duration[robots]
        if step.switching == "time":
            return elapsed >= duration
        return (contact & (elapsed > step.early * duration)) | (elapsed > duration + step.late)

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """The pendulum falls freely over the stance foot; the swing foot tracks its reference."""
        config, stance = self._config, memory.stance[robots]
        if memory.tick % self._ticks_per_plan == 0:
            left = memory.duration[robots] - memory.elapsed[robots]
            due = np.flatnonzero(left > config.planner.lock)
            self._plan(memory, robots[due], dynamics, due)
        support = dynamics.foot_positions[np.arange(len(robots)), stance]
        ground = support[:, 2] + memory.rise(robots, support[:, :2], memory.foothold[robots])
        memory.swing[robots] = advance_swing(
            memory.swing[robots],
            memory.foothold[robots],
            memory.elapsed[robots],
            memory.duration[robots],
            ground + config.swing.compression,
            np.maximum(support[:, 2], ground) + config.swing.compression + config.step.apex,
            config.swing,
            self._period,
        )
        memory.elapsed[robots] += self._period
        memory.walked[robots] += self._period
        flat = self._omega**2 * (dynamics.com - support)[:, :2]
        weight = np.array(config.whole_body.com.weight)
        foot, yaw_rate = 1 - stance, memory.yaw_rate(robots)
        heading = memory.heading[robots] + 0.5 * yaw_rate * memory.duration[robots]
        feet = stance[:, None]
        # The pendulum moves parallel to the plane of the ground under its foot.
        slope = memory.slope(robots, support[:, :2])
        height = support[:, 2] + (slope * (dynamics.com - support)[:, :2]).sum(axis=1)
        climb = (slope * dynamics.com_velocity[:, :2]).sum(axis=1)
        slope = memory.to_heading(memory.slope(robots, memory.foothold[robots]), robots)[:, 0]
        tasks = [
            *self._body.body(memory, robots, dynamics, flat, height, weight, climb),
            *self._swing(dynamics, foot, memory.swing[robots], heading, yaw_rate, np.arctan(slope)),
            self._body.stance(dynamics, feet, np.zeros(feet.shape)),
        ]
        return self._body.solve(dynamics, tasks, feet, np.ones(feet.shape, dtype=bool))

    def _plan(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, rows: np.ndarray
    ) -> None:
        """Plan foothold and duration of the steps of ``robots`` from ``rows`` of ``dynamics``."""
        if not len(robots):
            return
        stance = memory.stance[robots]
        foot = dynamics.foot_positions[rows, stance, :2]
        pendulum = Pendulum(
            position=memory.to_heading(dynamics.com[rows, :2] - foot, robots),
            velocity=memory.to_heading(dynamics.com_velocity[rows, :2], robots),
            swing_sign=np.where(stance == LEFT, -1.0, 1.0),
            elapsed=memory.elapsed[robots],
            duration=memory.duration[robots],
            reference_velocity=self._velocity.planned(memory, robots),
        )
        plan = self._planner.plan(pendulum)
        memory.foothold[robots] = foot + memory.to_world(plan.step, robots)
        memory.duration[robots] = plan.duration

    def _swing(
        self,
        dynamics: Dynamics,
        foot: np.ndarray,
        reference: np.ndarray,
        heading: np.ndarray,
        yaw_rate: np.ndarray,
        slope: np.ndarray,
    ) -> list[Task]:
        """Swing foot (n,) tracks ``reference`` (n, 3, 3): axis; position, velocity, acceleration.

        It points along ``heading`` and ``slope`` (n,) [rad]. A line may roll, a sole stays level.
        """
        robots, tasks = np.arange(len(foot)), self._config.whole_body
        place = dynamics.foot_jacobians[robots, foot, :3]
        error = reference[:, :, 0] - dynamics.foot_positions[robots, foot]
        rate = reference[:, :, 1] - point_velocity(place, dynamics.qvel)
        desired, weight = feedback(tasks.swing, error, rate)
        bias = dynamics.foot_bias[robots, foot, :3]
        follow = place, desired + reference[:, :, 2] - bias, weight
        rotation = dynamics.foot_rotations[robots, foot]
        axes = pitch_and_yaw(rotation)
        turn = axes @ dynamics.foot_jacobians[robots, foot, 3:]
        bias = (axes @ dynamics.foot_bias[robots, foot, 3:, None])[..., 0]
        error = np.stack(
            [np.arcsin(rotation[:, 2, 0]) - slope, wrapped(heading - yaw_of(rotation))], axis=1
        )
        rate = -point_velocity(turn, dynamics.qvel)
        rate[:, 1] += yaw_rate
        desired, weight = feedback(tasks.swing_rotation, error, rate)
        followed = [follow, (turn, desired - bias, weight[1:])]
        gains = tasks.swing_rotation.kp, tasks.swing_rotation.kd
        return followed + self._body.level(dynamics, foot, gains, weight[1])


def swing_at_rest(position: np.ndarray) -> np.ndarray:
    """Reference (n, 3, 3) at rest at ``position`` (n, 3) [m]."""
    reference = np.zeros((*position.shape, 3))
    reference[:, :, 0] = position
    return reference


def advance_swing(
    reference: np.ndarray,
    target: np.ndarray,
    elapsed: np.ndarray,
    duration: np.ndarray,
    ground: np.ndarray,
    apex: np.ndarray,
    config: SwingConfig,
    period: float,
) -> np.ndarray:
    """Reference one tick later.

    Args:
        reference: (n, 3, 3) coordinate; position, velocity, acceleration.
        target: foothold (n, 2) [m].
        elapsed, duration: of the step (n,) [s].
        ground: height of the sole at touchdown (n,) [m].
        apex: largest height of the sole (n,) [m].
        period: of a tick [s].
    """
    result = np.empty_like(reference)
    left = duration - elapsed
    time = np.maximum(left, 2 * period)
    goal = np.zeros((len(target), 2, 3))
    goal[:, :, 0] = target
    result[:, :2] = quintic(reference[:, :2], goal, time[:, None], period)
    rising = elapsed < duration / 2 - 2 * period
    height = np.zeros((len(target), 3))
    height[:, 0] = np.where(rising, apex, ground)
    height[:, 1] = np.where(rising, 0.0, -config.touchdown_velocity)
    time = np.where(rising, np.maximum(duration / 2 - elapsed, 2 * period), time)
    result[:, 2] = quintic(reference[:, 2], height, time, period)
    late = left < period / 2
    result[late] = swing_at_rest(reference[late, :, 0])
    result[late, 2, 0] -= config.search_velocity * period
    result[late, 2, 1] = -config.search_velocity
    return result
