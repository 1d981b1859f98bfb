"""The stage ``stability``: a table of the gaits' multipliers; no controller waits for it."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import NONE, Quantity
from slider.core.tables import Table
from slider.hzd.foot_placement import FootPlacement
from slider.hzd.stage import BY_HIP, MULTIPLIERS, indices, load_library
from slider.library.reader import GaitLibrary
from slider.robot.names import VELOCITY

CSV, MARKDOWN = "stability.csv", "stability.md"
QUANTITIES: dict[str, Quantity] = {
    "phase": Quantity("hip or time", "-"),
    "spectral_radius": Quantity("of the return map, without foot placement", "1/step"),
    "eigenvalues": Quantity("moduli of its nonzero Floquet multipliers", "1/step"),
    "closed_eigenvalues": Quantity(
        "moduli of the nonzero multipliers with foot placement", "1/step"
    ),
    "closed_spectral_radius": Quantity("spectral radius with foot placement", "1/step"),
    "gain_position": Quantity(
        "displacement of the right foot to the left per lateral position, at the start", "-"
    ),
    "gain_lateral": Quantity("the same displacement per lateral velocity", "s"),
    "gain_forward": Quantity("displacement of the foot forward per forward velocity", "s"),
    "hip_share": Quantity("least forward velocity of the hip, share of its mean", "-"),
    "decoupling": Quantity("least singular value of the decoupling matrix", "rad/s², m/s²"),
    "condition": Quantity("greatest condition number of the decoupling matrix", "-"),
}
"""Unit and meaning of each column."""
_OVER_SPEED = (
    *("spectral_radius", "closed_spectral_radius", "gain_position", "gain_lateral", "gain_forward"),
    *("hip_share", "decoupling"),
)


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write a table of all gaits as CSV, and a summary as Markdown."""
    library = load_library(inputs)
    rows = [row for folder in inputs["gaits"] for row in records(library, folder)]
    frame = pd.DataFrame(rows, columns=[*VELOCITY, *QUANTITIES]).sort_values([*VELOCITY])
    write_csv(out / CSV, frame)
    write_markdown(out / MARKDOWN, frame)
    return {"gaits": len(frame), "stable": int(frame["spectral_radius"].notna().sum())}


def records(library: GaitLibrary, folder: Path) -> list[dict[str, Any]]:
    """Values of ``QUANTITIES`` of a job's gaits; without a limit cycle some are missing."""
    placed, multipliers = FootPlacement.load(folder), np.load(folder / MULTIPLIERS)
    result = []
    for k, gait in enumerate(indices(library, placed.velocities.tolist())):
        clock, decoupling = bool(placed.clock[k]), library.arrays["decoupling"][gait]
        record = {
            **dict(zip(VELOCITY, placed.velocities[k].tolist(), strict=True)),
            "phase": "time" if clock else "hip",
            "hip_share": None if clock else float(placed.hip_share[k]),
            "decoupling": float(decoupling[:, 0].min()),
            "condition": float(decoupling[:, 1].max()),
        }
        without, within = (each[np.isfinite(each)].tolist() for each in multipliers[k])
        if without:
            gains = -placed.gains[k, 0 if clock else BY_HIP, 0, 0]
            record |= {
                "spectral_radius": without[0],
                "eigenvalues": without,
                "closed_eigenvalues": within,
                "closed_spectral_radius": within[0],
                "gain_position": float(gains[1, 0]),
                "gain_lateral": float(gains[1, 1]),
                "gain_forward": float(gains[0, 2]),
            }
        result.append(record)
    return result


def write_csv(path: Path, frame: pd.DataFrame) -> None:
    """One line per gait; several values of one column are separated by spaces."""
    several = [name for name in frame if name.endswith("eigenvalues")]
    texts = {name: [_text(values, 6) for values in frame[name]] for name in several}
    tables.write(frame.assign(**texts), path)


def write_markdown(path: Path, frame: pd.DataFrame) -> None:
    """Range of each quantity over the gaits, and some over the forward velocity at vy = 0."""
    head = ["quantity", "unit", "meaning", "least", "median", "greatest"]
    ranges = [_range(name, frame[name]) for name in QUANTITIES if name != "phase"]
    parts = [f"{len(frame)} gaits.", Table(head, ranges)]
    straight = frame[(frame["vy"] == 0) & (frame["yaw_rate"] == 0)]
    if len(straight):
        head = ["vx [m/s]", *(f"{speed:g}" for speed in straight["vx"])]
        body = [[f"`{n}`", *(_text(value, 3) for value in straight[n])] for n in _OVER_SPEED]
        parts += ["At vy = 0:", Table(head, body)]
    path.write_text(tables.markdown(parts), encoding="utf-8")


def _range(name: str, column: pd.Series) -> list[str]:
    values = column.dropna().map(np.max)
    numbers = (values.min(), values.median(), values.max())
    texts = [f"{number:.3g}" for number in numbers] if len(values) else [NONE] * 3
    return [f"`{name}`", QUANTITIES[name].unit, QUANTITIES[name].title, *texts]


def _text(value: Any, digits: int) -> str:
    """One number, or several; empty for NaN."""
    return " ".join(f"{number:.{digits}g}" for number in np.atleast_1d(value) if number == number)
