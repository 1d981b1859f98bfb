"""References: the linear inverted pendulum (LIP), quintics, reference velocity and entry.

The pendulum is in closed form, one axis, vectorised: ẍ = ω² (x − p) with the foot p fixed during a
step; Kajita et al., "The 3D linear inverted pendulum mode", IROS 2001. Its states are (…, 2):
position relative to the foot [m] and velocity [m/s].
"""

import numpy as np

from slider.config.control import EntryConfig, VelocityConfig
from slider.control.whole_body.memory import LEFT, RIGHT, Memory, Orbit, Sway
from slider.robot.kinematics import turn_to_heading
from slider.robot.names import GRAVITY


def natural_frequency(height: float) -> float:
    """Natural frequency ω [rad/s] of a pendulum of ``height`` [m]."""
    return float(np.sqrt(GRAVITY / height))


def step_map(omega: float, time: np.ndarray | float) -> np.ndarray:
    """Matrices (…, 2, 2) that move a state on by ``time`` (…) [s] with the foot in place."""
    cosh, sinh = np.cosh(omega * np.asarray(time)), np.sinh(omega * np.asarray(time))
    rows = [[cosh, sinh / omega], [omega * sinh, cosh]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def forward_end_velocity(omega: float, time: np.ndarray | float, mean: np.ndarray) -> np.ndarray:
    """Velocity at the end of a step of the orbit with ``mean`` velocity (…) [m/s].

    The orbit goes from −L/2 to L/2 with L = mean · time, so that
    v_end = ω (L/2) / tanh(ω time / 2): faster than the mean.
    """
    return omega * mean * time / 2 / np.tanh(omega * time / 2)


def lateral_end_velocity(omega: float, time: np.ndarray | float, width: float) -> np.ndarray:
    """Speed (…) [m/s] away from the foot at the end of a step of the lateral orbit.

    The orbit starts and ends half of ``width`` [m] beside the foot:
    v = ω (width/2) tanh(ω time / 2).
    """
    return omega * width / 2 * np.tanh(omega * np.asarray(time) / 2)


def quintic(
    start: np.ndarray, end: np.ndarray, duration: np.ndarray, time: np.ndarray | float
) -> np.ndarray:
    """State (…, 3) at ``time`` (…) [s] of the quintic that joins two states.

    ``start`` (…, 3) are position, velocity and acceleration at 0, ``end`` (…, 3) those at
    ``duration`` (…), positive [s]; ``time`` is between the two.
    """
    t = np.asarray(time)
    p0, v0, a0 = np.moveaxis(start, -1, 0)
    gap = end[..., 0] - p0 - v0 * duration - 0.5 * a0 * duration**2
    dv = (end[..., 1] - v0 - a0 * duration) * duration
    da = (end[..., 2] - a0) * duration**2
    c3 = (10 * gap - 4 * dv + 0.5 * da) / duration**3
    c4 = (-15 * gap + 7 * dv - da) / duration**4
    c5 = (6 * gap - 3 * dv + 0.5 * da) / duration**5
    position = p0 + t * (v0 + t * (0.5 * a0 + t * (c3 + t * (c4 + t * c5))))
    velocity = v0 + t * (a0 + t * (3 * c3 + t * (4 * c4 + t * 5 * c5)))
    acceleration = a0 + t * (6 * c3 + t * (12 * c4 + t * 20 * c5))
    return np.stack([position, velocity, acceleration], axis=-1)


class ReferenceVelocity:
    """Reference velocity: a ramp to the commanded one, with integral action.

    ``period`` is that of a tick [s].
    """

    def __init__(self, config: VelocityConfig, period: float) -> None:
        self._config, self._period = config, period

    def change(self, memory: Memory, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from now on; the reference ramps from its current value."""
        changed = np.flatnonzero((velocity != memory.velocity).any(axis=1))
        memory.previous[changed] = self._on_the_way(memory, changed)
        memory.changed[changed] = memory.walked[changed]
        memory.correction[changed] = 0.0
        # No velocity error of a stride in which the command changed.
        memory.steps[changed] = np.minimum(memory.steps[changed], 1)
        memory.velocity = velocity

    def planned(self, memory: Memory, robots: np.ndarray, ahead: float = 0.0) -> np.ndarray:
        """Velocity (n, 2) forward, left [m/s] to plan steps for, ``ahead`` [s] from now."""
        return self._on_the_way(memory, robots, ahead) + memory.correction[robots]

    def _on_the_way(self, memory: Memory, robots: np.ndarray, ahead: float = 0.0) -> np.ndarray:
        """Ramp (n, 2) [m/s] from the previous velocity with constant acceleration."""
        previous = memory.previous[robots]
        change = memory.velocity[robots, :2] - previous
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = memory.walked[robots] - memory.changed[robots] + ahead
        share = np.minimum(1.0, self._config.acceleration * time / size)
        return previous + change * share[:, None]

    def correct(self, memory: Memory, robots: np.ndarray, com: np.ndarray) -> None:
        """Integrate the velocity error of the last stride at the start of a step.

        ``starts`` and ``correction`` of the memory change; ``robots`` (n,) are those that start a
        step, ``com`` (n, 2) their centres of mass [m], world.
        """
        now = np.concatenate([com, memory.walked[robots, None]], axis=1)
        moved = now - memory.starts[robots, 0]
        memory.starts[robots] = np.stack([memory.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while the robot brakes in order to stand.
        valid = (memory.steps[robots] > 2) & ~memory.commanded_to_stand(robots)
        valid &= memory.walked[robots] - memory.changed[robots] >= self._config.integral_after
        halfway = memory.heading[robots] - 0.5 * memory.velocity[robots, 2] * moved[:, 2]
        mean = turn_to_heading(moved, halfway) / np.maximum(moved[:, 2:], self._period)
        error = np.where(valid[:, None], memory.velocity[robots, :2] - mean, 0.0)
        limit = self._config.integral_limit
        total = memory.correction[robots] + self._config.integral * error
        memory.correction[robots] = np.clip(total, -limit, limit)


class Entry:
    """A sway in double support from rest into the lateral orbit, with a closed-loop exit.

    The robot sways towards the first stance foot, until a step leads into the orbit.

    ``omega`` is the natural frequency of the pendulum [rad/s], ``reach`` the forward distance from
    the middle within which a robot can come to a stop [m].
    """

    def __init__(self, config: EntryConfig, omega: float, reach: float) -> None:
        self._config, self._omega, self._reach = config, omega, reach

    def begin(
        self,
        feet: np.ndarray,
        position: np.ndarray,
        side: np.ndarray,
        speed: np.ndarray,
        orbit: Orbit,
    ) -> Sway:
        """Sway of robots at rest at ``position`` (n, 2) for a forward ``speed`` (n,) [m/s].

        ``feet`` (n, 2, 2) are the positions of the feet [m]. With the lateral speed
        v = ω (d cosh ωT − e)/sinh ωT in the middle, at d from the stance foot, the first step ends
        at e from it, as steps of the ``orbit`` do; where the orbit is not known (0), e = d. The
        centre of pressure p lies behind the middle so that the pendulum, after the sway and a step
        on a foot in the middle, has the velocity at the end of the orbit's steps,
        v = −ω p (sinh ω(t + T) − sinh ωT), if ``push`` allows that.
        """
        start, middle = np.zeros((len(feet), 3)), feet.mean(axis=1)
        ahead, sideways = (position - middle).T
        start[:, 0] = side * sideways
        omega, step = self._omega, orbit.time
        apart = 0.5 * (feet[:, LEFT] - feet[:, RIGHT])[:, 1]
        sinh = np.sinh(omega * step)
        orbit = orbit._replace(end=np.where(orbit.end > 0, orbit.end, apart))
        lateral = omega * (apart * np.cosh(omega * step) - orbit.end) / sinh
        end = forward_end_velocity(omega, step, speed)
        gain = np.sinh(omega * (self._config.duration + step)) - sinh
        push = np.clip(-end / (omega * gain), -self._config.push, self._config.push)
        return Sway(middle, side, start, ahead, push, lateral, *orbit, np.zeros(len(middle)))

    def reference(self, sway: Sway) -> np.ndarray:
        """Forward and leftward position from the middle, velocity, acceleration (n, 2, 3)."""
        sideways = sway.side[:, None] * self._sideways(sway)
        return np.stack([self._forward(sway), sideways], axis=1)

    def _forward(self, sway: Sway) -> np.ndarray:
        """Pendulum from rest in the middle, plus a quintic there from the start: (n, 3)."""
        omega, phase = self._omega, self._omega * sway.elapsed
        cosh, sinh = np.cosh(phase), np.sinh(phase)
        unit = np.stack([1 - cosh, -omega * sinh, -(omega**2) * cosh], axis=-1)
        duration = np.full(len(unit), self._config.duration)
        start, middle = np.zeros((2, len(unit), 3))
        start[:, 0] = sway.ahead
        there = quintic(start, middle, duration, np.minimum(sway.elapsed, duration))
        return sway.push[:, None] * unit + there

    def _sideways(self, sway: Sway) -> np.ndarray:
        """Quintic to the middle with the orbit's speed there, then constant velocity: (n, 3)."""
        duration = np.full(len(sway.elapsed), self._config.duration)
        goal = np.zeros((len(duration), 3))
        goal[:, 1] = sway.speed
        late = sway.elapsed > duration
        result = quintic(sway.start, goal, duration, np.minimum(sway.elapsed, duration))
        result[late, 0] += (sway.speed * (sway.elapsed - duration))[late]
        return result

    def done(
        self, sway: Sway, position: np.ndarray, velocity: np.ndarray, foot: np.ndarray
    ) -> np.ndarray:
        """Whether robots can take their first step, or must (n,).

        They can if a step from here ends where those of the orbit end or nearer to the stance
        foot, and the centre of mass moves forward as planned. They must if the capture point
        x + ẋ/ω is further than ``reach`` from the planned one, or if their time is over and it is
        further than that from the middle.

        ``position`` and ``velocity`` are those of the centre of mass (n, 2) [m], [m/s], ``foot`` is
        the first stance foot (n, 2) [m].
        """
        sideways = sway.side[:, None] * np.stack([position - foot, velocity], axis=-1)[:, 1]
        end = (step_map(self._omega, sway.time) @ sideways[:, :, None])[:, 0, 0]
        ready = end > -sway.end - self._config.tolerance
        planned = self._forward(sway)
        calm = np.abs(velocity[:, 0] - planned[:, 1]) < self._config.speed_tolerance
        begun = sway.elapsed > self._config.duration / 2
        capture = (position - sway.middle)[:, 0] + velocity[:, 0] / self._omega
        astray = np.abs(capture - planned[:, 0] - planned[:, 1] / self._omega) > self._reach
        lost = astray | (self._late(sway) & (np.abs(capture) > self._reach))
        return (ready & calm & begun) | lost

    def _late(self, sway: Sway) -> np.ndarray:
        return sway.elapsed > self._config.duration + self._config.patience

    def restart(self, sway: Sway, position: np.ndarray, velocity: np.ndarray) -> None:
        """Restart the sway in place, from ``position`` and ``velocity`` (n, 2), if out of time."""
        again = self._late(sway)
        ahead, sideways = (position - sway.middle).T
        sway.ahead[again] = ahead[again]
        sway.start[again, 0] = (sway.side * sideways)[again]
        sway.start[again, 1] = (sway.side * velocity[:, 1])[again]
        sway.start[again, 2] = 0.0
        sway.push[again] = 0.0
        sway.elapsed[again] = 0.0
