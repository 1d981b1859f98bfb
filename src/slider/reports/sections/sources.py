"""What the sections of the page are made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.config.report import ReportConfig
from slider.core.job import Inputs


@dataclass(frozen=True)
class Sources:
    """Configuration and results.

    Attributes:
        report: settings of the page.
        configuration: the resolved configuration, as plain values.
        origins: input → for each of its jobs stage, label, recipe, entry, source digest, versions.
        inputs: input → object folders.
        times: input → for each of its jobs what differs between runs, such as ``wall_s``.
        page: the same of the page itself; see :mod:`slider.artefacts.circumstances`.
    """

    report: ReportConfig
    configuration: Mapping[str, Any]
    origins: Mapping[str, Sequence[Mapping[str, Any]]]
    inputs: Inputs
    times: Mapping[str, Sequence[Mapping[str, Any]]]
    page: Mapping[str, Any]

    def file(self, name: str, path: str) -> Path:
        """File of the one result of an input."""
        return self.inputs[name][0] / path
