"""The gauge's table: highest levels, the number, and its files, from counts made by hand."""

import numpy as np
import pandas as pd

from slider.config.convert import to_dict
from slider.core.job import Job
from slider.core.tables import read, write
from slider.reports import gauge
from slider.reports.gauge import NUMBER, gauge_frame
from tests.env.synthetic import config

LABELS = {"policy": "policy (ours)", "hzd": "HZD"}


def cells(passed: dict[int, list[float]], directions=(np.nan,)) -> pd.DataFrame:
    """Of ten robots per speed, level and direction."""
    rows = [
        {"level": level, "value": 2.5 * level, "direction": direction, "speed": speed, "seed": 0}
        | {"robots": 10, "survived": 10, "passed": count, "mean_velocity": speed}
        for level, counts in passed.items()
        for speed, count in zip((0.4, 0.8), counts, strict=True)
        for direction in directions
    ]
    return pd.DataFrame(rows)


def both() -> dict[tuple[str, str], pd.DataFrame]:
    pushed = cells({1: [10, 10], 2: [8, 10], 3: [0, 0]}, (0.0, np.pi / 2, np.pi, 3 * np.pi / 2))
    return {
        ("policy", "slope_up"): cells({1: [10, 10], 2: [8, 10], 3: [10, 7]}),
        ("policy", "push"): pushed,
        ("hzd", "slope_up"): cells({1: [0, 0], 2: [np.nan, np.nan], 3: [np.nan, np.nan]}),
        ("hzd", "push"): cells({1: [10, 10], 2: [8, 10], 3: [10, 10]}, (0.0, np.pi)),
    }


def joined() -> pd.DataFrame:
    return pd.concat(both(), names=["controller", "axis"]).reset_index(["controller", "axis"])


def test_levels_magnitudes_and_numbers():
    rows = gauge_frame(joined(), LABELS, 0.9).to_dict("records")
    found = [(row["controller"], row["axis"], row["level"], row["magnitude"]) for row in rows]
    assert found == [
        ("policy", "slope_up", 2, "6.25°"),
        ("policy", "push", 2, "5 N s"),
        ("policy", NUMBER, 2.0, ""),
        ("hzd", "slope_up", 0, ""),
        ("hzd", "push", 3, "7.5 N s"),
        ("hzd", NUMBER, 1.5, ""),
    ]
    assert [rows[0][f"pass_{level}"] for level in (1, 2, 3)] == [1.0, 0.9, 0.85]
    assert np.isnan(rows[3]["pass_2"])
    strict = gauge_frame(joined(), LABELS, 0.95)["level"]
    assert strict.tolist() == [1, 1, 1, 0, 1, 0.5], "a level above a failed one does not count"


def test_files(tmp_path):
    *folders, out = (tmp_path / str(index) for index in range(len(both()) + 1))
    out.mkdir()
    for folder, table in zip(folders, both().values(), strict=True):
        folder.mkdir()
        write(table, folder / gauge.CSV)
    section = {"labels": LABELS, "robot": "mine", "cells": list(both()), "survival": 0.9}
    section["protocol"] = to_dict(config().gauge)
    summary = gauge.run(section, {"cells": folders}, out, Job(tmp_path))
    assert summary == {"rows": 6, "gauge": {"policy": 2.0, "hzd": 1.5}}
    names = {path.name for path in out.iterdir()}
    assert names == {"gauge.csv", "gauge_cells.csv", "gauge.md"}
    assert "hzd,HZD,slope_up,0,,0,," in (out / "gauge.csv").read_text().splitlines()
    assert "| gauge number | **2.0** | **1.5** |" in (out / "gauge.md").read_text()
    assert len(read(out / "gauge_cells.csv")) == len(joined())
