"""Steps by virtual constraints: phase, re-anchoring at touchdown, foot placement and torques."""

from dataclasses import dataclass

import numpy as np

from slider.config.control import HzdControlConfig
from slider.config.hzd import VirtualConstraintsConfig
from slider.control.hzd.gaits import GaitTables, Steps, at_phase
from slider.control.hzd.motion import Motion, hip, motion, section, side_of
from slider.control.rows import consecutive, put, take
from slider.control.whole_body.controller import Surroundings
from slider.control.whole_body.memory import WALK, Memory
from slider.control.whole_body.nominal import Dynamics
from slider.control.whole_body.tasks import Part, Solved
from slider.control.whole_body.velocity import ReferenceVelocity
from slider.env.phase import standing
from slider.gait.outputs import ANKLE, SWING, YAW, output_matrix
from slider.hzd.constraints import StepConstraints, phase_of, phase_rate
from slider.robot.kinematics import turn_to_heading
from slider.robot.knee_map import KneeLengths

_NOT_ZERO = 1e-9  # share of a yaw rate that is about to grow
SLIDE = 3  # place of the slide in a leg


@dataclass
class Walk:
    """Steps that N robots are making.

    Attributes:
        constraints: what they hold.
        steps: of the gaits.
        phase, rate: of the steps [1], [1/s].
        by_hip: whether the hip's place tells the phase.
        line: yaw at which the gait has the stance foot's line (N,) [rad].
    """

    constraints: StepConstraints
    steps: Steps
    phase: np.ndarray
    rate: np.ndarray
    by_hip: np.ndarray
    line: np.ndarray


