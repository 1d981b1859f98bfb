"""Steps by virtual constraints: phase, re-anchoring at touchdown, foot placement and torques."""

import numpy as np

from slider.config.control import HzdControlConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import EnforcedGaits, EnforcedSteps, at_phase
from slider.control.hzd.motion import (
    ControlledCoordinates,
    com_state,
    controlled_coordinates,
    hip,
    side_of,
    terrain_motion,
)
from slider.control.whole_body.controller import PlantModel, Stepping, WalkingController
from slider.control.whole_body.memory import WALK, Memory, Orbit
from slider.control.whole_body.model import Dynamics
from slider.control.whole_body.observer import Observer
from slider.control.whole_body.references import ReferenceVelocity
from slider.control.whole_body.tasks import Solved, Task
from slider.core.arrays import consecutive, scatter, take
from slider.env.phase import standing
from slider.gait.outputs import ANKLE, SWING, YAW, driven_signs, output_matrix
from slider.hzd.constraints import Orders, phase_of, phase_rate
from slider.robot.kinematics import leg_extension_jacobian, turn_to_heading
from slider.robot.names import LAST_JOINTS, NUM_JOINTS

_NOT_ZERO = 1e-9  # share of a yaw rate that is about to grow


def hzd_controller(
    robot: RobotConfig,
    config: HzdControlConfig,
    gaits: EnforcedGaits,
    period: float,
    observer: Observer | None = None,
) -> WalkingController:
    """Virtual constraints on a nominal robot, with ticks of ``period`` [s]."""
    plant = PlantModel(robot, config, config.descent, period)
    return WalkingController(plant, HzdSteps(robot, config, gaits, plant), observer)


