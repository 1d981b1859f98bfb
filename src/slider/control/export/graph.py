"""The network as an ONNX file and as a ``torch.export`` file, the layout inside both.

ONNX comes from the exporter on top of ``torch.export`` (package onnxscript); the older one on top
of TorchScript is deprecated in torch 2.13.
"""

import json
import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import onnx
import onnxscript
import torch

from slider.control.export.layout import INPUT, OUTPUT
from slider.control.network import PolicyNetwork

LAYOUT_KEY = "slider_policy_layout"  # in the metadata of the ONNX file
LAYOUT_FILE = "layout.json"  # among the extra files of the torch.export file
_TRACES = ("stack_trace", "nn_module_stack", "source_fn_stack", "from_node", "torch_fn")


def trace(network: PolicyNetwork) -> torch.export.ExportedProgram:
    """Graph of a network for any number of robots: (N, size) → (N, 12)."""
    robots = torch.export.Dim("robots")
    example = torch.zeros(2, len(network.mean))
    program = torch.export.export(network.eval(), (example,), dynamic_shapes=({0: robots},))
    for node in program.graph.nodes:
        for name in _TRACES:  # they hold paths of this machine
            node.meta.pop(name, None)
    return program


def save_torch(
    program: torch.export.ExportedProgram, layout: Mapping[str, Any], path: Path
) -> None:
    """Write for ``torch.export.load(path).module()``."""
    torch.export.save(program, path, extra_files={LAYOUT_FILE: json.dumps(layout)})


def save_onnx(program: torch.export.ExportedProgram, layout: Mapping[str, Any], path: Path) -> None:
    """Write for any ONNX runtime; checked for being well formed."""
    with _quiet():
        exported = torch.onnx.export(
            program, (), input_names=[INPUT], output_names=[OUTPUT], verbose=False
        )
    if exported is None:
        raise RuntimeError("expected an ONNX program from torch.onnx.export, found none")
    model = exported.model_proto
    exporter = f"torch {torch.__version__}, onnxscript {onnxscript.__version__}"
    onnx.helper.set_model_props(model, {LAYOUT_KEY: json.dumps(layout), "exporter": exporter})
    onnx.checker.check_model(model, full_check=True)
    path.write_bytes(model.SerializeToString(deterministic=True))


@contextmanager
def _quiet() -> Iterator[None]:
    """Without torch's own deprecations and its regret that torchvision is not installed."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)
