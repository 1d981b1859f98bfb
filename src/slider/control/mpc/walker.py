"""The baseline as a controller: entry, footstep MPC, swing foot and whole-body QP for N robots.

Told to stand it stands on both feet; told to go it sways into the sideways orbit and walks; told to
stop it steps until it can be caught on both feet.

It is given the true state, contact flags and a nominal model of the robot; ``docs/baseline.md``
says how this compares with what the policy is given.
"""

from dataclasses import dataclass

import numpy as np

from slider.control.mpc import lip, swing
from slider.control.mpc.clock import TickClock
from slider.control.mpc.entry import Entry, Sway
from slider.control.mpc.footsteps import FootstepPlanner, Pendulum
from slider.control.mpc.motion import Motion, Part, about_z, join
from slider.control.mpc.nominal import Dynamics, NominalModel
from slider.control.mpc.whole_body import WholeBody
from slider.core.config.control import MpcConfig
from slider.core.config.robot import RobotConfig
from slider.env.metrics import CONTACT_FORCE
from slider.env.phase import standing
from slider.env.state import RobotState
from slider.robot import names

SWAY, WALK, OFF, STAND = 0, 1, 2, 3
_GIVE_UP_TILT = 1.2  # [rad]; beyond it, or without a solution, the drives are switched off
_LEFT, _RIGHT = 0, 1
_FEET = np.array([_LEFT, _RIGHT])


@dataclass
class Gait:
    """What the controller remembers of N robots.

    Attributes:
        mode: (N,) SWAY, WALK, OFF or STAND.
        heading: (N,) wanted yaw [rad].
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
    """

    mode: np.ndarray
    heading: np.ndarray
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


