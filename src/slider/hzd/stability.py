"""The stage ``stability``: a table of the gaits' multipliers; no controller waits for it."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.core.job import Inputs, Job, Section, Summary
from slider.hzd.gains import FootPlacement
from slider.hzd.stage import BY_HIP, MULTIPLIERS, indices, load_library
from slider.hzd.summary import CSV, MARKDOWN, QUANTITIES, write_csv, write_markdown
from slider.library.reader import GaitLibrary
from slider.robot.names import VELOCITY


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Table of all gaits as CSV, and for people."""
    library = load_library(inputs)
    rows = [row for folder in inputs["gaits"] for row in records(library, folder)]
    frame = pd.DataFrame(rows, columns=[*VELOCITY, *QUANTITIES]).sort_values([*VELOCITY])
    write_csv(out / CSV, frame)
    write_markdown(out / MARKDOWN, frame)
    return {"gaits": len(frame), "stable": int(frame["spectral_radius"].notna().sum())}


def records(library: GaitLibrary, folder: Path) -> list[dict[str, Any]]:
    """Values of ``slider.hzd.summary.QUANTITIES`` of a job's gaits; some lack without a cycle."""
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
