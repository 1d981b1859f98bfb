"""The stage ``baseline`` of the controller ``hzd``.

It is apart from the others so that a change of either evaluates the other one not anew.
"""

from functools import partial
from pathlib import Path

from slider.control.hzd.controller import EnforcedGaits, hzd_controller
from slider.core.job import Inputs, Job, Section, Summary
from slider.evaluation import baseline


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Roll the gaits of a library with their foot placement out."""
    gaits = EnforcedGaits.load(inputs["library"][0], inputs["foot_placement"][0], section["hzd"])
    return baseline.run(section, out, job, partial(hzd_controller, enforced=gaits))
