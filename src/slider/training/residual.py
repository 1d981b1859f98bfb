"""The stages ``standing`` and ``walking`` with actions on top of the controller ``hzd``.

They are apart from the others so that a change of that controller trains no other policy anew.
"""

from pathlib import Path

from slider.control.hzd.underlying import UnderlyingHzd
from slider.core.job import Inputs, Job, Section, Summary
from slider.training.stage import task, train


def run_standing(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Pre-train a policy on a controller that stands."""
    underlying = UnderlyingHzd.of(section, inputs)
    return train(task(section, inputs, False, underlying), inputs, out, job)


def run_walking(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Train a policy on a controller that walks."""
    underlying = UnderlyingHzd.of(section, inputs)
    return train(task(section, inputs, True, underlying), inputs, out, job)
