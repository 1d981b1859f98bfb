"""The stage ``evaluation`` of a policy whose torques add to those of the controller ``hzd``.

It is apart from the others so that a change of that controller evaluates no other policy anew.
"""

from pathlib import Path

from slider.control.hzd.underlying import underlying_of
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import stage


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll controller and policy out on torque drives, once per tick of the controller."""
    return stage.run(section, inputs, out, job, underlying_of)
