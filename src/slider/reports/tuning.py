"""The stage ``baseline_tuning``: what the searches for settings found, present and best values."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import speed_text
from slider.core.tables import Table
from slider.evaluation.tuning import CSV, ERROR, FINALIST, SUCCESS, TRACKING
from slider.reports import report
from slider.reports.quantities import QUANTITIES

_SHOWN = {SUCCESS: "success_rate", TRACKING: "tracking_rate", ERROR: "mse_steady"}
_CAPTION = """\
The score is the mean over the commands v of log10(e / v² + f / 10), with e the mean squared
velocity error of the surviving robots after the warm-up and f the share that falls. Trial 0 is the
present one. The tables show finalists, which have more robots.
"""


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write all trials as ``baseline_tuning.csv``, present and best ones as Markdown."""
    labels = section["labels"]
    found = (tables.read(folder / CSV) for folder in inputs["searches"])
    searches = dict(zip(labels, found, strict=True))
    frame = pd.concat(searches, names=["controller"]).reset_index("controller")
    texts = [table for name, mine in searches.items() for table in _tables(name, mine, section)]
    title, parts = "Tuned baselines", [_CAPTION, *texts]
    report.write(out / "baseline_tuning", title, section["robot"], frame, parts)
    scores = {name: float(_present_and_best(mine)[1]["score"]) for name, mine in searches.items()}
    return {"trials": len(frame), "scores": scores}


def _present_and_best(trials: pd.DataFrame) -> tuple[pd.Series, pd.Series]:
    finalists = trials[trials[FINALIST] == 1]
    return finalists.iloc[0], finalists.loc[finalists["score"].idxmin()]


def _tables(name: str, trials: pd.DataFrame, section: Mapping[str, Any]) -> Iterator[Table]:
    """Settings, then rates and error at each command, of the present and the best trial."""
    (present, best), label = _present_and_best(trials), section["labels"][name]
    count = (trials[FINALIST] == 0).sum()
    score = f"trial {best['trial']:g} of {count}, score {best['score']:.3f}"
    heads = [f"control.{name}", "range", f"present, score {present['score']:.3f}", score]
    body = [
        [key, f"{limits['lower']:g} to {limits['upper']:g}"]
        + [f"{trial[key]:.3g}" for trial in (present, best)]
        for key, limits in section["spaces"][name].items()
    ]
    yield Table(heads, body, label)
    prefix = f"{SUCCESS}_"
    speeds = [column.removeprefix(prefix) for column in trials if column.startswith(prefix)]
    lines = [
        [f"{QUANTITIES[quantity].heading}, {title}"]
        + [QUANTITIES[quantity].text(trial[f"{key}_{speed}"]) for speed in speeds]
        for title, trial in (("present", present), ("best", best))
        for key, quantity in _SHOWN.items()
    ]
    yield Table(["command [m/s]", *(speed_text(float(speed)) for speed in speeds)], lines)
