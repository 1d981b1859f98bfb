"""What observation and reward terms read."""

from dataclasses import dataclass

from slider.core.arrays import Array
from slider.env.phase import gait_command
from slider.env.state import RobotState


@dataclass(frozen=True)
class View:
    """State of N robots together with the commands and actions of their agent.

    Attributes:
        state: the robots.
        command: (N, 4) vx, vy [m/s], yaw rate [rad/s], heading error [rad].
        action, previous_action: (N, 12) unscaled, unmirrored.
        action_scale: (12,) joint motion of an action of 1 [rad or m].
        filtered_velocity: (N, 2) low-passed forward and leftward velocity [m/s].
        reference_velocity: (N, 2) on the way from one command to the next [m/s].
        expected_velocity: (N, 2) the same, low-passed as filtered_velocity is [m/s].
        phase: (N,) clock in [0, 1); zero without a clock.
        halted: (N,) whether the clock stays at a change of feet: stand.
        nominal: (12,) joint positions of the nominal pose [rad or m].
        nominal_height: base height of the nominal pose [m].
        torque_limits: (10,) of the motors [N m].
        period: control period [s].
        scan_points: number of points of the height scan, along x and y.
        scan_spacing: of these points [m].
    """

    state: RobotState
    command: Array
    action: Array
    previous_action: Array
    action_scale: Array
    filtered_velocity: Array
    reference_velocity: Array
    expected_velocity: Array
    phase: Array
    halted: Array
    nominal: Array
    nominal_height: float
    torque_limits: Array
    period: float
    scan_points: tuple[int, int]
    scan_spacing: float

    @property
    def reference_command(self) -> Array:
        """Command (N, 3) of the gait in use: reference velocity, commanded yaw rate."""
        return gait_command(self.reference_velocity, self.command)
