"""A policy from the files of its export, and the stage ``policy_import``, which stores these.

It runs in this package's environment, so its layout must be that of the configured robot and env.
"""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import torch

from slider.config.env import EnvConfig
from slider.config.robot import RobotConfig
from slider.control import LAYOUT, ONNX, REFERENCE
from slider.control.layout import FORMAT, INPUT, VERSION, describe
from slider.control.policy import Policy, PolicyNetwork
from slider.core.errors import UserError, require
from slider.core.files import digest_file, flatten
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.observations import Observer
from slider.library.lookup import GaitTable, StepTimes
from slider.robot.names import NUM_JOINTS, VELOCITY

_COMPARED = ("robot", "control_period", "observation", "action")  # parts of the layout


class OnnxNetwork:
    """A network in an ONNX file, on one thread of the processor."""

    def __init__(self, path: Path, size: int) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        try:
            self._session = onnxruntime.InferenceSession(
                path, options, providers=["CPUExecutionProvider"]
            )
        except Exception:  # onnxruntime raises errors of its own kinds
            raise UserError(f"{path}: expected an ONNX file, found another one") from None
        names = [item.name for item in self._session.get_inputs()]
        require(names == [INPUT], str(path), f"the input {INPUT}", ", ".join(names))
        ends = self._session.get_inputs()[0], self._session.get_outputs()[0]
        found, expected = [item.shape[-1] for item in ends], [size, NUM_JOINTS]
        require(found == expected, str(path), f"sizes {expected} of input and output", found)

    def __call__(self, observations: torch.Tensor) -> torch.Tensor:
        """Actions (N, 12) of observations (N, size)."""
        values = observations.numpy().astype(np.float32)
        return torch.from_numpy(np.asarray(self._session.run(None, {INPUT: values})[0]))


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


def load_exported(folder: Path, robot: RobotConfig, env: EnvConfig) -> tuple[OnnxNetwork, Policy]:
    """Read a network, and the policy whose own network it takes the place of.

    Raises:
        UserError: the layout is of another version, or not that of ``robot`` and ``env``.
    """
    path = folder / LAYOUT
    try:
        layout = json.loads(path.read_text(encoding="utf-8"))
        found, expected = f"{layout['format']} {layout['version']}", f"{FORMAT} {VERSION}"
        require(found == expected, str(path), expected, found)
        clock, reference = layout["clock"], layout["reference"]
        times = StepTimes.constant(1.0) if clock is None else _times(clock, clock["step_time"])
        shape = reference["shape"]
        positions = np.load(folder / REFERENCE, allow_pickle=False).reshape(shape)
        table = GaitTable(_times(reference, np.ones(shape[:3])), positions)
        sizes = Observer(env.observation, robot.geometry).layout
        network = PolicyNetwork(sum(sizes.values()), NUM_JOINTS, (), "elu")
        policy = Policy(network, (), "elu", dict(sizes), times, robot, env, {}, table)
        wanted, own = (_leaves(node) for node in (describe(policy, {}), layout))
        for key in dict.fromkeys([*wanted, *own]):
            value, other = wanted.get(key, "nothing"), own.get(key, "nothing")
            require(value == other, f"{path}, {key}", f"{value}, as configured", other)
    except (KeyError, TypeError, ValueError):
        raise UserError(f"{path}: expected a layout of this project, found another file") from None
    return OnnxNetwork(folder / ONNX, sum(sizes.values())), policy


def _times(node: Mapping[str, Any], step_time: Any) -> StepTimes:
    axes = {name: np.array(node[name]) for name in VELOCITY}
    return StepTimes(**axes, step_time=np.array(step_time))


def _leaves(layout: Mapping[str, Any]) -> dict[str, Any]:
    """What must agree, by dotted place; not the meanings, which are words."""

    def named(value: Any) -> Any:
        if isinstance(value, list):
            value = {str(index): item for index, item in enumerate(value)}
        if isinstance(value, dict):
            return {name: named(item) for name, item in value.items() if name != "meaning"}
        return value

    parts = {name: layout[name] for name in _COMPARED}
    parts["reference"] = {"acceleration": layout["reference"]["acceleration"]}
    if layout["clock"] is not None:
        parts["clock"] = {name: layout["clock"][name] for name in ("mirror", "halt")}
    return flatten(named(parts))
