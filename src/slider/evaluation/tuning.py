"""The stage ``tuning``: a search for a controller's settings with Optuna's Gaussian process.

A trial of Optuna is one set of settings at all speeds; the first is the current one. Its score, to
be minimised, is the mean over the speeds v of log10(e / v² + f / 10): e is the mean squared
velocity error of the surviving robots after the warm-up (v² if there are none), f the share that
falls. In a sum e / v² + f one fall among twelve robots would outweigh all else. With few robots
rare falls go unobserved, so the current settings and the best trials are measured again as
finalists, with more robots and other starts. Measurements of a killed search are kept: the next one
draws the same trials again.
"""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pandas as pd
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution

from slider.config.convert import from_dict, setting, with_settings
from slider.config.evaluation import EvaluationConfig, at_speed
from slider.core import files, tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.env.metrics import Columns, tracking
from slider.evaluation.stage import record

CSV = "trials.csv"
_KEPT = "measured.json"
_PER_FALL = 0.1  # of v²
FINALIST = "finalist"  # 0: a trial of the search; 1: measured again
SUCCESS, TRACKING, ERROR = "success_rate", "tracking_rate", "error"  # columns NAME_SPEED
_Measure = Callable[[EvaluationConfig, Mapping[str, float]], tuple[dict[str, float], float]]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write a row per trial and finalist: score, settings, rates and error [m²/s²] per speed."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    ranges = _distributions(section)
    sampler = optuna.samplers.GPSampler(seed=section["sampler_seed"])
    study = optuna.create_study(sampler=sampler)
    study.enqueue_trial({name: setting(section["control"], name) for name in ranges})
    measure = _kept(job.work / _KEPT, partial(_measure, section, inputs, job.threads))
    protocol = from_dict(EvaluationConfig, section["evaluation"])
    rows = []
    for number in range(section["trials"]):
        trial = study.ask(ranges)
        columns, score = measure(protocol, trial.params)
        assert np.isfinite(score), trial.params
        study.tell(trial, score)
        rows.append({"trial": number, FINALIST: 0, "score": score, **trial.params, **columns})
        job.progress(f"trial {number + 1}/{section['trials']}, best score {study.best_value:.3f}")
        job.log_metrics({"score": score, "best": study.best_value}, number)
    present, *drawn = rows
    best = sorted(drawn, key=lambda row: row["score"])[: section["finalists"]]
    changed = {"robots": section["finalist_robots"], "seed": protocol.seed + 1}
    final = from_dict(EvaluationConfig, section["evaluation"] | changed)
    for place, row in enumerate([present, *best], 1):
        job.progress(f"finalist {place}/{len(best) + 1}")
        columns, score = measure(final, {name: row[name] for name in ranges})
        rows.append({**row, FINALIST: 1, "score": score, **columns})
    tables.write(pd.DataFrame(rows), out / CSV)
    winner = min(rows[section["trials"] :], key=lambda row: row["score"])
    return {"best": winner["trial"], "score": winner["score"]}


def _kept(path: Path, measure: _Measure) -> _Measure:
    """The function with its results cached in a file, for the search after a kill."""
    kept: dict[str, Any] = files.read_json(path) if path.is_file() else {}

    def measured(config: EvaluationConfig, settings: Mapping[str, float]):
        key = files.digest_value([config.robots, config.seed, settings])
        if key not in kept:
            kept[key] = measure(config, settings)
            files.write_json(path, kept)
        return kept[key]

    return measured


def _distributions(section: Section) -> dict[str, BaseDistribution]:
    """Ranges of the settings, current values included; those of integer settings are integer."""
    ranges: dict[str, BaseDistribution] = {}
    for name, bounds in section["space"].items():
        present, log = setting(section["control"], name), bounds["log"]
        assert present is not None  # checked with the configuration
        ends = min(bounds["lower"], present), max(bounds["upper"], present)
        if isinstance(present, int):
            ranges[name] = IntDistribution(*map(round, ends), log=log)
        else:
            ranges[name] = FloatDistribution(*ends, log=log)
    return ranges


def _measure(
    section: Section,
    inputs: Inputs,
    threads: int,
    config: EvaluationConfig,
    settings: Mapping[str, float],
) -> tuple[dict[str, float], float]:
    """Success, tracking and error of each speed, and the score."""
    section = section | {"control": with_settings(section["control"], settings)}
    cases = [at_speed(speed) for speed in section["speeds"]]
    recording = record(section, inputs, config, cases, threads)
    limits = config.warm_up, config.tracking_tolerance, config.tracking_relative
    return scored(tracking(recording, *limits), section["speeds"])


def scored(tracked: Columns, speeds: list[float]) -> tuple[dict[str, float], float]:
    """Rates and error at each speed [m/s], and the score; robots are in blocks of equal speed."""
    columns: dict[str, float] = {}
    scores, blocks = [], (len(speeds), -1)
    names = ("survived", "tracked", "squared_error_steady")
    robots = (tracked[name].reshape(blocks) for name in names)
    for speed, alive, follows, squares in zip(speeds, *robots, strict=True):
        share = float(alive.mean())
        error = float(squares[alive].mean()) if share else speed**2  # as if it stood still
        values = {SUCCESS: share, TRACKING: float(follows.mean()), ERROR: error}
        columns |= {f"{name}_{speed:g}": value for name, value in values.items()}
        scores.append(np.log10(error / speed**2 + _PER_FALL * (1.0 - share)))
    return columns, float(np.mean(scores))
