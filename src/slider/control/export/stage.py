"""The stage ``policy_export``: the walking policy for use without this package."""

from pathlib import Path

import torch

from slider.control import POLICY_FILE
from slider.control.export import FILES
from slider.control.export.agreement import TOLERANCE
from slider.control.export.folder import export
from slider.core.job import Inputs, Job, Section, Summary


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ONNX, torch.export, layout and robot model; see :mod:`slider.control.export.folder`."""
    torch.set_num_threads(job.threads)
    found = export(inputs["walking"][0] / POLICY_FILE, section["origin"], out, job.threads)
    differences = {"onnx_difference": found.onnx, "torch_export_difference": found.torch_export}
    job.volatile.update(differences)  # rounding depends on the machine
    for name in FILES:
        job.tracker.log_file(out / name)
    return {"observations": found.observations, "tolerance": TOLERANCE}
