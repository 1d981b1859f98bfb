"""Run an exported policy in plain MuJoCo: no part of the package slider is needed.

    pip install "mujoco>=3.12" onnxruntime
    python run_policy.py reports/policy --velocity 0.6 0 0 --seconds 10 --onboard

Everything comes from four files of the export: policy.onnx, policy.json, reference.npy and
robot.xml. With --onboard the state is estimated from inertial unit, encoders and motor torques;
on a robot, replace ``Simulation.measure`` by its sensors and ``Simulation.move`` by its drives.
"""

from __future__ import annotations  # for Python 3.8

import argparse
import json
import time
from pathlib import Path

import mujoco
import numpy as np
import onnxruntime


class Policy:
    """The network and its state between control steps."""

    def __init__(self, folder: Path) -> None:
        if not (folder / "policy.json").is_file():
            raise SystemExit(f"expected policy.json and the files that it names in {folder}")
        self.layout = json.loads((folder / "policy.json").read_text(encoding="utf-8"))
        self.session = onnxruntime.InferenceSession(
            str(folder / "policy.onnx"), providers=["CPUExecutionProvider"]
        )
        joints = self.layout["action"]["joints"]
        self.nominal, self.scale, self.lower, self.upper = (
            np.array([joint[key] for joint in joints])
            for key in ("nominal", "scale", "lower", "upper")
        )
        self.reference = np.load(folder / self.layout["reference"]["file"])
        self.phase = 0.0
        self.halted = False
        self.command = np.zeros(3)
        self.action = self.earlier_action = np.zeros(len(joints))
        self.filtered = np.zeros(2)
        self.velocity = np.zeros(2)  # reference: on the way from one command to the next
        self.expected = np.zeros(2)
        self.heading_target: float | None = None  # set at the start

    def targets(self, state: dict[str, np.ndarray], command: np.ndarray) -> np.ndarray:
        """Desired joint positions, once per control period; command: vx, vy, yaw rate."""
        if self.heading_target is None:
            self.heading_target = float(state["yaw"])
            self.halted = self._standing_commanded(command)  # a robot starts at rest
        else:
            self._advance(state, self.command)  # of the period that is over
        if self.layout["reference"]["acceleration"] == 0:
            self.velocity = np.array(command[:2], dtype=float)
        self.command = command
        action_layout, layout = self.layout["action"], self.layout["observation"]
        mirrored = self._mirrored()
        values = self.terms(state, command)
        for term in layout["terms"]:
            if term["name"] not in values:
                raise SystemExit(f"expected a value of {term['name']} here: {term['meaning']}")
        observation = np.concatenate(
            [np.atleast_1d(values[term["name"]]) * term["scale"] for term in layout["terms"]]
        )
        if mirrored:
            observation = reflect(observation, layout["mirror"])
        observation = np.clip(observation, -layout["clip"], layout["clip"]).astype(np.float32)
        network = self.layout["network"]
        action = self.session.run(None, {network["input"]: observation[None]})[0][0].astype(float)
        action = np.clip(action, -action_layout["clip"], action_layout["clip"])
        if mirrored:
            action = reflect(action, action_layout["mirror"])
        self.earlier_action = self.action
        self.action = np.where(self.scale > 0, action, 0.0)
        origin = self._reference()
        return np.clip(origin + self.scale * self.action, self.lower, self.upper)

    def _reference(self) -> np.ndarray:
        """Joint positions of a zero action at the present phase."""
        if self.halted:
            return np.array(self.layout["reference"]["standing"])
        half = self.reference.shape[3] // 2
        step = int(self.phase >= 0.5)
        sample = (2.0 * self.phase - step) * (half - 1)
        before = min(int(sample), half - 2)
        rows = self.reference[:, :, :, step * half + before : step * half + before + 2]
        between = rows[..., 0, :] + (sample - before) * (rows[..., 1, :] - rows[..., 0, :])
        return trilinear(self.layout["reference"], between, [*self.velocity, self.command[2]])

    def _advance(self, state: dict[str, np.ndarray], command: np.ndarray) -> None:
        clock, period = self.layout["clock"], self.layout["control_period"]
        if clock is not None:
            phase = self.phase + period / (2.0 * step_time(clock, [*self.velocity, command[2]]))
            change = np.ceil(2.0 * self.phase) / 2.0
            halt = clock["halt"]
            slow = self.halted or np.hypot(*self.filtered) < halt["below"]
            slow = slow and np.hypot(*state["heading_velocity"]) < halt["above"]
            self.halted = self._standing_commanded(command) and slow and phase >= change
            self.phase = (change if self.halted else phase) % 1.0
        self.heading_target += command[2] * period
        change = self.layout["reference"]["acceleration"] * period
        way = command[:2] - self.velocity
        self.velocity = self.velocity + (np.clip(way, -change, change) if change > 0 else way)
        gain = self.layout["observation"]["velocity_filter"]["gain"]
        self.filtered = self.filtered + gain * (state["heading_velocity"] - self.filtered)
        self.expected = self.expected + gain * (self.velocity - self.expected)

    def _standing_commanded(self, command: np.ndarray) -> bool:
        clock = self.layout["clock"]
        return clock is not None and clock["halt"]["below"] > 0 and not command.any()

    def _mirrored(self) -> bool:
        clock = self.layout["clock"]
        return clock is not None and clock["mirror"] and self.phase >= 0.5

    def terms(self, state: dict[str, np.ndarray], command: np.ndarray) -> dict[str, np.ndarray]:
        """Terms of observations before scaling; the layout has the meaning of each."""
        error = (self.heading_target - state["yaw"] + np.pi) % (2.0 * np.pi) - np.pi
        angle = 2.0 * np.pi * self.phase
        layout = self.layout["observation"]
        difference = self.filtered - self.expected
        grid = layout["height_scan"]
        points = grid["points_x"] * grid["points_y"]
        return {
            "base_linear_velocity": state["linear_velocity"],
            "target_linear_velocity": np.array([command[0], command[1], 0.0]),
            "base_angular_velocity": state["angular_velocity"],
            "target_angular_velocity": np.array([0.0, 0.0, command[2]]),
            "projected_gravity": state["gravity"],
            "command": np.array([*command, error]),
            "joint_positions": state["joint_positions"] - self.nominal,
            "joint_velocities": state["joint_velocities"],
            "previous_action": self.action,
            "action_before_previous": self.earlier_action,
            "base_height": state["height"] - layout["nominal_height"],
            "filtered_velocity": self.filtered,
            "reference_velocity": self.velocity,
            "velocity_error": np.tanh(difference / layout["velocity_error"]["range"]),
            "phase": np.array([np.sin(angle), np.cos(angle)]) * (not self.halted),
            "height_scan": np.full(points, state["height"]),  # flat ground
        }


