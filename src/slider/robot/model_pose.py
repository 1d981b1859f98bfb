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

MAX_OFFSET = 1e-3  # of an ankle from the line below the pitch axis [m]
LEVEL = 0.02  # that a sole may be off [rad]
_FAR = 0.2  # of a typed foot from the model's own zero, which is then not level [rad]
_CLOSE = 1e-5  # tolerance of a solved pose [rad], [m]
_BEND = 0.5  # default bend of knees [rad]


class LegPose:
    """A leg of a compiled model, whose joints (by role) it moves; ``base`` is a body.

    ``forward`` (3, 3) turns the base's axes into ours, ``line`` is the foot line's y in them [m],
    by default that of the anchor of the ankle, or of its roll.
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
        zero = mujoco.MjData(model)
        mujoco.mj_kinematics(model, zero)
        self._level = self._foot(zero)

    def solve(self, typed: Sequence[str], bend: float | None) -> dict[str, float]:
        """Angles by role that the data get in place of theirs; none where the pose is one already.

        A ``typed`` yaw, roll or knee stays. The sole is level as in the model's own zero, or with a
        typed ankle that turns it far from there as in the pose. ``bend`` is that of the knee from
        the straight leg [rad]; null: the pose's, or 0.5 if it is straight.

        Raises:
            UserError: there is no such pose.
        """
        model, data = self._model, self._data
        mujoco.mj_kinematics(model, data)
        across = ["hip_pitch", "ankle", *["slide"] * self._knee]
        if any(abs(self._seen(name)[1][1]) < np.cos(np.deg2rad(MAX_TURN)) for name in across):
            return {}  # to be refused for its axis
        bends = bend is not None
        if self._knee and not bends:  # unless it is off the line from hip to ankle already
            leg, shank = self._sides()
            off = np.linalg.norm(np.cross(leg, shank)) / (leg @ leg)
            bends = bool(off < LEAST_BEND)
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
        now = {name: float(data.qpos[self._place(name)]) for name in self._joints}
        return {name: value for name, value in now.items() if value != start[name]}

    def foot_rotation(self) -> float:
        """Angle of the foot between the data's pose and the model's own zero [rad]."""
        return float(Rotation.from_matrix(self._foot(self._data) @ self._level.T).magnitude())

    def _place(self, name: str) -> int:
        return self._model.jnt_qposadr[self._joints[name]]

    def _foot(self, data: Any) -> np.ndarray:
        """Rotation (3, 3) of the foot in the base's frame."""
        foot = self._model.jnt_bodyid[self._joints[self._last]]
        base, own = (data.xmat[body].reshape(3, 3) for body in (self._base, foot))
        return self._forward @ base.T @ own

    def _seen(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Place (3,) from the base and axis (3,) of a joint."""
        data, index = self._data, self._joints[name]
        turn = self._forward @ data.xmat[self._base].reshape(3, 3).T
        place = data.xanchor[index] - data.xpos[self._base]
        return turn @ place, turn @ data.xaxis[index]

    def _on_line(self, name: str) -> np.ndarray:
        """The point (3,) of a joint's axis with the foot line's y."""
        place, axis = self._seen(name)
        line = self._seen(self._last)[0][1] if self._line is None else self._line
        return place + axis * (line - place[1]) / axis[1]

    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """From the pitch axis to the ankle (3,), at the foot line's y; likewise from the knee."""
        ankle = self._on_line("ankle")
        return ankle - self._on_line("hip_pitch"), ankle - self._on_line("slide")

    def _bend(self, angle: float) -> None:
        """Bend the knee by an angle [rad] from the straight leg, in the sense of its range."""
        (leg, shank), axis = self._sides(), self._seen("slide")[1]
        thigh, shank = (part - (part @ axis) * axis for part in (leg - shank, shank))
        flexion = np.arctan2(np.cross(thigh, shank) @ axis, thigh @ shank)
        index, place = self._joints["slide"], self._place("slide")
        straight = float(self._data.qpos[place] - flexion)
        middle = self._model.jnt_range[index].mean() if self._model.jnt_limited[index] else 0.0
        sense = 1.0 if middle >= straight else -1.0
        self._data.qpos[place] = round(straight + sense * angle, 6)
