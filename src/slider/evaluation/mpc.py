"""The stage ``baseline`` of the model-predictive controllers."""

from pathlib import Path

from slider.control.mpc.controller import mpc_controller
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import baseline


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll footstep MPC and whole-body QP out."""
    return baseline.run(section, out, job, mpc_controller)
