"""Run an exported policy in plain MuJoCo: no part of the package slider is needed.

    pip install "mujoco>=3.12" onnxruntime
    python run_policy.py reports/policy --command 0.6 0 0 --seconds 10

Everything comes from four files of the export: policy.onnx, policy.json, reference.npy and
robot.xml. On a robot, replace ``observe`` by the state estimate and ``simulate`` by the
drives.
"""

from __future__ import annotations  # for Python 3.8

import argparse
import json
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


def observe(data: mujoco.MjData) -> dict[str, np.ndarray]:
    """State of the robot; MuJoCo has the linear velocity in world axes, the angular in base's."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
    rotation = rotation.reshape(3, 3)
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return {
        "yaw": yaw,
        "height": data.qpos[2],
        "linear_velocity": rotation.T @ data.qvel[:3],
        "angular_velocity": data.qvel[3:6].copy(),
        "heading_velocity": np.array([[cosine, sine], [-sine, cosine]]) @ data.qvel[:2],
        "gravity": -rotation[2],
        "joint_positions": data.qpos[7:].copy(),
        "joint_velocities": data.qvel[6:].copy(),
    }


def start(folder: Path) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The robot at rest in its nominal pose."""
    layout = json.loads((folder / "policy.json").read_text(encoding="utf-8"))
    try:
        model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    except ValueError as error:
        oldest, reason = layout["simulation"]["mujoco"], str(error).splitlines()[0]
        raise SystemExit(
            f"robot.xml: expected MuJoCo {oldest} or newer, found {mujoco.__version__}: {reason}"
        ) from None
    data = mujoco.MjData(model)
    data.qpos[2] = layout["observation"]["nominal_height"]
    data.qpos[7:] = [joint["nominal"] for joint in layout["action"]["joints"]]
    return model, data


def simulate(
    model: mujoco.MjModel, data: mujoco.MjData, policy: Policy, targets: np.ndarray
) -> None:
    """One control period; actuators carry the names of the motors and take their angles."""
    action = policy.layout["action"]
    target = {joint["name"]: targets[i] for i, joint in enumerate(action["joints"])}
    for motor in action["motors"]:
        angle = sum(share * target[joint] for joint, share in motor["joints"].items())
        data.actuator(motor["name"]).ctrl[0] = angle
    for _ in range(policy.layout["simulation"]["substeps"]):
        mujoco.mj_step(model, data)


def main() -> None:
    """Walk and say how far."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "folder", type=Path, help="policy.onnx, policy.json, robot.xml, reference.npy"
    )
    parser.add_argument("--command", type=float, nargs=3, default=(0.6, 0.0, 0.0))
    parser.add_argument("--seconds", type=float, default=10.0)
    arguments = parser.parse_args()
    policy = Policy(arguments.folder)
    model, data = start(arguments.folder)
    command = np.array(arguments.command)
    for _ in range(round(arguments.seconds / policy.layout["control_period"])):
        simulate(model, data, policy, policy.targets(observe(data), command))
    upright = data.qpos[2] > 0.4
    print(
        f"{'walked' if upright else 'fell'}: {data.time:.1f} s, "
        f"x = {data.qpos[0]:.2f} m, y = {data.qpos[1]:.2f} m, height = {data.qpos[2]:.2f} m"
    )
    raise SystemExit(0 if upright else 1)


if __name__ == "__main__":
    main()
