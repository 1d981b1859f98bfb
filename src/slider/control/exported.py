"""A policy from the files of its export, and the stage ``policy_import``, which stores these.

The policy runs in this package's environment, so its robot must be the configured one.
"""

import json
import shutil
from pathlib import Path
from typing import Any, cast

import numpy as np
import onnxruntime

from slider.config.env import EnvConfig, HeightScan
from slider.config.robot import RobotConfig
from slider.control import LAYOUT, ONNX
from slider.control.layout import FORMAT, STATE, VERSION, hardware
from slider.core.errors import UserError, require
from slider.core.files import digest_file, flatten
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.interface import FLOAT64
from slider.env.observations import height_scan
from slider.env.state import RobotState, View


class OnnxController:
    """A policy in an ONNX file, on one thread of the processor, for any number of robots.

    ``scan`` is the grid of its height scan, if it has one.

    Raises:
        UserError: not the file of a policy.
    """

    def __init__(self, path: Path, scan: HeightScan) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        try:
            self._session = onnxruntime.InferenceSession(
                path, options, providers=["CPUExecutionProvider"]
            )
        except Exception:  # onnxruntime raises errors of its own kinds
            raise UserError(f"{path}: expected an ONNX file, found another one") from None
        self._sizes = {item.name: item.shape[-1] for item in self._session.get_inputs()}
        require(STATE in self._sizes, str(path), f"the input {STATE}", ", ".join(self._sizes))
        self._scan = scan

    def reset(self, state: RobotState, velocity: np.ndarray) -> None:
        """Restart, commanded to ``velocity`` (N, 3)."""
        self._state = np.zeros((state.num_robots, self._sizes[STATE]))
        self._velocity = velocity

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Track ``velocity`` (N, 3) from the next call of ``control`` on."""
        self._velocity = velocity

    def control(self, state: RobotState) -> np.ndarray:
        """Desired joint positions (N, 12) [rad or m], once per control period."""
        given: dict[str, Any] = {
            "command": self._velocity,
            "height": state.base_height[:, None],
            STATE: self._state,
        }
        if "height_scan" in self._sizes:
            given["height_scan"] = self._scanned(state)
        feeds = {n: given[n] if n in given else getattr(state, n) for n in self._sizes}
        targets, self._state = cast(list[np.ndarray], self._session.run(None, feeds))
        return targets

    def _scanned(self, state: RobotState) -> np.ndarray:
        view = cast(View, _Seen(state.tensors(FLOAT64), self._scan))
        return height_scan(view).numpy()


class _Seen:
    """The part of a view that the height scan reads."""

    def __init__(self, state: RobotState, scan: HeightScan) -> None:
        self.state, self.scan = state, scan


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Copy the files of an export.

    Raises:
        UserError: a file is not the one that the job was laid out for.
    """
    for name, digest in section["files"].items():
        path = Path(section["folder"]) / name
        same = path.is_file() and digest_file(path) == digest
        require(same, str(path), "the file that the job was laid out for", "another one")
        shutil.copyfile(path, out / name)
    return dict(section["files"])


def read_layout(folder: Path) -> dict[str, Any]:
    """The contract of an export.

    Raises:
        UserError: there is none, or it has another version.
    """
    path = folder / LAYOUT
    try:
        layout = json.loads(path.read_text(encoding="utf-8"))
        found, expected = f"{layout['format']} {layout['version']}", f"{FORMAT} {VERSION}"
    except (OSError, KeyError, TypeError, ValueError):
        raise UserError(f"{path}: expected a layout of this project, found another file") from None
    require(found == expected, str(path), expected, found)
    return layout


def load_exported(folder: Path, robot: RobotConfig, env: EnvConfig) -> OnnxController:
    """Read a policy that is for ``robot`` and ``env``.

    Raises:
        UserError: the layout has another version or another robot.
    """
    layout, own = read_layout(folder), hardware(robot, env)
    wanted, found = (_leaves({name: node.get(name) for name in own}) for node in (own, layout))
    for key in dict.fromkeys([*wanted, *found]):
        value, other = wanted.get(key, "nothing"), found.get(key, "nothing")
        require(value == other, f"{folder / LAYOUT}, {key}", f"{value}, as configured", other)
    return OnnxController(folder / ONNX, env.observation.height_scan)


def _leaves(value: dict[str, Any]) -> dict[str, Any]:
    """Values by dotted key."""

    def named(value: Any) -> Any:
        if isinstance(value, list):
            value = {str(index): item for index, item in enumerate(value)}
        return {n: named(item) for n, item in value.items()} if isinstance(value, dict) else value

    return flatten(named(value))
