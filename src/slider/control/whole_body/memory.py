"""State of a controller for N robots between ticks; its other parts are stateless.

Feet are numbered left, right; modes are on both feet (STAND, SWAY), stepping (WALK) and OFF.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slider.env.height_field import FLAT, Ground
from slider.env.phase import standing
from slider.robot.kinematics import turn_to_heading

SWAY, WALK, OFF, STAND = 0, 1, 2, 3
LEFT, RIGHT = 0, 1
FEET = np.array([LEFT, RIGHT])


class Orbit(NamedTuple):
    """Lateral orbits: distance from the foot at a step's end (n,) [m], time of a step (n,) [s]."""

    end: np.ndarray
    time: np.ndarray


@dataclass
class Sway:
    """Sways of n robots in double support, in the frame of their heading.

    Attributes:
        middle: (n, 2) point between the feet [m].
        side: (n,) +1 where the left foot is the first stance foot, −1 for the right one.
        start: (n, 3) position [m] from the middle towards that foot, velocity and acceleration at
            the start.
        ahead: (n,) forward position of the centre of mass from the middle at the start [m].
        push: (n,) forward position of the centre of pressure from the middle [m].
        speed: (n,) towards that foot in the middle, from which a step enters the orbit [m/s].
        end, time: of the :class:`Orbit` (n,).
        elapsed: (n,) [s].
    """

    middle: np.ndarray
    side: np.ndarray
    start: np.ndarray
    ahead: np.ndarray
    push: np.ndarray
    speed: np.ndarray
    end: np.ndarray
    time: np.ndarray
    elapsed: np.ndarray


@dataclass
class Memory:
    """Memory of N robots; methods take and return values of a subset, ``robots`` (n,).

    Attributes:
        velocity: (N, 3) commanded vx, vy [m/s], yaw rate [rad/s].
        tick: number of ticks since the start.
        mode: (N,) SWAY, WALK, OFF or STAND.
        heading: (N,) desired yaw [rad].
        sway: on both feet before the first step.
        stance: (N,) foot on the ground.
        elapsed, duration: of the step (N,) [s].
        foothold: (N, 2) of the next step [m], world.
        swing: (N, 3, 3) reference of the swing foot.
        walked: time since the first step (N,) [s].
        steps: (N,) number of steps.
        starts: (N, 2, 3) position of the centre of mass (2) [m] and ``walked`` at the starts of
            the last two steps, the older one first.
        correction: (N, 2) integral action, added to the reference velocity [m/s].
        previous: (N, 2) reference velocity when the commanded one last changed [m/s].
        changed: ``walked`` at that time (N,) [s].
        target_yaw_rate: (N,) yaw rate [rad/s] to which that of ``velocity`` ramps in a walk.
        ground: under the N robots, as in the state that the controller receives.
    """

    velocity: np.ndarray
    tick: int
    mode: np.ndarray
    heading: np.ndarray
    sway: Sway
    stance: np.ndarray
    elapsed: np.ndarray
    duration: np.ndarray
    foothold: np.ndarray
    swing: np.ndarray
    walked: np.ndarray
    steps: np.ndarray
    starts: np.ndarray
    correction: np.ndarray
    previous: np.ndarray
    changed: np.ndarray
    target_yaw_rate: np.ndarray
    ground: Ground = FLAT

    @classmethod
    def on_both_feet(cls, velocity: np.ndarray, heading: np.ndarray) -> "Memory":
        """Before the first step, with ``velocity`` (N, 3) and ``heading`` (N,) [rad] commanded."""
        n = len(velocity)
        return cls(
            velocity=velocity,
            tick=0,
            mode=np.where(standing(velocity), STAND, SWAY),
            heading=heading.copy(),
            sway=Sway(np.zeros((n, 2)), np.zeros(n), np.zeros((n, 3)), *np.zeros((6, n))),
            stance=np.full(n, LEFT),
            elapsed=np.zeros(n),
            duration=np.zeros(n),
            foothold=np.zeros((n, 2)),
            swing=np.zeros((n, 3, 3)),
            walked=np.zeros(n),
            steps=np.zeros(n, dtype=int),
            starts=np.zeros((n, 2, 3)),
            correction=np.zeros((n, 2)),
            previous=np.zeros((n, 2)),
            changed=np.zeros(n),
            target_yaw_rate=velocity[:, 2].copy(),
        )

    def forget_walk(self, robots: np.ndarray) -> None:
        """Reset to the values before the first step."""
        for values in (self.walked, self.steps, self.previous, self.changed, self.correction):
            values[robots] = 0

    def commanded_to_stand(self, robots: np.ndarray) -> np.ndarray:
        """Whether the commanded velocity is zero (n,)."""
        return standing(self.velocity[robots])

    def yaw_rate(self, robots: np.ndarray) -> np.ndarray:
        """Commanded yaw rate (n,) [rad/s]; on both feet the robot does not turn."""
        return np.where(self.mode[robots] == WALK, self.velocity[robots, 2], 0.0)

    def rise(self, robots: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Height (n,) [m] of the ground at points ``end`` (n, 2) above that at ``start`` (n, 2)."""
        ground = self.ground.of(robots)
        return ground.height(end, gaps=False) - ground.height(start, gaps=False)

    def slope(self, robots: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Rise over run (n, 2) of the ground at ``places`` (n, 2) along world axes."""
        return self.ground.of(robots).gradient(places)

    def to_heading(self, vectors: np.ndarray, robots: np.ndarray) -> np.ndarray:
        """World (n, 2) → forward, left."""
        return turn_to_heading(vectors, self.heading[robots])

    def to_world(self, vectors: np.ndarray, robots: np.ndarray) -> np.ndarray:
        """Forward, left (n, 2) → world."""
        return turn_to_heading(vectors, -self.heading[robots])