class MpcController:
    """Torques of N robots, once per tick.

    Args:
        robot: the nominal robot, not the plant.
        config: settings of the baseline.
        period: of a tick [s].
    """

    def __init__(self, robot: RobotConfig, config: MpcConfig, period: float) -> None:
        self._config, self._period = config, period
        self._model = NominalModel(robot)
        self.omega = lip.rate(self._model.nominal_height)
        self._planner = FootstepPlanner(config.step, config.planner, self.omega)
        self._reach = min(robot.geometry.heel, robot.geometry.toe)
        self._entry = Entry(config.step, config.entry, self.omega, self._reach)
        self._motion = Motion(config.whole_body)
        self._whole_body = WholeBody(robot, config.whole_body)
        self.clock = TickClock()
        self._ticks_per_plan = max(1, round(config.planner.period / period))

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Start anew on both feet; ``velocity`` (N, 3) is vx, vy [m/s], yaw rate [rad/s]."""
        n = state.num_robots
        self._command, self._tick = velocity, 0
        dynamics = self._model.evaluate(state.qpos, state.qvel)
        self.gait = Gait(
            mode=np.where(standing(velocity), STAND, SWAY),
            heading=state.yaw.copy(),
            stance=np.full(n, _LEFT),
            elapsed=np.zeros(n),
            duration=np.full(n, self._config.step.time),
            foothold=np.zeros((n, 2)),
            swing=np.zeros((n, 3, 3)),
            walked=np.zeros(n),
            steps=np.zeros(n, dtype=int),
            starts=np.zeros((n, 2, 3)),
            correction=np.zeros((n, 2)),
            old=np.zeros((n, 2)),
            changed=np.zeros(n),
        )
        self._sway = self._new_sway(np.arange(n), dynamics)

    def command(self, velocity: np.ndarray) -> None:
        """Go with ``velocity`` (N, 3) from now on; the reference grows from where it is."""
        gait, everyone = self.gait, np.arange(len(velocity))
        changed = (velocity != self._command).any(axis=1)
        gait.old[changed] = self._reference(everyone)[changed]
        gait.changed[changed] = gait.walked[changed]
        gait.correction[changed] = 0.0
        gait.steps[changed] = np.minimum(gait.steps[changed], 1)  # no error of a stride in between
        self._command = velocity

    def _new_sway(self, robots: np.ndarray, dynamics: Dynamics) -> Sway:
        middle = self._to_heading(dynamics.foot_positions.mean(axis=1)[:, :2], robots)
        position = self._to_heading(dynamics.com[:, :2], robots)
        height = dynamics.foot_positions[:, :, 2]
        # The body falls towards the foot that is still in the air.
        side = np.where(height[:, _LEFT] >= height[:, _RIGHT], 1.0, -1.0)
        return self._entry.begin(middle, position, side, self._command[robots, 0])

    def _to_heading(
        self, vectors: np.ndarray, robots: np.ndarray | slice = slice(None)
    ) -> np.ndarray:
        """World (n, 2) → forward, left."""
        return _turn(vectors, -self.gait.heading[robots])

    def control(self, state: RobotState) -> np.ndarray:
        """Torques (N, 12) [N m or N]; the upper feet have no drive."""
        gait = self.gait
        gait.mode[-state.gravity[:, 2] < np.cos(_GIVE_UP_TILT)] = OFF
        torques = np.zeros((state.num_robots, names.NUM_JOINTS))
        active = np.flatnonzero(gait.mode != OFF)
        if len(active):
            self.clock.ticks += len(active)
            with self.clock.part("model"):
                dynamics = self._model.evaluate(state.qpos[active], state.qvel[active])
            self._switch(active, dynamics, state.foot_forces[active] > CONTACT_FORCE)
            for mode, drive in (
                (STAND, self._drive_stand),
                (SWAY, self._drive_sway),
                (WALK, self._drive_walk),
            ):
                chosen = gait.mode[active] == mode
                robots = active[chosen]
                if len(robots):
                    contact = state.foot_forces[robots] > CONTACT_FORCE
                    torques[robots], solved = drive(robots, dynamics.of(chosen), contact)
                    gait.mode[robots[~solved]] = OFF
            gait.heading[active] += self._yaw_rate(active) * self._period
        self._tick += 1
        return torques

    # Which foot is on the ground

    def _switch(self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray) -> None:
        gait = self.gait
        self._go(robots, dynamics)
        sways = gait.mode[robots] == SWAY
        if sways.any():
            done = self._leaves_sway(robots[sways], dynamics.of(sways))
            index = np.flatnonzero(sways)[done]
            gait.mode[robots[index]] = WALK
            stance = _first_stance(self._sway.of(robots[index]))
            self._new_step(robots[index], dynamics.of(index), stance)
        walks = np.flatnonzero(gait.mode[robots] == WALK)
        swing_foot = 1 - gait.stance[robots[walks]]
        ends = self._step_ends(robots[walks], contact[walks, swing_foot])
        index = walks[ends]
        stops = self._can_stop(robots[index], dynamics.of(index))
        self._stop(robots[index[stops]], dynamics.of(index[stops]))
        index, swing_foot = index[~stops], swing_foot[ends][~stops]
        self._new_step(robots[index], dynamics.of(index), swing_foot)

    def _go(self, robots: np.ndarray, dynamics: Dynamics) -> None:
        """Those that stand and are told to go begin to sway."""
        stands = self.gait.mode[robots] == STAND
        index = np.flatnonzero(stands & ~standing(self._command[robots]))
        if len(index):
            self.gait.mode[robots[index]] = SWAY
            self._sway.put(robots[index], self._new_sway(robots[index], dynamics.of(index)))

    def _can_stop(self, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        """Told to stand, and the capture point is between the feet and within their length."""
        capture = dynamics.com[:, :2] + dynamics.com_velocity[:, :2] / self.omega
        feet = [self._to_heading(dynamics.foot_positions[:, i, :2], robots) for i in _FEET]
        place = self._to_heading(capture, robots)
        apart = np.abs(feet[_LEFT] - feet[_RIGHT])[:, 0]
        ahead = np.abs(place - 0.5 * (feet[_LEFT] + feet[_RIGHT]))[:, 0]
        between = (place[:, 1] < feet[_LEFT][:, 1]) & (place[:, 1] > feet[_RIGHT][:, 1])
        beside = (apart < self._reach) & (ahead < self._reach / 2)
        return standing(self._command[robots]) & between & beside

    def _stop(self, robots: np.ndarray, dynamics: Dynamics) -> None:
        if len(robots):
            gait = self.gait
            gait.mode[robots] = STAND
            for values in (gait.walked, gait.steps, gait.old, gait.changed, gait.correction):
                values[robots] = 0
            self._sway.put(robots, self._new_sway(robots, dynamics))

    def _leaves_sway(self, robots: np.ndarray, dynamics: Dynamics) -> np.ndarray:
        sway = self._sway.of(robots)
        position = self._to_heading(dynamics.com[:, :2], robots)
        velocity = self._to_heading(dynamics.com_velocity[:, :2], robots)
        stance = _first_stance(sway)
        support = dynamics.foot_positions[np.arange(len(robots)), stance, :2]
        done = self._entry.done(sway, position, velocity, self._to_heading(support, robots))
        self._entry.restart(sway, position, velocity)
        self._sway.put(robots, sway)
        return done

    def _step_ends(self, robots: np.ndarray, contact: np.ndarray) -> np.ndarray:
        step, elapsed = self._config.step, self.gait.elapsed[robots] + 1e-9
        duration = self.gait.duration[robots]
        if step.switching == "time":
            return elapsed >= duration
        return (contact & (elapsed > step.early * duration)) | (elapsed > duration + step.late)

    def _new_step(self, robots: np.ndarray, dynamics: Dynamics, stance: np.ndarray) -> None:
        gait, everyone = self.gait, np.arange(len(robots))
        gait.stance[robots] = stance
        gait.elapsed[robots] = 0.0
        gait.duration[robots] = self._config.step.time
        gait.swing[robots] = swing.begin(dynamics.foot_positions[everyone, 1 - stance])
        gait.steps[robots] += 1
        self._correct(robots, dynamics.com[:, :2])
        if len(robots):
            self._plan(robots, dynamics)

    def _correct(self, robots: np.ndarray, com: np.ndarray) -> None:
        """Add the velocity error of the last stride to the reference: no error in the mean."""
        gait, planner = self.gait, self._config.planner
        now = np.concatenate([com, gait.walked[robots, None]], axis=1)
        gone = now - gait.starts[robots, 0]
        gait.starts[robots] = np.stack([gait.starts[robots, 1], now], axis=1)
        # Not in the first stride, nor while it brakes in order to stand.
        known = (gait.steps[robots] > 2) & ~standing(self._command[robots])
        halfway = gait.heading[robots] - 0.5 * self._command[robots, 2] * gone[:, 2]
        mean = _turn(gone[:, :2], -halfway) / np.maximum(gone[:, 2:], self._period)
        error = np.where(known[:, None], self._command[robots, :2] - mean, 0.0)
        total = gait.correction[robots] + planner.integral * error
        gait.correction[robots] = np.clip(total, -planner.integral_limit, planner.integral_limit)

    # Where the next steps go

    def _plan(self, robots: np.ndarray, dynamics: Dynamics) -> None:
        gait = self.gait
        stance = gait.stance[robots]
        foot = dynamics.foot_positions[np.arange(len(robots)), stance, :2]
        command = self._reference(robots) + gait.correction[robots]
        pendulum = Pendulum(
            position=self._to_heading(dynamics.com[:, :2] - foot, robots),
            velocity=self._to_heading(dynamics.com_velocity[:, :2], robots),
            swing_sign=np.where(stance == _LEFT, -1.0, 1.0),
            elapsed=gait.elapsed[robots],
            duration=gait.duration[robots],
            command=command,
        )
        with self.clock.part("footsteps"):
            plan = self._planner.plan(pendulum)
        gait.foothold[robots] = foot + _turn(plan.step, gait.heading[robots])
        gait.duration[robots] = plan.duration

    def _reference(self, robots: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) [m/s] on the way from the old command to the new one."""
        gait, old = self.gait, self.gait.old[robots]
        change = self._command[robots, :2] - old
        size = np.maximum(np.linalg.norm(change, axis=1), 1e-9)
        time = gait.walked[robots] - gait.changed[robots]
        share = np.minimum(1.0, self._config.planner.acceleration * time / size)
        return old + change * share[:, None]

    def _yaw_rate(self, robots: np.ndarray) -> np.ndarray:
        """Commanded yaw rate (n,) [rad/s]; on both feet the robot does not turn."""
        return np.where(self.gait.mode[robots] == WALK, self._command[robots, 2], 0.0)

    # Torques

    def _drive_stand(
        self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return self._drive_both(robots, dynamics, contact, np.zeros((len(robots), 2, 3)))

    def _drive_sway(
        self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        wanted = self._entry.reference(self._sway.of(robots))
        self._sway.elapsed[robots] += self._period
        return self._drive_both(robots, dynamics, contact, wanted)

    def _drive_both(
        self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray, wanted: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """On both feet, with the centre of mass as ``wanted`` (n, 2, 3) from their middle."""
        config = self._config
        position = self._to_heading(dynamics.com[:, :2], robots)
        velocity = self._to_heading(dynamics.com_velocity[:, :2], robots)
        task = config.whole_body.com
        error = wanted[:, :, 0] - (position - self._sway.middle[robots])
        flat = wanted[:, :, 2] + task.kp * error + task.kd * (wanted[:, :, 1] - velocity)
        lift = self._lift(dynamics, dynamics.foot_positions[:, :, 2].mean(axis=1))
        world = np.concatenate([_turn(flat, self.gait.heading[robots]), lift[:, None]], axis=1)
        parts = self._shared(robots, dynamics, world, np.ones(3) * max(task.weight))
        feet = np.tile(_FEET, (len(robots), 1))
        sinking = np.where(contact, 0.0, config.swing.search_velocity)
        parts.append(self._motion.stance(dynamics, feet, sinking))
        return self._solve(dynamics, parts, feet, contact)

    def _drive_walk(
        self, robots: np.ndarray, dynamics: Dynamics, contact: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        gait, config = self.gait, self._config
        left = gait.duration[robots] - gait.elapsed[robots]
        if self._tick % self._ticks_per_plan == 0:
            due = left > config.planner.lock
            self._plan(robots[due], dynamics.of(due))
        stance, everyone = gait.stance[robots], np.arange(len(robots))
        support = dynamics.foot_positions[everyone, stance]
        gait.swing[robots] = swing.advance(
            gait.swing[robots],
            gait.foothold[robots],
            gait.elapsed[robots],
            gait.duration[robots],
            support[:, 2] + config.swing.compression,
            config.step.apex,
            config.swing,
            self._period,
        )
        flat = self.omega**2 * (dynamics.com - support)[:, :2]
        lift = self._lift(dynamics, support[:, 2])
        world = np.concatenate([flat, lift[:, None]], axis=1)
        parts = self._shared(robots, dynamics, world, np.array(config.whole_body.com.weight))
        foot, yaw_rate = 1 - stance, self._yaw_rate(robots)
        heading = gait.heading[robots] + 0.5 * yaw_rate * config.step.time
        parts += [
            self._motion.swing(dynamics, foot, gait.swing[robots]),
            self._motion.swing_rotation(dynamics, foot, heading, yaw_rate),
            self._motion.stance(dynamics, stance[:, None], np.zeros((len(robots), 1))),
        ]
        gait.elapsed[robots] += self._period
        gait.walked[robots] += self._period
        loaded = np.ones((len(robots), 1), dtype=bool)
        return self._solve(dynamics, parts, stance[:, None], loaded)

    def _lift(self, dynamics: Dynamics, ground: np.ndarray) -> np.ndarray:
        """Vertical acceleration (n,) that holds the pendulum's height above the ground."""
        task = self._config.whole_body.com
        height = dynamics.com[:, 2] - ground
        return (
            task.kp * (self._model.nominal_height - height) - task.kd * dynamics.com_velocity[:, 2]
        )

    def _shared(
        self, robots: np.ndarray, dynamics: Dynamics, com: np.ndarray, weight: np.ndarray
    ) -> list[Part]:
        gait = self.gait
        return [
            self._motion.com(dynamics, com, weight),
            self._motion.base(dynamics, gait.heading[robots], self._yaw_rate(robots)),
        ]

    def _solve(
        self, dynamics: Dynamics, parts: list[Part], feet: np.ndarray, loaded: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        with self.clock.part("assembly"):
            problem = self._whole_body.build(dynamics, join(parts), feet, loaded)
        with self.clock.part("solution"):
            return self._whole_body.solve(problem)


def _first_stance(sway: Sway) -> np.ndarray:
    return np.where(sway.side > 0, _LEFT, _RIGHT)


def _turn(vectors: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors (n, 2) turned by angles (n,) [rad]."""
    return np.einsum("nij,nj->ni", about_z(angle)[:, :2, :2], vectors)