class HzdSteps(Stepping):
    """Steps of N robots along gaits, for a nominal robot."""

    def __init__(
        self,
        robot: RobotConfig,
        config: HzdControlConfig,
        gaits: EnforcedGaits,
        plant: PlantModel,
    ) -> None:
        self._config, self._constraints = config, gaits.constraints
        self._gaits = gaits
        still = np.zeros((1, NUM_JOINTS))
        legs = [leg_extension_jacobian(robot.geometry, still, leg)[0] for leg in range(2)]
        self._extension = np.array(legs)  # of the stance leg, of the swing leg in the reflection
        self._level = 1.0 / robot.geometry.ankle_direction[1]
        self._signs = driven_signs(robot.geometry)
        self._body, self._period = plant.body, plant.period
        self._velocity = ReferenceVelocity(config.velocity, plant.period)
        self._matrix = output_matrix(robot.geometry)
        w = config.weights
        self._weights = np.array(
            [*w.torso, w.stance_slide, w.stance_ankle, *w.swing_leg, w.swing_slide, w.swing_foot]
        )

    def reset(self, count: int) -> None:
        """Forget the steps of ``count`` robots."""
        self._walk = self._gaits.at(np.zeros((count, 3)), np.zeros(count, dtype=int))

    def set_velocity(self, memory: Memory, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from now on; the yaw rate of a walk ramps to it."""
        reference, target, rate = velocity.copy(), velocity[:, 2], memory.velocity[:, 2]
        walks = (memory.mode == WALK) & ~standing(velocity)
        reference[walks, 2] = np.where(rate == 0.0, _NOT_ZERO * target, rate)[walks]
        memory.target_yaw_rate = target.copy()
        self._velocity.change(memory, reference)

    def orbit(self, velocity: np.ndarray, stance: np.ndarray) -> Orbit:
        """Lateral orbits of first steps, stance feet ``stance`` (n,), towards velocities (n, 3)."""
        first = self._config.velocity.acceleration * self._config.ahead
        size = np.linalg.norm(velocity[:, :2], axis=1)
        slow = velocity.copy()
        slow[:, :2] *= np.minimum(1.0, first / np.maximum(size, 1e-9))[:, None]
        walk = self._gaits.at(slow, stance)
        return Orbit(-walk.orbit[:, -1, 0], walk.duration)

    def begin(
        self, memory: Memory, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray
    ) -> None:
        """Begin a step, stance feet ``stance`` (n,): its gait, constraints through the state."""
        if not len(robots):
            return
        memory.stance[robots], memory.elapsed[robots] = stance, 0.0
        memory.steps[robots] += 1
        # Anti-windup: the integral action pauses where the velocity of the next gait is bounded.
        before = memory.correction[robots]
        self._velocity.correct(memory, robots, dynamics.com[:, :2])
        planned = self._velocity.planned(memory, robots, self._config.ahead)
        velocity = self._reachable(memory, robots, planned)
        integrates = velocity == planned
        memory.correction[robots] = np.where(integrates, memory.correction[robots], before)
        yaw_rate = memory.yaw_rate(robots)[:, None]
        walk = self._gaits.at(np.concatenate([velocity, yaw_rate], axis=1), stance)
        memory.duration[robots] = walk.duration
        walk.line = memory.heading[robots] + side_of(stance) * walk.turn / 2
        place, speed = hip(dynamics, stance, walk.line)
        # The hip gives the phase if its position and velocity are near those of the gait's start.
        start, pace = self._config.hip_start, self._config.hip_rate
        phase = phase_of(walk.hip, place)
        rate = phase_rate(walk.hip, phase, speed) * walk.duration
        walk.by_hip &= (phase >= start.lower) & (phase <= start.upper)
        walk.by_hip &= (rate >= pace.lower) & (rate <= pace.upper)
        self._synchronise(walk, phase, speed, np.ones(len(robots)))
        # Relative to the next foothold, the gait's centre of mass is where the step began.
        rows, feet = np.arange(len(robots)), dynamics.foot_positions[:, :, :2]
        first, last = walk.orbit[:, 0], walk.orbit[:, -1]
        sideways = side_of(stance) * (first + last)[:, 0]
        stride = np.stack([(last - first)[:, 3], sideways], axis=1)
        here, before = feet[rows, stance], feet[rows, 1 - stance]
        walk.footholds = np.stack([here, before, here + memory.to_world(stride, robots)], axis=1)
        ground = self._ground(walk, memory, robots)
        now = self._motion(walk, memory, robots, dynamics, ground)
        walk.constraints.re_anchor(walk.phase, now.x, now.rate / walk.rate[:, None])
        scatter(self._walk, robots, walk)

    def end(self, memory: Memory, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Whether the steps are over (n,); ``contact`` (n,) is that of the swing feet."""
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
        ground = self._ground(walk, memory, robots)
        now = self._motion(walk, memory, robots, dynamics, ground)
        feet, gains = memory.stance[robots, None], (self._constraints.kp, self._constraints.kd)
        tasks = [
            self._outputs(walk, now, ground),
            self._body.stance(dynamics, feet, np.zeros(feet.shape)),
            *self._body.level(dynamics, 1 - feet[:, 0], gains, self._config.weights.swing_foot),
        ]
        idle = None
        if self._body.has_soles:  # as in gaits, the leg rolls freely on its foot
            idle = np.arange(NUM_JOINTS) == np.array(LAST_JOINTS)[feet]
        loaded = np.ones(feet.shape, dtype=bool)
        solved = self._body.solve(dynamics, tasks, feet, loaded, idle)
        # Yaw rates ramp to the commanded ones, skipping zero, which could mean standing.
        yaw_rate, target = memory.velocity[robots, 2], memory.target_yaw_rate[robots]
        most = self._config.yaw_acceleration * self._period
        grown = yaw_rate + np.clip(target - yaw_rate, -most, most)
        memory.velocity[robots, 2] = np.where(grown == 0.0, _NOT_ZERO * target, grown)
        memory.elapsed[robots] += self._period
        memory.walked[robots] += self._period
        walk.phase = walk.phase + np.where(walk.by_hip, 0.0, self._period * walk.rate)
        self._walk.phase[robots], self._walk.rate[robots] = walk.phase, walk.rate
        self._walk.constraints.displacement[robots] = walk.constraints.displacement
        return solved

    def _ground(self, walk: EnforcedSteps, memory: Memory, robots: np.ndarray) -> Orders:
        """Change of coordinates by the ground under the footholds, the next one displaced."""
        moved, footholds = walk.constraints.displacement.copy(), walk.footholds.copy()
        moved[:, 1] *= side_of(memory.stance[robots])
        footholds[:, 2] += memory.to_world(moved, robots)
        return terrain_motion(memory, robots, footholds, walk.phase, self._extension, self._level)

    def _reachable(self, memory: Memory, robots: np.ndarray, planned: np.ndarray) -> np.ndarray:
        """Nearest velocity (n, 2) within ``change`` of the last step's and below ``fastest``."""
        moved = memory.starts[robots, 1] - memory.starts[robots, 0]
        halfway = memory.heading[robots] - 0.5 * memory.yaw_rate(robots) * moved[:, 2]
        last = turn_to_heading(moved[:, :2], halfway) / np.maximum(moved[:, 2:], self._period)
        first = memory.steps[robots] < 2
        last[first] = memory.previous[robots[first]]
        change = self._config.change
        faster = (planned * last >= 0) & (np.abs(planned) > np.abs(last))
        bound = np.where(faster, change.faster, change.slower)
        velocity = np.clip(planned, last - bound, last + bound)
        velocity[:, 0] = np.minimum(velocity[:, 0], self._config.fastest)
        return velocity

    def _synchronise(
        self, walk: EnforcedSteps, phase: np.ndarray, velocity: np.ndarray, growth: np.ndarray
    ) -> None:
        """Set phase and phase rate, from ``phase`` and hip where the hip gives the phase.

        The phase grows by ``growth`` (n,) at most; the hip has a ``velocity`` (n,) [m/s].
        """
        phase = np.clip(phase, walk.phase, walk.phase + growth)
        pace, bounds = 1.0 / walk.duration, self._config.hip_rate
        rate = phase_rate(walk.hip, phase, velocity)
        rate = np.clip(rate, bounds.lower * pace, bounds.upper * pace)
        walk.phase = np.where(walk.by_hip, phase, walk.phase)
        walk.rate = np.where(walk.by_hip, rate, pace)

    def _motion(
        self,
        walk: EnforcedSteps,
        memory: Memory,
        robots: np.ndarray,
        dynamics: Dynamics,
        ground: Orders,
    ) -> ControlledCoordinates:
        """Coordinates as on level ground, with yaw relative to the stance foot's in the gait."""
        stance, heading = memory.stance[robots], memory.heading[robots]
        result = controlled_coordinates(
            dynamics, stance, heading, memory.yaw_rate(robots), self._signs, self._body.has_soles
        )
        result.x[:, YAW] += walk.turn * (walk.phase - 0.5)
        result.rate[:, YAW] += walk.turn * walk.rate
        result.x[:] -= ground[0]
        result.rate[:] -= ground[1] * walk.rate[:, None]
        return result

    def _outputs(self, walk: EnforcedSteps, now: ControlledCoordinates, ground: Orders) -> Task:
        """Task ÿ = −kp y − kd ẏ; if the hip gives the phase, the ankle controls its rate instead.

        Then s̈ = (∇p q̈ − p″ ṡ²)/p′ is the robot's own: the other nine outputs do not depend on the
        ankle torque that the foot's length allows. The Jacobian of ``now`` is overwritten.
        """
        config, rate, by_hip = self._constraints, walk.rate[:, None], walk.by_hip
        value, slope, curve = walk.constraints.desired(walk.phase)
        late = np.maximum(walk.phase - 1.0, 0.0)
        sinking = self._config.descent * walk.duration * (late > 0)
        value[:, SWING:] += (sinking * late)[:, None] * self._extension[1]
        slope[:, SWING:] += sinking[:, None] * self._extension[1]
        error, error_rate = value - now.x, slope * rate - now.rate
        desired = (curve + ground[2]) * rate**2 + config.kp * error + config.kd * error_rate
        _, advance, bend = (order[:, 0] for order in walk.hip.at(walk.phase))
        bend *= walk.rate**2
        slope += ground[1]
        slope[:, YAW] -= walk.turn
        slope *= np.where(by_hip, 1.0 / np.where(by_hip, advance, 1.0), 0.0)[:, None]
        ahead = np.stack([np.cos(walk.line), np.sin(walk.line)], axis=1)
        now.jacobian[:, :, :2] -= slope[:, :, None] * ahead[:, None]
        jacobian = self._matrix @ now.jacobian
        desired = (desired - slope * bend[:, None]) @ self._matrix.T
        turn = -config.rate_gain * (walk.rate - 1.0 / walk.duration)
        jacobian[by_hip, ANKLE] = 0.0
        jacobian[by_hip, ANKLE, :2] = ahead[by_hip]
        desired[by_hip, ANKLE] = (advance * turn + bend)[by_hip]
        return jacobian, desired, self._weights

    def _place(
        self, walk: EnforcedSteps, memory: Memory, robots: np.ndarray, dynamics: Dynamics
    ) -> None:
        """Update the phase, and the foothold by state feedback b = −K(s) (ξ − ξ*(s))."""
        place, speed = hip(dynamics, memory.stance[robots], walk.line)
        growth = self._period * self._config.hip_rate.upper / walk.duration
        self._synchronise(walk, phase_of(walk.hip, place), speed, growth)
        error = com_state(dynamics, memory.stance[robots]) - at_phase(walk.orbit, walk.phase)
        gains = at_phase(walk.gains, walk.phase, walk.by_hip.astype(int))
        target = -(gains @ error[:, :, None])[:, :, 0]
        target = np.clip(target, -self._gaits.reach, self._gaits.reach)
        config = self._config
        share = np.where(walk.phase < config.lock, min(1.0, self._period / config.settling), 0)
        walk.constraints.displacement += share[:, None] * (target - walk.constraints.displacement)
