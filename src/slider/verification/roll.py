"""Checks 4 and 5: the roll, the one coordinate that is not driven, by another integrator.

Joints follow their Bézier polynomials in time; the roll of the stance foot about its line obeys
"no moment about the line" (pinocchio), integrated by DOP853 (Hairer, Nørsett, Wanner 1993).
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from slider.config.verification import IntegratorConfig
from slider.robot.kinematics import about_z
from slider.robot.names import other_side
from slider.verification.pin_robot import FloatingState, PinRobot
from slider.verification.stored import StepMotion, StoredGait


@dataclass(frozen=True)
class RollDynamics:
    """Roll of one stance foot while the joints follow a step.

    ``turn`` is the yaw of the landing foot's line from the stance foot's [rad].
    """

    robot: PinRobot
    motion: StepMotion
    integrator: IntegratorConfig
    turn: float = 0.0

    def derivative(self, time: float, state: np.ndarray) -> np.ndarray:
        """Rate and acceleration (2,) of roll and rate (2,)."""
        still = self._state(time, state)
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

    def momentum_after(self, state: np.ndarray) -> tuple[float, float]:
        """Roll [rad] of the new stance foot, momentum [kg m²/s] about its line, at the end."""
        moving = self._state(self.motion.duration, state)
        swing = other_side(self.motion.side)
        self.robot.jacobian(moving.q, swing)
        sole = self.robot.data.oMf[self.robot.sole(swing)]
        axes = about_z(np.array([self.turn]))[0]
        lateral = axes[:, 1] @ sole.rotation[:, 1]
        roll = float(np.arctan2(sole.rotation[2, 1], lateral))
        place = sole.translation.copy()
        momentum = self.robot.momentum_about(moving.q, moving.v, place)
        return roll, float(axes[:, 0] @ momentum)

    def rate_of(self, roll: float, momentum: float) -> float:
        """Roll rate [rad/s] at the start that has a momentum [kg m²/s] about the line."""
        still = self._state(0.0, np.array([roll, 0.0]))
        _, inertia = self.robot.line_moment_and_inertia(still, self.motion.side)
        carried = self.robot.momentum_about(still.q, still.v, np.zeros(3))[0]
        return float((momentum - carried) / inertia)

    def _state(self, time: float, state: np.ndarray) -> FloatingState:
        return self.robot.moving(self.motion, time, np.array([state[0], state[1], 0.0]))


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


def return_map(
    gait: StoredGait, robot: PinRobot, integrator: IntegratorConfig, step: float
) -> np.ndarray:
    """Jacobian (2, 2) of the walk-to-walk map of roll and roll rate, by central differences.

    Open loop: the joints follow their polynomials in time, through both touchdowns; each moves
    the momentum about the old line to the new one. ``step`` is the perturbation [rad, rad/s].
    """
    dynamics = [
        RollDynamics(robot, motion, integrator, float(turn))
        for motion, turn in zip(gait.steps, gait.turns, strict=True)
    ]
    start = gait.steps[0].roll_at(0.0)[:2]
    columns = []
    for axis in np.eye(2):
        above, below = (_walk(dynamics, start + sign * step * axis) for sign in (1.0, -1.0))
        columns.append((above - below) / (2 * step))
    return np.stack(columns, axis=1)


def _walk(dynamics: list[RollDynamics], state: np.ndarray) -> np.ndarray:
    """Roll and rate (2,) a walk later."""
    for current, following in zip(dynamics, dynamics[::-1], strict=True):
        end = current.integrate(state, np.array([0.0, current.motion.duration]))[-1]
        roll, momentum = current.momentum_after(end)
        state = np.array([roll, following.rate_of(roll, momentum)])
    return state


def open_loop(
    gait: StoredGait, robot: PinRobot, integrator: IntegratorConfig, step: float
) -> dict[str, float]:
    """Greatest modulus of the return map's eigenvalues; above one the open loop falls."""
    moduli = np.abs(np.linalg.eigvals(return_map(gait, robot, integrator, step)))
    return {"return_map": float(moduli.max())}
