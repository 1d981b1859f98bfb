"""The stage ``report``: one self-contained page about everything."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slider.config.convert import from_dict
from slider.config.report import ReportConfig
from slider.core.job import Inputs, Job, Section, Summary
from slider.reports.controllers import label, speed
from slider.reports.page import render_page
from slider.reports.sections import SECTIONS
from slider.reports.sections.sources import Sources

PAGE = "index.html"
_TITLE = "SLIDER: extended hybrid zero dynamics and gait-guided learning"


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``index.html`` with the configured sections, each from its declared inputs."""
    report = from_dict(ReportConfig, section["report"])
    sources = Sources(
        report=report,
        configuration=section["configuration"],
        origins=section["origins"],
        inputs=inputs,
        times=job.input_volatile,
        page=job.volatile,
    )
    sections = {name: SECTIONS[name](sources) for name in report.sections}
    page = render_page(_TITLE, _facts(section["configuration"]), sections)
    (out / PAGE).write_text(page, encoding="utf-8")
    job.tracker.log_file(out / PAGE)
    return {"sections": report.sections, "megabytes": round(len(page.encode()) / 1e6, 1)}


def _facts(configuration: Mapping[str, Any]) -> dict[str, str]:
    """What a reader wants to know before anything else."""
    evaluation = configuration["evaluation"]
    trainings = (configuration["train"]["walking"], configuration["finetuning"] or {})
    samples = sum(map(_samples, trainings))
    return {
        "controllers": " · ".join(map(label, evaluation["controllers"])),
        "commands": ", ".join(map(speed, evaluation["commands"])) + " m/s",
        "robots per command": f"{evaluation['trials']} trials × {evaluation['robots']}",
        "training": f"{samples / 1e6:.1f} million control steps",
    }


def _samples(train: Mapping[str, Any]) -> int:
    """Control steps of a training, or of none."""
    return math.prod(train.get(n, 0) for n in ("iterations", "robots", "steps_per_iteration"))
