"""The nominal pose of a leg of a model file: sole level, ankle below the hip, knee bent."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from slider.config.robot import HIP_JOINTS, LEAST_BEND, MAX_TURN
from slider.core.errors import require
from slider.robot.model_foot import Foot

MAX_OFFSET = 1e-3  # largest offset of an ankle from the line below the pitch axis [m]
LEVEL = 0.02  # largest tilt of a level sole [rad]
MAX_TILT = 0.04  # largest tilt of a foot's geometry that counts as level [rad]
_FAR = 0.2  # rotation of a typed foot beyond which the model's zero does not count as level [rad]
_CLOSE = 1e-5  # tolerance of a solved pose [rad], [m]
_BEND = 0.5  # default bend of knees [rad]


class LegPose:
    """A leg of a compiled model; moves its joints, which are given by role. ``base`` is a body id.

    ``forward`` (3, 3) rotates the model's base axes to those of slider, ``line`` is the y of the
    foot line in them [m], by default that of the last ankle joint's anchor. ``levelled`` is the
    tilt of the sole in the zero pose [rad] that the solved pose compensates.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: Any,
        base: int,
        joints: Mapping[str, int],
        knee: bool,
        forward: np.ndarray,
        line: float | None,
    ) -> None:
        self._model, self._data, self._base, self._joints = model, data, base, joints
        self._knee, self._forward, self._line = knee, forward, line
        self._last = "ankle_roll" if "ankle_roll" in joints else "ankle"
        self._foot_body = model.jnt_bodyid[joints[self._last]]
        zero = mujoco.MjData(model)
        mujoco.mj_kinematics(model, zero)
        self.levelled, self._tilt = 0.0, self._sole_tilt(zero)
        self._level = Rotation.from_rotvec([0.0, self._tilt, 0.0]).as_matrix() @ self._foot(zero)

    def solve(self, typed: Sequence[str], bend: float | None) -> dict[str, float]:
        """Set and return joint angles by role that change; empty if the pose is already valid.

        A ``typed`` yaw, roll or knee is kept. The sole gets its orientation in the model's zero
        pose, levelled by its geometry, or, if a typed ankle rotates it far from there, that in the
        given pose. ``bend`` is the knee flexion [rad]; None: that of the pose, or 0.5 if the leg is
        straight or the knee hyperextended.

        Raises:
            UserError: there is no valid pose.
        """
        model, data = self._model, self._data
        mujoco.mj_kinematics(model, data)
        across = ["hip_pitch", "ankle", *["slide"] * self._knee]
        if any(abs(self._seen(name)[1][1]) < np.cos(np.deg2rad(MAX_TURN)) for name in across):
            return {}  # rejected later because of its axis
        bends = bend is not None
        if self._knee and not bends:  # bend only a knee that is on the line from hip to ankle
            leg, shank = self._sides()
            off = np.linalg.norm(np.cross(leg, shank)) / (leg @ leg)
            bends = bool(off < LEAST_BEND) or ("slide" not in typed and self._hyperextended())
        far = "ankle" in typed and self.foot_rotation() > _FAR
        level = self._foot(data) if far else self._level
        start = {name: float(data.qpos[self._place(name)]) for name in self._joints}
        if bends and self._knee:
            self._bend(_BEND if bend is None else bend)
        solved = [n for n in HIP_JOINTS if n in self._joints and n not in typed]
        solved = [*dict.fromkeys([*solved, "hip_pitch", "ankle"])]

        def missed(angles: Sequence[float]) -> np.ndarray:
            for name, angle in zip(solved, angles, strict=True):
                data.qpos[self._place(name)] = angle
            mujoco.mj_kinematics(model, data)
            turned = Rotation.from_matrix(self._foot(data) @ level.T).as_rotvec()
            return np.append(turned, (self._on_line("ankle") - self._on_line("hip_pitch"))[0])

        first = [start[name] for name in solved]
        *turned, ahead = missed(first)
        level_enough = "ankle" in typed or np.linalg.norm(turned) <= LEVEL
        if not bends and level_enough and abs(ahead) <= MAX_OFFSET:
            return {}
        found = least_squares(missed, first, xtol=1e-14, ftol=1e-14)
        rest = np.abs(missed(np.round(found.x, 6) + 0.0)).max()  # the same on every machine
        expected = "a pose with a level sole and the ankle below the pitch axis, or angles near one"
        require(rest < _CLOSE, "robot.roles.pose", expected, f"one that misses it by {rest:.3g}")
        self.levelled = 0.0 if far else self._tilt
        now = {name: float(data.qpos[self._place(name)]) for name in self._joints}
        return {name: value for name, value in now.items() if value != start[name]}

    def foot_rotation(self) -> float:
        """Rotation angle of the foot between the current pose and the model's zero pose [rad]."""
        return float(Rotation.from_matrix(self._foot(self._data) @ self._level.T).magnitude())

    def _place(self, name: str) -> int:
        return self._model.jnt_qposadr[self._joints[name]]

    def _foot(self, data: Any) -> np.ndarray:
        """Rotation (3, 3) of the foot in the base frame."""
        base, own = (data.xmat[body].reshape(3, 3) for body in (self._base, self._foot_body))
        return self._forward @ base.T @ own

    def _seen(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) relative to the base and axis (3,) of a joint."""
        data, index = self._data, self._joints[name]
        turn = self._forward @ data.xmat[self._base].reshape(3, 3).T
        place = data.xanchor[index] - data.xpos[self._base]
        return turn @ place, turn @ data.xaxis[index]

    def _on_line(self, name: str) -> np.ndarray:
        """Point (3,) of a joint's axis that has the foot line's y."""
        place, axis = self._seen(name)
        line = self._seen(self._last)[0][1] if self._line is None else self._line
        return place + axis * (line - place[1]) / axis[1]

    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Vectors (3,) from pitch axis and knee to the ankle, at the foot line's y."""
        ankle = self._on_line("ankle")
        return ankle - self._on_line("hip_pitch"), ankle - self._on_line("slide")

    def _bend(self, angle: float) -> None:
        """Bend the knee by an angle [rad] from the straight leg, towards its mid-range."""
        straight, index = self._straight(), self._joints["slide"]
        middle = self._model.jnt_range[index].mean() if self._model.jnt_limited[index] else 0.0
        sense = 1.0 if middle >= straight - _CLOSE else -1.0
        self._data.qpos[self._place("slide")] = round(straight + sense * angle, 6)

    def _hyperextended(self) -> bool:
        """Whether the knee is bent to a side on which its range ends within 0.5 rad."""
        index, straight = self._joints["slide"], self._straight()
        low, high = self._model.jnt_range[index]
        end = low if self._data.qpos[self._place("slide")] < straight else high
        return bool(self._model.jnt_limited[index] and abs(end - straight) < _BEND)

    def _straight(self) -> float:
        """Position of the knee at which the leg is straight [rad]."""
        (leg, shank), axis = self._sides(), self._seen("slide")[1]
        thigh, shank = (part - (part @ axis) * axis for part in (leg - shank, shank))
        flexion = np.arctan2(np.cross(thigh, shank) @ axis, thigh @ shank)
        return float(self._data.qpos[self._place("slide")] - flexion)

    def _sole_tilt(self, zero: Any) -> float:
        """Angle [rad] about y that levels the foot's geometry in the zero pose; 0 if level."""
        parents, below = self._model.body_parentid, []
        for body in range(self._model.nbody):
            if body == self._foot_body or parents[body] in below:
                below.append(body)
        turn = self._forward @ zero.xmat[self._base].reshape(3, 3).T
        shape = Foot(zero, np.array(below), zero.xpos[self._base], turn)
        tilt = shape.tilt() if shape else 0.0
        return tilt if abs(tilt) > MAX_TILT else 0.0
