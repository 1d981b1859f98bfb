"""Checks 1 to 4: dynamics and impacts by pinocchio, mean velocity and periodicity, the roll.

Check 4 is about the roll, the only unactuated coordinate. Joints follow their Bézier
polynomials in time; the roll of the stance foot about its line obeys "no moment about the line"
(pinocchio), integrated by DOP853 (Hairer, Nørsett, Wanner 1993).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from slider.config.gait import IntegratorConfig
from slider.robot.kinematics import rotation_from_quaternion
from slider.robot.names import LAST_JOINTS, SIDES
from slider.verification.pin_robot import FloatingState, PinRobot, full
from slider.verification.quantities import worst
from slider.verification.stored import StepMotion, StoredGait

_BASE = 6


def stored_state(gait: StoredGait, robot: PinRobot, sample: int) -> FloatingState:
    """State of a stored sample; the world's origin and x axis are those of the stance foot.

    The library stores no accelerations: they follow from the coefficients and the foot's roll.
    """
    base = gait.base[sample]
    rotation = rotation_from_quaternion(base[None, 3:7])[0]
    w, x, y, z = base[3:7]
    knee = gait.knee_positions[sample], gait.knee_velocities[sample]
    joints, rates, _ = robot.joint_motion(*knee, np.zeros_like(knee[0]))
    if robot.soles is not None:
        joints, rates = full(joints), full(rates)
        for values, stored in zip((joints, rates), gait.last_joints[sample], strict=True):
            values[list(LAST_JOINTS)] = stored
    step = gait.step_of(sample)
    q = np.concatenate([base[:3] - gait.origin(step), [x, y, z, w], joints])
    v = np.concatenate([rotation.T @ base[7:10], base[10:13], rates])
    state = FloatingState(q, v, robot.moving(gait.steps[step], gait.time_in_step(sample)).a)
    return _seen_from(state, gait.heading(step))


def _seen_from(state: FloatingState, yaw: float) -> FloatingState:
    """A state in axes that are yawed about the origin; velocities are in the base frame."""
    back = _about_z(-yaw)
    attitude = (back * Rotation.from_quat(state.q[3:7])).as_quat()
    q = np.concatenate([back.apply(state.q[:3]), attitude, state.q[7:]])
    return FloatingState(q, state.v, state.a)


def inverse_dynamics(gait: StoredGait, robot: PinRobot) -> dict[str, float]:
    """Residuals of the equations of motion at all nodes under the stored ground wrench.

    Returns:
        Worst torque of the knee's joints [N m] and effort of the slide's [N m, N], force and moment
        left on the floating base [N, N m], and stored moment about the foot line [N m]: for a
        sole that about the ankle's roll axis.
    """
    rows = []
    for sample in range(2 * gait.half):
        state, side = stored_state(gait, robot, sample), SIDES[gait.step_of(sample)]
        wrench, stored = gait.ground_wrench[sample], gait.efforts[sample]
        rest = robot.forces(state) - robot.jacobian(state.q, side).T @ wrench
        torques, efforts = robot.work(gait.knee_positions[sample], rest[_BASE:])
        rows.append(
            {
                "dynamics_torque": torques - gait.knee_torques[sample],
                "dynamics_efforts": full(efforts) - stored,
                "dynamics_base": rest[:_BASE],
                "dynamics_line_moment": robot.roll_moment(state, stored, wrench, side),
            }
        )
    return worst(rows)


def impact(gait: StoredGait, robot: PinRobot) -> dict[str, float]:
    """Plastic impacts at both touchdowns: velocities after them, and residual impulses.

    Returns:
        Worst velocity [rad/s, m/s] against the solution of mass matrix and contact Jacobian, and
        worst joint impulse or moment about the line [N m s] that the stored velocities need.
    """
    return worst(
        [
            {
                "impact_velocity": robot.impact(before.q, before.v, side) - after.v,
                "impact_impulse": robot.impulse(before.q, before.v, after.v, side),
            }
            for before, after, side in touchdowns(gait, robot)
        ]
    )


def touchdowns(gait: StoredGait, robot: PinRobot) -> list[tuple[FloatingState, FloatingState, str]]:
    """Stored states before and after both touchdowns, and the side of the foot that lands.

    Both are in the axes of that foot's line.
    """
    states = []
    for step, turn in enumerate(gait.turns):
        before = _seen_from(stored_state(gait, robot, (step + 1) * gait.half - 1), turn)
        after = stored_state(gait, robot, (step + 1) * gait.half % (2 * gait.half))
        states.append((before, after, SIDES[1 - step]))
    return states


def mean_velocity(gait: StoredGait) -> dict[str, float]:
    """Error of the base's mean velocity, each step in the axes of its stance foot [m/s].

    The last sample of a step is the first of the next, except for the velocities. Without a yaw
    rate the displacement of the feet is checked alike.
    """
    starts, ends = gait.base[[0, gait.half], :3], gait.base[[gait.half - 1, -1], :3]
    ways = enumerate(ends - starts)
    along = [_about_z(-gait.heading(step)).apply(way)[:2] for step, way in ways]
    travelled = [np.sum(along, axis=0)]
    if not gait.velocities[2]:
        travelled.append(gait.swing_foot[gait.half - 1, :2] + gait.swing_foot[-1, :2])
    walk = gait.step_time.sum()
    return worst([{"mean_velocity": way / walk - gait.velocities[:2]} for way in travelled])


def _about_z(angle: float) -> Rotation:
    return Rotation.from_rotvec([0.0, 0.0, angle])


def periodicity(gait: StoredGait) -> dict[str, float]:
    """Jump of joints [rad], base position [m] and orientation [rad] over both touchdowns.

    Velocity jumps are checked by ``impact``. The next walk starts where the feet are after this
    one, yawed by both turns.
    """
    ends = [gait.half - 1, 2 * gait.half - 1]
    starts = [gait.half, 0]
    joints, rolls = (x[ends] - x[starts] for x in (gait.knee_positions, gait.last_joints[:, 0]))
    before, after = (
        Rotation.from_quat(gait.base[at, 3:7], scalar_first=True) for at in (ends, starts)
    )
    first, both = _about_z(gait.heading(1)), _about_z(gait.heading(2))
    after = Rotation.concatenate([after[0], both * after[1]])
    again = gait.origin(1) + first.apply(gait.swing_foot[-1]) + both.apply(gait.base[0, :3])
    places = gait.base[ends, :3] - [gait.base[gait.half, :3], again]
    turn = (before * after.inv()).magnitude()
    jumps = np.concatenate([*map(np.ravel, (joints, rolls, places, turn))])
    return worst([{"periodicity": jumps}])


def integrate_roll(
    robot: PinRobot,
    motion: StepMotion,
    integrator: IntegratorConfig,
    start: np.ndarray,
    times: np.ndarray,
) -> np.ndarray:
    """Roll of a stance foot and its rate (N, 2) at times (N,) from a start (2,) at the first.

    Raises:
        RuntimeError: the integrator failed.
    """

    def derivative(time: float, state: np.ndarray) -> np.ndarray:
        return np.array([state[1], robot.free_roll(motion, time, state)])

    result = solve_ivp(
        derivative,
        (times[0], times[-1]),
        start,
        "DOP853",
        t_eval=times,
        rtol=integrator.relative,
        atol=integrator.absolute,
    )
    if not result.success:
        raise RuntimeError(f"integration of the roll: {result.message}")
    return result.y.T


def roll(gait: StoredGait, robot: PinRobot, integrator: IntegratorConfig) -> dict[str, float]:
    """Collocated roll against the integrated one, from each step's first node [rad, rad/s]."""
    rows = []
    for motion in gait.steps:
        times = np.linspace(0.0, motion.duration, gait.half)
        nodes = motion.roll_at(times)[:, :2]
        errors = integrate_roll(robot, motion, integrator, nodes[0], times) - nodes
        end, rate_end = errors[-1]
        rows.append({"roll_end": end, "roll_rate_end": rate_end, "roll_worst": errors[:, 0]})
    return worst(rows)
