"""Run an exported policy in plain MuJoCo: no part of the package slider is needed.

    pip install "mujoco>=3.12" onnxruntime
    python run_policy.py docs/policy --velocity 0.6 0 0 --seconds 10 --onboard

policy.json is the contract of policy.onnx, estimator.onnx and robot.xml. With --onboard, velocity
and height are estimated; on a robot, replace ``Simulation.measure`` and ``move``.
"""

from __future__ import annotations  # for Python 3.8

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np
import onnxruntime


class Graph:
    """A graph of an export, with its state and the time of its last call."""

    def __init__(self, folder: Path, name: str, contract: dict) -> None:
        path, providers = str(folder / name), ["CPUExecutionProvider"]
        self.session = onnxruntime.InferenceSession(path, providers=providers)
        self.inputs = contract["graphs"][name]["inputs"]
        self.period = contract["control_period"]
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.time, self.outputs = -np.inf, []
        self.state = np.zeros((1, self.session.get_inputs()[-1].shape[1]))

    def __call__(self, now: float, readings: dict[str, np.ndarray]) -> list[np.ndarray]:
        """Outputs at a time [s], about a control period after the last call.

        A missed period is made up for. After a pause, or where time went back, all begins anew.
        """
        if not -0.5 * self.period <= now - self.time <= 10.0 * self.period:
            self.reset()
            self.time = now - self.period
        steps = round((now - self.time) / self.period)
        feeds = {name: np.reshape(readings[name], (1, -1)) for name in self.inputs}
        for _ in range(steps):
            *self.outputs, self.state = self.session.run(None, {**feeds, "state": self.state})
            self.time += self.period
        return [output[0] for output in self.outputs]


class Simulation:
    """The robot, at rest in its default pose at first, with perfect sensors."""

    def __init__(self, folder: Path, contract: dict) -> None:
        given, self.motors = contract["simulation"], contract["motors"]
        try:
            self.model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
        except ValueError as error:
            expected = f"expected MuJoCo {given['mujoco']} or newer, found {mujoco.__version__}"
            raise SystemExit(f"robot.xml: {expected}: {str(error).splitlines()[0]}") from None
        period, timestep = contract["control_period"], self.model.opt.timestep
        self.substeps = round(period / timestep)
        if abs(self.substeps * timestep - period) > 1e-9:
            expected = f"expected a time step that divides the control period of {period} s"
            raise SystemExit(f"robot.xml: {expected}, found {timestep}")
        self.data = mujoco.MjData(self.model)
        self.names = [joint["name"] for joint in contract["joints"]]
        self.places = [int(self.model.joint(name).qposadr[0]) for name in self.names]
        self.rates = [int(self.model.joint(name).dofadr[0]) for name in self.names]
        self.data.qpos[2] = self.height = given["base_height"]
        self.data.qpos[self.places] = [joint["default"] for joint in contract["joints"]]
        self.torques, self.increment, self.elapsed = np.zeros(len(self.motors)), np.zeros(3), 0.0

    def move(self, targets: np.ndarray) -> None:
        """One control period; actuators carry the names of the motors and take their angles."""
        target = {name: targets[i] for i, name in enumerate(self.names)}
        actuators = [self.data.actuator(motor["name"]) for motor in self.motors]
        for i, motor in enumerate(self.motors):
            actuators[i].ctrl[0] = sum(s * target[joint] for joint, s in motor["joints"].items())
        start, before, torques = self.data.time, self.data.qvel[:3].copy(), []
        for _ in range(self.substeps):
            mujoco.mj_step(self.model, self.data)
            torques.append([actuator.force[0] for actuator in actuators])
        self.torques, self.elapsed = np.mean(torques, axis=0), self.data.time - start
        gained = self.data.qvel[:3] - before - self.model.opt.gravity * self.elapsed
        self.increment = self.rotation().T @ gained

    def measure(self) -> dict[str, np.ndarray]:
        """Inertial unit, encoders, motor torques; the last two are the true state."""
        return {
            "quaternion": self.data.qpos[3:7],
            "angular_velocity": self.data.qvel[3:6],  # in the base frame, as MuJoCo has it
            "velocity_increment": self.increment,  # of the specific force, in the base frame
            "joint_positions": self.data.qpos[self.places],
            "joint_velocities": self.data.qvel[self.rates],
            "motor_torques": self.torques,  # mean of the control period
            "elapsed": self.elapsed,
            "linear_velocity": self.rotation().T @ self.data.qvel[:3],
            "height": self.data.qpos[2],
        }

    def rotation(self) -> np.ndarray:
        """Base to world (3, 3)."""
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, self.data.qpos[3:7])
        return rotation.reshape(3, 3)

    def has_fallen(self) -> bool:
        """Whether the base is tilted by 45°, is half as high, or MuJoCo gave up and began anew."""
        upright = self.rotation()[2, 2] > np.sqrt(0.5) and self.data.qpos[2] > 0.5 * self.height
        return not upright or any(self.data.warning[k].number for k in (3, 4, 5))


def main() -> None:
    """Walk and say how far; status 1 if the robot fell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="with policy.json and the files that it names")
    parser.add_argument("--velocity", type=float, nargs=3, default=(0.6, 0.0, 0.0))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--onboard", action="store_true", help="estimate the state from sensors")
    arguments = parser.parse_args()
    folder = arguments.folder
    if not (folder / "policy.json").is_file():
        parser.error(f"expected policy.json in {folder}")
    contract = json.loads((folder / "policy.json").read_text("utf-8"))
    policy, robot = Graph(folder, "policy.onnx", contract), Simulation(folder, contract)
    estimator, errors = Graph(folder, "estimator.onnx", contract), []
    while (now := robot.data.time) < arguments.seconds - 1e-9:
        readings = robot.measure()
        if arguments.onboard:
            velocity, height = estimator(now, readings)
            errors.append(velocity - readings["linear_velocity"])
            readings.update(linear_velocity=velocity, height=height)
        (targets,) = policy(now, {**readings, "command": np.array(arguments.velocity)})
        robot.move(targets)
        if robot.has_fallen():
            raise SystemExit(f"fell after {robot.data.time:.2f} s")
    if errors:
        vx, vy, _ = np.sqrt(np.mean(np.square(errors), axis=0))
        print(f"estimator: error of vx, vy: {vx:.4f}, {vy:.4f} m/s RMS")
    x, y = robot.data.qpos[:2]
    print(f"walked: {robot.data.time:.1f} s, x = {x:.2f} m, y = {y:.2f} m")


if __name__ == "__main__":
    main()
