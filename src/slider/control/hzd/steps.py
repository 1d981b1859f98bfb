"""Steps by virtual constraints: phase, re-anchoring at touchdown, foot placement and torques."""

from dataclasses import dataclass

import numpy as np

from slider.config.control import HzdConfig
from slider.control.hzd.gaits import GaitTables, Steps
from slider.control.whole_body.controller import Surroundings
from slider.control.whole_body.memory import Memory
from slider.control.whole_body.nominal import Dynamics
from slider.control.whole_body.tasks import Part, Solved, pitch_and_yaw, point_velocity, wrapped
from slider.control.whole_body.velocity import ReferenceVelocity
from slider.hzd.rows import put, take
from slider.hzd.constraints import StepConstraints
from slider.hzd.outputs import NUM_JOINTS, SWING, YAW, output_matrix, stance_first, stance_selection
from slider.hzd.phase import phase_of, phase_rate
from slider.robot.kinematics import yaw_of
from slider.robot.knee_map import KneeLengths
from slider.robot.names import ACTUATED

_DRIVEN = np.array(ACTUATED)
_RATES = (0.5, 1.6)  # of the phase, as a share of the gait's; beyond them a stumble is no phase
_JUMP = 0.02  # the phase differs from the one expected by no more, per tick
LEAST = 0.6
SLIDE = 3  # place of the slide in a leg


@dataclass(frozen=True)
class Motion:
    """Coordinates of n robots in stance: roll, yaw and driven joints, stance leg first.

    Attributes:
        x, rate: (n, 12).
        jacobian: (n, 12, 18), ẍ = jacobian q̈ up to what q̇ adds.
    """

    x: np.ndarray
    rate: np.ndarray
    jacobian: np.ndarray


@dataclass
class Walk:
    """Steps that N robots are making.

    Attributes:
        constraints: what they hold.
        steps: of the gaits.
        phase, rate: of the steps [1], [1/s].
        by_hip: whether the hip's place tells the phase.
    """

    constraints: StepConstraints
    steps: Steps
    phase: np.ndarray
    rate: np.ndarray
    by_hip: np.ndarray