class HzdSteps:
    """Steps of N robots.

    Args:
        config: of the controller.
        constraints: what is enforced.
        reach: largest displacement of a foothold [m].
        gaits: of the library.
        lengths: of the virtual leg.
        around: the robot.
    """

    def __init__(
        self,
        config: HzdControlConfig,
        constraints: VirtualConstraintsConfig,
        reach: float,
        gaits: GaitTables,
        lengths: KneeLengths,
        around: Surroundings,
    ) -> None:
        self._config, self._constraints, self._reach = config, constraints, reach
        self._gaits, self._lengths = gaits, lengths
        self._body, self._period = around.body, around.period
        self._velocity = ReferenceVelocity(config.velocity, around.period)
        self._matrix = output_matrix(constraints.outputs)
        w = config.weights
        self._weights = np.array(
            [*w.torso, w.stance_slide, w.stance_ankle, *w.swing_leg, w.swing_slide, w.swing_foot]
        )

    @property
    def phase(self) -> np.ndarray:
        """Of the present steps (N,); a foot that is late goes beyond 1."""
        return self._walk.phase

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""
        self._walk = self._new(np.zeros((count, 3)), np.zeros(count, dtype=int))

    def command(self, memory: Memory, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on; the yaw rate of a walk grows to it."""
        reference, wanted, rate = velocity.copy(), velocity[:, 2], memory.command[:, 2]
        walks = (memory.mode == WALK) & ~standing(velocity)
        reference[walks, 2] = np.where(rate == 0.0, _NOT_ZERO * wanted, rate)[walks]
        memory.yaw_command = wanted.copy()
        self._velocity.change(memory, reference)

    def _turn(self, memory: Memory, robots: np.ndarray) -> None:
        """Let yaw rates grow for a tick; on the way none is zero, which could mean to stand."""
        rate, wanted = memory.command[robots, 2], memory.yaw_command[robots]
        most = self._config.yaw_acceleration * self._period
        grown = rate + np.clip(wanted - rate, -most, most)
        memory.command[robots, 2] = np.where(grown == 0.0, _NOT_ZERO * wanted, grown)

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """A new step on the feet ``stance`` (n,): its gait, and constraints through this state."""
        if not len(robots):
            return
        memory.stance[robots], memory.elapsed[robots] = stance, 0.0
        memory.steps[robots] += 1
        velocity = self._next_velocity(memory, robots, dynamics)
        yaw_rate = memory.yaw_rate(robots)[:, None]
        walk = self._new(np.concatenate([velocity, yaw_rate], axis=1), stance)
        memory.duration[robots] = walk.steps.duration
        walk.line = memory.heading[robots] + side_of(stance) * walk.steps.turn / 2
        place, speed = hip(dynamics, stance, walk.line)
        walk.by_hip &= self._tells_phase(walk, place, speed)
        self._synchronise(walk, place, speed, np.ones(len(robots)))
        seen = self._motion(walk, memory, robots, dynamics)
        walk.constraints.re_anchor(walk.phase, seen.x, seen.rate / walk.rate[:, None])
        put(self._walk, robots, walk)

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,), where ``contact`` (n,) is that of the swing feet."""
        phase, step, rates = self._walk.phase[robots], self._config.step, self._config.hip_rate
        elapsed, duration = memory.elapsed[robots], memory.duration[robots]
        late = (phase - 1.0) * duration > step.late
        stuck = elapsed > duration / rates.lower
        down = contact & (phase > step.early) & (elapsed > step.early * duration / rates.upper)
        return down | late | stuck

    def torques(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Solved:
        """Torques that enforce the virtual constraints, as far as motors and contact allow."""
        walk = take(self._walk, consecutive(robots))
        self._place(walk, memory, robots, dynamics)
        seen = self._motion(walk, memory, robots, dynamics)
        parts = [
            self._outputs(walk, seen),
            self._body.tasks.stance(
                dynamics, memory.stance[robots, None], np.zeros((len(robots), 1))
            ),
        ]
        feet = memory.stance[robots, None]
        solved = self._body.solve(dynamics, parts, feet, np.ones(feet.shape, dtype=bool))
        self._turn(memory, robots)
        memory.elapsed[robots] += self._period
        memory.walked[robots] += self._period
        walk.phase = walk.phase + np.where(walk.by_hip, 0.0, self._period * walk.rate)
        self._walk.phase[robots], self._walk.rate[robots] = walk.phase, walk.rate
        self._walk.constraints.displacement[robots] = walk.constraints.displacement
        return solved

    def _new(self, command: np.ndarray, stance: np.ndarray) -> Walk:
        config, steps = self._constraints, self._gaits.at(command, stance)
        constraints = StepConstraints(
            steps.coefficients,
            steps.roll,
            steps.placement,
            self._lengths,
            config.correction_end,
            (config.placement.lower, config.placement.upper),
        )
        by_hip = (command[:, 0] >= config.slowest_hip) & (config.phase == "hip")
        phase, line = np.zeros((2, len(stance)))
        return Walk(constraints, steps, phase, 1.0 / steps.duration, by_hip, line)

    def _next_velocity(self, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Velocity (n, 2) of the next gait. Where that is bounded the integral action waits."""
        before = memory.correction[robots]
        self._velocity.correct(memory, robots, dynamics.com[:, :2])
        wanted = self._velocity.of(memory, robots, self._config.ahead)
        found = self._reachable(memory, robots, wanted)
        memory.correction[robots] = np.where(found == wanted, memory.correction[robots], before)
        return found

    def _reachable(self, memory: Memory, robots: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Nearest velocity (n, 2) that is not far from that of the step before, nor too fast."""
        gone = memory.starts[robots, 1] - memory.starts[robots, 0]
        halfway = memory.heading[robots] - 0.5 * memory.yaw_rate(robots) * gone[:, 2]
        last = turn_to_heading(gone[:, :2], halfway) / np.maximum(gone[:, 2:], self._period)
        first = memory.steps[robots] < 2
        last[first] = memory.old[robots[first]]
        change = self._config.change
        faster = (wanted * last >= 0) & (np.abs(wanted) > np.abs(last))
        bound = np.where(faster, change.faster, change.slower)
        found = np.clip(wanted, last - bound, last + bound)
        found[:, 0] = np.minimum(found[:, 0], self._config.fastest)
        return found

    def _tells_phase(self, walk: Walk, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Whether the hip's place (n,) and velocity (n,) are such as the gait has at a start."""
        start, pace = self._config.hip_start, self._config.hip_rate
        phase = phase_of(walk.steps.hip, place)
        rate = phase_rate(walk.steps.hip, phase, speed) * walk.steps.duration
        at_start = (phase >= start.lower) & (phase <= start.upper)
        return at_start & (rate >= pace.lower) & (rate <= pace.upper)

    def _synchronise(
        self, walk: Walk, place: np.ndarray, velocity: np.ndarray, growth: np.ndarray
    ) -> None:
        """Phase and its rate of those that go by the hip; it grows by ``growth`` (n,) at most."""
        phase = phase_of(walk.steps.hip, place)
        phase = np.clip(phase, walk.phase, walk.phase + growth)
        pace, bounds = 1.0 / walk.steps.duration, self._config.hip_rate
        rate = phase_rate(walk.steps.hip, phase, velocity)
        rate = np.clip(rate, bounds.lower * pace, bounds.upper * pace)
        walk.phase = np.where(walk.by_hip, phase, walk.phase)
        walk.rate = np.where(walk.by_hip, rate, pace)

    def _motion(self, walk: Walk, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> Motion:
        """Yaw of the line counts from where the course of the gait has it at this phase."""
        stance, heading = memory.stance[robots], memory.heading[robots]
        found = motion(dynamics, stance, heading, memory.yaw_rate(robots))
        found.x[:, YAW] += walk.steps.turn * (walk.phase - 0.5)
        found.rate[:, YAW] += walk.steps.turn * walk.rate
        return found

    def _outputs(self, walk: Walk, seen: Motion) -> Part:
        """ÿ = −kp y − kd ẏ; by the hip nine of them, and the ankle drives the phase's rate.

        There s̈ = (∇p q̈ − p″ ṡ²)/p′ is what the robot makes of it: the nine do not depend on what
        the foot's length leaves of the ankle.
        """
        config, rate, by_hip = self._constraints, walk.rate[:, None], walk.by_hip
        value, slope, curve = walk.constraints.desired(walk.phase)
        late = np.maximum(walk.phase - 1.0, 0.0)
        sinking = self._config.descent * walk.steps.duration * (late > 0)
        value[:, SWING + SLIDE] += sinking * late
        slope[:, SWING + SLIDE] += sinking
        error, error_rate = value - seen.x, slope * rate - seen.rate
        desired = curve * rate**2 + config.kp * error + config.kd * error_rate
        _, advance, bend = (order[:, 0] for order in walk.steps.hip.at(walk.phase))
        bend *= walk.rate**2
        slope[:, YAW] -= walk.steps.turn
        slope *= np.where(by_hip, 1.0 / np.where(by_hip, advance, 1.0), 0.0)[:, None]
        ahead = np.stack([np.cos(walk.line), np.sin(walk.line)], axis=1)
        jacobian = seen.jacobian.copy()
        jacobian[:, :, :2] -= slope[:, :, None] * ahead[:, None]
        jacobian = self._matrix @ jacobian
        desired = (desired - slope * bend[:, None]) @ self._matrix.T
        turn = -config.rate_gain * (walk.rate - 1.0 / walk.steps.duration)
        jacobian[by_hip, ANKLE] = 0.0
        jacobian[by_hip, ANKLE, :2] = ahead[by_hip]
        desired[by_hip, ANKLE] = (advance * turn + bend)[by_hip]
        return jacobian, desired, self._weights

    def _place(self, walk: Walk, memory: Memory, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Phase now, and the foothold that the state asks for: b = −K(s) (ξ − ξ*(s))."""
        place, speed = hip(dynamics, memory.stance[robots], walk.line)
        growth = self._period * self._config.hip_rate.upper / walk.steps.duration
        self._synchronise(walk, place, speed, growth)
        error = section(dynamics, memory.stance[robots]) - at_phase(walk.steps.orbit, walk.phase)
        gains = at_phase(walk.steps.gains, walk.phase, walk.by_hip.astype(int))
        wanted = -(gains @ error[:, :, None])[:, :, 0]
        wanted = np.clip(wanted, -self._reach, self._reach)
        config = self._config
        share = np.where(walk.phase < config.lock, min(1.0, self._period / config.settling), 0)
        walk.constraints.displacement += share[:, None] * (wanted - walk.constraints.displacement)
