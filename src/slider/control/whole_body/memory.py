"""What a controller remembers of N robots between ticks; its other parts have no state.

Feet are numbered left, right; modes are on both feet (STAND, SWAY), stepping (WALK) and OFF.
"""

from dataclasses import dataclass

import numpy as np

from slider.control.whole_body.entry import Sway
from slider.env.phase import standing
from slider.robot.kinematics import turn_to_heading

SWAY, WALK, OFF, STAND = 0, 1, 2, 3
LEFT, RIGHT = 0, 1
FEET = np.array([LEFT, RIGHT])


@dataclass
class Memory:
    """Memory of N robots; methods take and give the rows of some of them, ``robots`` (n,).

    Attributes:
        command: (N, 3) vx, vy [m/s], yaw rate [rad/s].
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
        starts: (N, 2, 3) place of the centre of mass (2) [m] and ``walked`` at the starts of the
            last two steps, the older one first.
        correction: (N, 2) added to the commanded velocity [m/s].
        old: (N, 2) reference velocity when the command last changed [m/s].
        changed: ``walked`` at that time (N,) [s].
        yaw_command: (N,) commanded yaw rate, to which a walk's grows [rad/s].
    """

    command: np.ndarray
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
    old: np.ndarray
    changed: np.ndarray
    yaw_command: np.ndarray

    @classmethod
    def on_both_feet(cls, command: np.ndarray, heading: np.ndarray) -> "Memory":
        """Before the first step, with ``command`` (N, 3), facing along ``heading`` (N,) [rad]."""
        n = len(command)
        return cls(
            command=command,
            tick=0,
            mode=np.where(standing(command), STAND, SWAY),
            heading=heading.copy(),
            sway=Sway.zeros(n),
            stance=np.full(n, LEFT),
            elapsed=np.zeros(n),
            duration=np.zeros(n),
            foothold=np.zeros((n, 2)),
            swing=np.zeros((n, 3, 3)),
            walked=np.zeros(n),
            steps=np.zeros(n, dtype=int),
            starts=np.zeros((n, 2, 3)),
            correction=np.zeros((n, 2)),
            old=np.zeros((n, 2)),
            changed=np.zeros(n),
            yaw_command=command[:, 2].copy(),
        )

    def forget_walk(self, robots: np.ndarray) -> None:
        """As before the first step."""
        for values in (self.walked, self.steps, self.old, self.changed, self.correction):
            values[robots] = 0

    def commanded_to_stand(self, robots: np.ndarray) -> np.ndarray:
        """Whether the command is to stand (n,)."""
        return standing(self.command[robots])

    def yaw_rate(self, robots: np.ndarray) -> np.ndarray:
        """Commanded yaw rate (n,) [rad/s]; on both feet the robot does not turn."""
        return np.where(self.mode[robots] == WALK, self.command[robots, 2], 0.0)

    def to_heading(self, vectors: np.ndarray, robots: np.ndarray) -> np.ndarray:
        """World (n, 2) → forward, left."""
        return turn_to_heading(vectors, self.heading[robots])

    def to_world(self, vectors: np.ndarray, robots: np.ndarray) -> np.ndarray:
        """Forward, left (n, 2) → world."""
        return turn_to_heading(vectors, -self.heading[robots])
