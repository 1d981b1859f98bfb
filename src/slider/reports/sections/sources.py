"""What the sections of the page are made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.config.report import ReportConfig
from slider.core.job import Inputs
from slider.evaluation.results import Evaluation
from slider.reports.rows import evaluations


@dataclass(frozen=True)
class Sources:
    """What sections are made from.

    Attributes:
        report: settings of the page.
        configuration: the resolved configuration, as plain values.
        labels: what people call the controllers.
        origins: input → for each of its jobs stage, label, recipe, entry, source digest, versions.
        inputs: input → object folders.
        times: input → for each of its jobs what differs between runs, such as ``wall_s``.
        page: the same of the page itself; see :mod:`slider.artefacts.run_metadata`.
    """

    report: ReportConfig
    configuration: Mapping[str, Any]
    labels: Mapping[str, str]
    origins: Mapping[str, Sequence[Mapping[str, Any]]]
    inputs: Inputs
    times: Mapping[str, Sequence[Mapping[str, Any]]]
    page: Mapping[str, Any]

    def evaluations(self, name: str) -> list[Evaluation]:
        """Those that a target is made from."""
        return evaluations(self.inputs[f"{name}.evaluations"], self.labels)

    def file(self, name: str, path: str) -> Path:
        """File of the one result of an input."""
        return self.inputs[name][0] / path