def reflect(values: np.ndarray, mirror: dict) -> np.ndarray:
    """The same seen in a mirror at the plane between the legs."""
    return values[mirror["permutation"]] * mirror["sign"]


def step_time(clock: dict, command: list[float]) -> float:
    """Duration of a step at a command."""
    return float(trilinear(clock, np.array(clock["step_time"])[..., None], command)[0])


def trilinear(grid: dict, values: np.ndarray, command: list[float]) -> np.ndarray:
    """Values (nx, ny, nw, k) at vx, vy, yaw rate: (k,); the border's outside the grid."""
    for index, name in enumerate(("vx", "vy", "yaw_rate")):
        axis = grid[name]
        place = np.interp(command[index], axis, np.arange(len(axis)))
        low = min(int(place), max(len(axis) - 2, 0))
        high = min(low + 1, len(axis) - 1)
        values = values[low] + (place - low) * (values[high] - values[low])
    return values


def state_of(
    quaternion: np.ndarray, velocity: np.ndarray, height: float, sensors: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """What the policy observes; ``velocity`` of the base in world axes [m/s]."""
    rotation = rotation_of(quaternion)
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return {
        "yaw": yaw,
        "height": height,
        "linear_velocity": rotation.T @ velocity,
        "angular_velocity": sensors["angular_velocity"],
        "heading_velocity": np.array([[cosine, sine], [-sine, cosine]]) @ velocity[:2],
        "gravity": -rotation[2],
        "joint_positions": sensors["joint_positions"],
        "joint_velocities": sensors["joint_velocities"],
    }


def rotation_of(quaternion: np.ndarray) -> np.ndarray:
    """Base to world (3, 3) of w, x, y, z."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, quaternion)
    return rotation.reshape(3, 3)


class Estimator:
    """Kalman filter of velocity and height from the sensors on board.

    The inertial unit's velocity increment predicts; a foot that carries weight, and so rests at the
    lower of its ends, corrects. MuJoCo gives the kinematics of the legs.
    """

    def __init__(self, layout: dict, model: mujoco.MjModel) -> None:
        if layout.get("estimator") is None:
            expected = "expected the settings of an estimator in policy.json"
            raise SystemExit(f"{expected}, found none (legs with knees have none)")
        self.settings, self.model = layout["estimator"], model
        self.period, self.gravity = layout["control_period"], -model.opt.gravity[2]
        self.data = mujoco.MjData(model)  # of the kinematics
        self.data.qpos[:3] = 0.0  # the base stays at the origin
        names = [joint["name"] for joint in layout["action"]["joints"]]
        self.sides = ("left", "right")
        self.slides = [names.index(f"{side}_slide") for side in self.sides]
        motors = layout["action"]["motors"]
        self.efforts = np.array(
            [[motor["joints"].get(names[slide], 0.0) for motor in motors] for slide in self.slides]
        )
        self.velocity, self.height = np.zeros(3), 0.0
        self.variance, self.forces, self.rates = np.zeros(2), np.zeros(2), np.zeros(2)
        self.started = False

    def update(self, sensors: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """State from sensors, once per control period."""
        settings, rotation = self.settings, rotation_of(sensors["quaternion"])
        velocities, heights, axes, turning = self._legs(sensors)
        certainty = self._certainty(sensors, rotation, heights, axes, turning)
        elapsed = self.period if self.started else 0.0
        velocity = self.velocity + rotation @ sensors["velocity_increment"]
        velocity[2] -= self.gravity * elapsed
        height = self.height + velocity[2] * elapsed
        deviations = np.array([settings["acceleration"], settings["vertical_velocity"]])
        variance = self.variance + (deviations * elapsed) ** 2
        slip = ((velocities - velocity) ** 2).sum(1) / settings["slip"] ** 2
        information = certainty**2 / (1.0 + slip)
        share = information / max(information.sum(), 1e-12)
        noise = np.array([settings["leg_velocity"], settings["leg_height"]]) ** 2
        gain = variance * information.sum() / (variance * information.sum() + noise)
        gain = gain if self.started else np.ones(2)
        self.velocity = velocity + gain[0] * (share @ velocities - velocity)
        self.height = height + gain[1] * (share @ heights - height)
        self.variance = (1.0 - gain) * variance + (0.0 if self.started else noise)
        self.started = True
        return state_of(sensors["quaternion"], self.velocity, self.height, sensors)

    def _legs(self, sensors: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
        """Velocity (2, 3), height (2,) of the base by each leg; axes (2, 3), their turning (2,)."""
        model, data = self.model, self.data
        data.qpos[3:7], data.qpos[7:] = sensors["quaternion"], sensors["joint_positions"]
        data.qvel[3:6], data.qvel[6:] = sensors["angular_velocity"], sensors["joint_velocities"]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_fwdVelocity(model, data)
        velocities, axes, motion = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(6)
        heights, turning = np.zeros(2), np.zeros(2)
        for leg, side in enumerate(self.sides):
            foot, line = data.body(f"{side}_foot"), data.geom(f"{side}_foot")
            radius, half = model.geom(f"{side}_foot").size[:2]
            along = half * line.xmat.reshape(3, 3)[:, 2]
            ends = line.xpos + np.array([-along, along]) - [0.0, 0.0, radius]
            share = 1.0 / (1.0 + np.exp((ends[:, 2] - ends[::-1, 2]) / 0.002))  # the lower end
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, foot.id, motion, 0)
            velocities[leg] = -share @ (motion[3:] + np.cross(motion[:3], ends - foot.xpos))
            heights[leg] = -share @ ends[:, 2]
            tube = data.body(f"{side}_slide")
            axes[leg] = tube.xmat.reshape(3, 3)[:, 2]
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, tube.id, motion, 0)
            turning[leg] = np.linalg.norm(np.cross(motion[:3], axes[leg]))
        return velocities, heights, axes, turning

    def _certainty(
        self,
        sensors: dict[str, np.ndarray],
        rotation: np.ndarray,
        heights: np.ndarray,
        axes: np.ndarray,
        turning: np.ndarray,
    ) -> np.ndarray:
        """How certainly each foot stands (2,), by the momentum of tube and rotors."""
        settings, rates = self.settings, sensors["joint_velocities"][self.slides]
        before, self.rates = self.rates, rates
        if not self.started:
            return 1.0 * (heights == heights.max())
        change = (rates - before) / self.period
        pull = settings["mass"] * (axes @ rotation @ sensors["velocity_increment"]) / self.period
        slides = sensors["joint_positions"][self.slides]
        pull = pull + (settings["moment"] + settings["mass"] * slides) * turning**2
        force = self.efforts @ sensors["motor_torques"]
        force = force - 0.5 * settings["damping"] * (rates + before)
        force = force + pull - (settings["mass"] + settings["reflected_mass"]) * change
        follow = min(1.0, self.period / max(settings["force_filter"], 1e-6))
        self.forces = self.forces + follow * (force * axes[:, 2] - self.forces)
        low, high = settings["lifted"], settings["loaded"]
        return np.clip((self.forces / settings["weight"] - low) / (high - low), 0.0, 1.0)


class Simulation:
    """The robot, at rest in its nominal pose at first, with perfect sensors."""

    def __init__(self, folder: Path, layout: dict) -> None:
        self.layout = layout
        try:
            self.model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
        except ValueError as error:
            oldest, reason = layout["simulation"]["mujoco"], str(error).splitlines()[0]
            raise SystemExit(
                f"robot.xml: expected MuJoCo {oldest} or newer, found {mujoco.__version__}: "
                f"{reason}"
            ) from None
        self.data = mujoco.MjData(self.model)
        self.data.qpos[2] = layout["observation"]["nominal_height"]
        self.data.qpos[7:] = [joint["nominal"] for joint in layout["action"]["joints"]]
        self.torques = np.zeros(len(layout["action"]["motors"]))
        self.increment = np.zeros(3)

    def move(self, targets: np.ndarray) -> None:
        """One control period; actuators carry the names of the motors and take their angles."""
        action, substeps = self.layout["action"], self.layout["simulation"]["substeps"]
        target = {joint["name"]: targets[i] for i, joint in enumerate(action["joints"])}
        for motor in action["motors"]:
            angle = sum(share * target[joint] for joint, share in motor["joints"].items())
            self.data.actuator(motor["name"]).ctrl[0] = angle
        velocity, torques, speeds = self.data.qvel[:3].copy(), [], self.motor_speeds()
        for _ in range(substeps):
            before = speeds
            mujoco.mj_step(self.model, self.data)
            speeds = self.motor_speeds()
            demanded = [self.data.actuator(m["name"]).force[0] for m in action["motors"]]
            torques.append(self.acting(np.array(demanded), before, speeds - before))
        self.torques = np.mean(torques, axis=0)
        gained = self.data.qvel[:3] - velocity
        gained -= self.model.opt.gravity * substeps * self.model.opt.timestep
        self.increment = rotation_of(self.data.qpos[3:7]).T @ gained

    def motor_speeds(self) -> np.ndarray:
        """By those of the joints [rad/s]."""
        rates = {joint["name"]: i for i, joint in enumerate(self.layout["action"]["joints"], 6)}
        motors = [motor["joints"].items() for motor in self.layout["action"]["motors"]]
        return np.array([sum(s * self.data.qvel[rates[j]] for j, s in own) for own in motors])

    def acting(self, demanded: np.ndarray, speed: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Torques that act while MuJoCo integrates, of those demanded at the start of a step.

        They fall with the speed: by the damping of the loop, at the limit of the voltage by the
        torque-speed line, at the limit of the torque not at all.
        """
        names = ("kd", "torque_limit", "stall_torque", "no_load_speed")
        motors = self.layout["action"]["motors"]
        damping, limit, stall, free = (
            np.array([motor[name] for motor in motors]) for name in names
        )
        by_voltage = np.abs(demanded / stall + speed / free) > 1.0 - 1e-9
        slope = np.where(by_voltage, stall / free, damping)
        return demanded - np.where(np.abs(demanded) > (1.0 - 1e-9) * limit, 0.0, slope) * change

    def measure(self) -> dict[str, np.ndarray]:
        """Inertial unit, encoders, motor torques; MuJoCo turns in axes of the base."""
        return {
            "quaternion": self.data.qpos[3:7].copy(),
            "angular_velocity": self.data.qvel[3:6].copy(),
            "velocity_increment": self.increment,  # of the specific force, in axes of the base
            "joint_positions": self.data.qpos[7:].copy(),
            "joint_velocities": self.data.qvel[6:].copy(),
            "motor_torques": self.torques,  # mean of the control period
        }

    def has_fallen(self) -> bool:
        """Whether the base is tilted by 45°, is half as high, or MuJoCo gave up and began anew."""
        upright = rotation_of(self.data.qpos[3:7])[2, 2] > np.sqrt(0.5)
        high = self.data.qpos[2] > 0.5 * self.layout["observation"]["nominal_height"]
        bad = mujoco.mjtWarning
        given_up = (bad.mjWARN_BADQPOS, bad.mjWARN_BADQVEL, bad.mjWARN_BADQACC)
        return not (upright and high) or any(self.data.warning[kind].number for kind in given_up)

    def state(self) -> dict[str, np.ndarray]:
        """The true state."""
        qpos, qvel = self.data.qpos, self.data.qvel
        return state_of(qpos[3:7].copy(), qvel[:3].copy(), float(qpos[2]), self.measure())


def number(text: str) -> float:
    """A finite number."""
    if not np.isfinite(float(text)):
        raise ValueError
    return float(text)


def duration(text: str) -> float:
    """A finite number above zero."""
    if number(text) <= 0.0:
        raise ValueError
    return float(text)


def main() -> None:
    """Walk and say how far; status 1 if the robot fell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "folder", type=Path, help="policy.onnx, policy.json, robot.xml, reference.npy"
    )
    parser.add_argument("--velocity", type=number, nargs=3, default=(0.6, 0.0, 0.0))
    parser.add_argument("--seconds", type=duration, default=10.0)
    parser.add_argument("--onboard", action="store_true", help="estimate the state from sensors")
    arguments = parser.parse_args()
    policy = Policy(arguments.folder)
    robot = Simulation(arguments.folder, policy.layout)
    estimator = Estimator(policy.layout, robot.model) if arguments.onboard else None
    command, times, errors = np.array(arguments.velocity), [], []
    for step in range(max(1, round(arguments.seconds / policy.layout["control_period"]))):
        sensors, state = robot.measure(), robot.state()
        if estimator is not None:
            begin = time.perf_counter()
            estimate = estimator.update(sensors)
            times.append(1e3 * (time.perf_counter() - begin))
            errors.append(estimate["linear_velocity"] - state["linear_velocity"])
            state = estimate
        robot.move(policy.targets(state, command))
        if robot.has_fallen():
            raise SystemExit(f"fell after {(step + 1) * policy.layout['control_period']:.2f} s")
    data = robot.data
    if estimator is not None:
        error = np.sqrt(np.mean(np.square(errors), axis=0))
        print(
            f"estimator: {np.percentile(times, 50):.3f} ms per tick, "
            f"99.9 % in {np.percentile(times, 99.9):.3f} ms; "
            f"error of vx, vy: {error[0]:.4f}, {error[1]:.4f} m/s RMS"
        )
    print(
        f"walked: {data.time:.1f} s, "
        f"x = {data.qpos[0]:.2f} m, y = {data.qpos[1]:.2f} m, height = {data.qpos[2]:.2f} m"
    )


if __name__ == "__main__":
    main()