class HzdSteps:
    """Steps of N robots.

    Args:
        config: of the controller.
        gaits: of the library.
        lengths: of the virtual leg.
        around: the robot.
    """

    def __init__(
        self, config: HzdConfig, gaits: GaitTables, lengths: KneeLengths, around: Surroundings
    ) -> None:
        self._config, self._gaits, self._lengths = config, gaits, lengths
        self._body, self._period, self._omega = around.body, around.period, around.omega
        self._velocity = ReferenceVelocity(config.velocity, around.period)
        self._matrix = output_matrix(config.outputs)
        w = config.weights
        self._weights = np.array(
            [*w.torso, w.stance_slide, w.stance_ankle, *w.swing_leg, w.swing_slide, w.swing_foot]
        )

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""
        self._walk = self._new(np.zeros((count, 2)), np.zeros(count, dtype=int))

    def command(self, memory: Memory, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on."""
        self._velocity.change(memory, velocity)

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """A new step on the feet ``stance`` (n,): its gait, and constraints through this state."""
        if not len(robots):
            return
        memory.stance[robots], memory.elapsed[robots] = stance, 0.0
        memory.steps[robots] += 1
        self._velocity.correct(memory, robots, dynamics.com[:, :2])
        walk = self._new(self._reachable(memory, robots), stance)
        memory.duration[robots] = walk.steps.duration
        motion = self._motion(memory, robots, dynamics)
        place, speed = self._hip(memory, robots, dynamics)
        walk.by_hip &= phase_rate(walk.steps.hip, phase_of(walk.steps.hip, place), speed) * (
            walk.steps.duration
        ) >= LEAST
        self._synchronise(walk, place, speed)
        walk.constraints.re_anchor(walk.phase, motion.x, motion.rate / walk.rate[:, None])
        put(self._walk, robots, walk)

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        phase, step = self._walk.phase[robots], self._config.step
        duration = memory.duration[robots]
        late = (phase - 1.0) * duration > step.late
        stuck = memory.elapsed[robots] > duration / _RATES[0]
        return (contact & (phase > step.early)) | late | stuck

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques that enforce the virtual constraints, as far as motors and contact allow."""
        walk = take(self._walk, robots)
        motion = self._motion(memory, robots, dynamics)
        self._place(walk, memory, robots, dynamics)
        parts = [
            self._outputs(walk, motion),
            self._body.tasks.stance(
                dynamics, memory.stance[robots, None], np.zeros((len(robots), 1))
            ),
        ]
        feet = memory.stance[robots, None]
        solved = self._body.solve(dynamics, parts, feet, np.ones(feet.shape, dtype=bool))
        memory.elapsed[robots] += self._period
        memory.walked[robots] += self._period
        walk.phase += np.where(walk.by_hip, 0.0, self._period * walk.rate)
        put(self._walk, robots, walk)
        return solved

    def _new(self, velocity: np.ndarray, stance: np.ndarray) -> Walk:
        config, steps = self._config, self._gaits.at(velocity, stance)
        constraints = StepConstraints(
            steps.coefficients,
            steps.roll,
            steps.placement,
            self._lengths,
            config.correction_end,
            config.placement,
        )
        by_hip = (np.abs(velocity[:, 0]) >= config.slowest) & (config.phase == "hip")
        return Walk(constraints, steps, np.zeros(len(stance)), 1.0 / steps.duration, by_hip)

    def _reachable(self, memory: Memory, robots: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) of the next gait: not far from that of the step before."""
        wanted = self._velocity.of(memory, robots, self._config.ahead)
        gone = memory.starts[robots, 1] - memory.starts[robots, 0]
        last = memory.to_heading(gone[:, :2], robots) / np.maximum(gone[:, 2:], self._period)
        last[memory.steps[robots] < 2] = 0.0
        change = self._config.change
        faster = (wanted * last >= 0) & (np.abs(wanted) > np.abs(last))
        bound = np.where(faster, change.faster, change.slower)
        return np.clip(wanted, last - bound, last + bound)

    def _hip(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics
    ) -> tuple[np.ndarray, np.ndarray]:
        """Forward place of the base over the stance foot (n,) [m] and velocity [m/s]."""
        sole = dynamics.foot_positions[np.arange(len(robots)), memory.stance[robots], :2]
        place = memory.to_heading(dynamics.base_position[:, :2] - sole, robots)[:, 0]
        return place, memory.to_heading(dynamics.qvel[:, :2], robots)[:, 0]

    def _synchronise(
        self, walk: Walk, place: np.ndarray, velocity: np.ndarray, reach: float = 1.0
    ) -> None:
        """Phase and its rate of those that go by the hip; it changes by no more than ``reach``."""
        phase = phase_of(walk.steps.hip, place)
        phase = np.clip(phase, walk.phase, walk.phase + reach)
        pace = 1.0 / walk.steps.duration
        rate = np.clip(phase_rate(walk.steps.hip, phase, velocity), *np.outer(_RATES, pace))
        walk.phase = np.where(walk.by_hip, phase, walk.phase)
        walk.rate = np.where(walk.by_hip, rate, pace)

    def _motion(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Motion:
        rows, stance = np.arange(len(robots)), memory.stance[robots]
        right, side = stance == 1, np.where(stance == 1, -1.0, 1.0)
        rotation = dynamics.foot_rotations[rows, stance]
        angular = dynamics.foot_jacobians[rows, stance, 3:]
        axes = np.stack([rotation[:, :, 0], pitch_and_yaw(rotation)[:, 1]], axis=1)
        jacobian = np.concatenate(
            [side[:, None, None] * (axes @ angular), _joint_rows(right)], axis=1
        )
        roll = side * np.arcsin(np.clip(rotation[:, 2, 1], -1.0, 1.0))
        yaw = side * wrapped(yaw_of(rotation) - memory.heading[robots])
        joints = stance_first(dynamics.joints[:, _DRIVEN], right)
        rate = point_velocity(jacobian, dynamics.qvel)
        rate[:, YAW] -= side * memory.yaw_rate(robots)
        return Motion(np.concatenate([roll[:, None], yaw[:, None], joints], axis=1), rate, jacobian)

    def _outputs(self, walk: Walk, motion: Motion) -> Part:
        """ÿ = −kp y − kd ẏ, with the phase on its way to the gait's pace."""
        config, rate = self._config, walk.rate[:, None]
        value, slope, curve = walk.constraints.desired(walk.phase)
        late = np.maximum(walk.phase - 1.0, 0.0)
        sinking = config.descent * walk.steps.duration * (late > 0)
        value[:, SWING + SLIDE] += sinking * late
        slope[:, SWING + SLIDE] += sinking
        pace = np.where(walk.by_hip, -config.rate_gain, 0.0) * (
            walk.rate - 1.0 / walk.steps.duration
        )
        wanted = curve * rate**2 + slope * pace[:, None]
        error, error_rate = value - motion.x, slope * rate - motion.rate
        desired = wanted + config.kp * error + config.kd * error_rate
        return self._matrix @ motion.jacobian, desired @ self._matrix.T, self._weights

    def _place(self, walk: Walk, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Phase now, and the foothold that the error of the centre of mass asks for."""
        self._synchronise(walk, *self._hip(memory, robots, dynamics), _JUMP)
        stance = memory.stance[robots]
        side = np.stack([np.ones(len(robots)), np.where(stance == 1, -1.0, 1.0)], axis=1)
        sole = dynamics.foot_positions[np.arange(len(robots)), stance, :2]
        place = side * memory.to_heading(dynamics.com[:, :2] - sole, robots)
        speed = side * memory.to_heading(dynamics.com_velocity[:, :2], robots)
        desired, slope, _ = walk.steps.com.at(walk.phase)
        feedback, duration = self._config.feedback, walk.steps.duration[:, None]
        left = self._omega * np.maximum(1.0 - walk.phase, 0.0)[:, None] * duration
        error = np.sinh(left) * (place - desired)
        error += np.cosh(left) * (speed - slope / duration) / self._omega
        forward = np.where(walk.by_hip, feedback.forward, feedback.forward_time)
        gains = np.stack([forward, np.full(len(forward), feedback.lateral)], axis=1)
        wanted = gains * error
        wanted = np.clip(wanted, -feedback.reach, feedback.reach)
        share = np.where(walk.phase < feedback.lock, min(1.0, self._period / feedback.settling), 0)
        walk.constraints.displacement += share[:, None] * (wanted - walk.constraints.displacement)


def _joint_rows(right: np.ndarray) -> np.ndarray:
    """Rows (n, 10, 18) of the driven joints, stance leg first."""
    return np.concatenate([np.zeros((len(right), NUM_JOINTS, 6)), stance_selection(right)], axis=2)
