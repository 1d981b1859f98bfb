"""Sources of a section, made by hand."""

from pathlib import Path
from typing import Any

from slider.config.report import ReportConfig
from slider.config.video import VideoConfig
from slider.reports.sections.sources import Sources

VIDEO = VideoConfig("none", "both", 1.0, 64, 64, 25, 27, 0)


def sources(inputs: dict[str, list[Path]], **others: Any) -> Sources:
    """Sources with these inputs; the rest is empty unless given."""
    values: dict[str, Any] = {"configuration": {}, "origins": {}, "times": {}, "page": {}}
    report = ReportConfig(["table1"], [], VIDEO)
    return Sources(report=report, inputs=inputs, **{**values, **others})
