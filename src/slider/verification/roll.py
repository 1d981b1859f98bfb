"""Check 4: the roll, the one coordinate that is not driven, by another integrator.

Joints follow their Bézier polynomials in time; the roll of the stance foot about its line obeys
"no moment about the line" (pinocchio), integrated by DOP853 (Hairer, Nørsett, Wanner 1993).
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from slider.config.gait import IntegratorConfig
from slider.verification.pin_robot import PinRobot
from slider.verification.stored import StepMotion, StoredGait


@dataclass(frozen=True)
class RollDynamics:
    """Roll of one stance foot while the joints follow a step."""

    robot: PinRobot
    motion: StepMotion
    integrator: IntegratorConfig

    def derivative(self, time: float, state: np.ndarray) -> np.ndarray:
        """Rate and acceleration (2,) of roll and rate (2,)."""
        still = self.robot.moving(self.motion, time, np.array([*state, 0.0]))
        moment, inertia = self.robot.line_moment_and_inertia(still, self.motion.side)
        return np.array([state[1], -moment / inertia])

    def integrate(self, start: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Roll and rate (N, 2) at times (N,) of a start (2,) at the first of them.

        Raises:
            RuntimeError: the integrator gave up.
        """
        result = solve_ivp(
            self.derivative,
            (times[0], times[-1]),
            start,
            "DOP853",
            t_eval=times,
            rtol=self.integrator.relative,
            atol=self.integrator.absolute,
        )
        if not result.success:
            raise RuntimeError(f"integration of the roll: {result.message}")
        return result.y.T


def one_step_integration(
    gait: StoredGait, robot: PinRobot, integrator: IntegratorConfig
) -> dict[str, float]:
    """Collocated roll against the integrated one, from each step's first node [rad, rad/s]."""
    end, rate, worst = [], [], []
    for motion in gait.steps:
        times = np.linspace(0.0, motion.duration, gait.half)
        nodes = motion.roll_at(times)[:, :2]
        error = np.abs(RollDynamics(robot, motion, integrator).integrate(nodes[0], times) - nodes)
        end.append(error[-1, 0])
        rate.append(error[-1, 1])
        worst.append(error[:, 0].max())
    names = ("roll_end", "roll_rate_end", "roll_worst")
    return {n: float(max(v)) for n, v in zip(names, (end, rate, worst), strict=True)}
