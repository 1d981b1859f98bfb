"""One gait as CSV or NPZ, for other controllers; columns in ``docs/reference/gait-library.md``."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np

from slider.library.reader import ARRAYS, CONSTRAINT, COORDINATES, LABELS, GaitLibrary
from slider.robot.names import CHANNEL_UNITS, CHANNELS, JOINTS, SIDES

_BASE_UNITS = ("m",) * 3 + ("1",) * 4 + ("m/s",) * 3 + ("rad/s",) * 3
_WRENCH_UNITS = ("N",) * 3 + ("N m",) * 3


def write_csv(library: GaitLibrary, gait: int, path: Path) -> None:
    """Write one row per sample; the header names each column with its unit in brackets."""
    arrays = {name: library.arrays[name][gait] for name in ARRAYS}
    stance = [SIDES[side] for side in arrays["contact"].argmax(axis=1)]
    columns: dict[str, list[str] | np.ndarray] = {"time [s]": arrays["time"], "stance": stance}
    effort_units = ["N" if name.endswith("slide") else "N m" for name in JOINTS]
    names = (
        ("samples", CHANNELS, CHANNEL_UNITS),
        ("base", [f"base_motion.{name}" for name in LABELS["base_channel"]], _BASE_UNITS),
        ("efforts", [f"{name}.effort" for name in JOINTS], effort_units),
        ("ground_wrench", [f"ground.{n}" for n in LABELS["wrench_component"]], _WRENCH_UNITS),
    )
    for array, labels, units in names:
        for column, (label, unit) in enumerate(zip(labels, units, strict=True)):
            columns[f"{label} [{unit}]"] = arrays[array][:, column]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in zip(*columns.values(), strict=True):
            writer.writerow(v if isinstance(v, str) else f"{v:.10g}" for v in row)


def write_npz(library: GaitLibrary, gait: int, path: Path) -> None:
    """Write the library's arrays of one gait, without the axis of the gaits, and their labels."""
    names = (*ARRAYS, *COORDINATES)
    arrays = {name: library.arrays[name][gait] for name in names}
    labels = LABELS | {CONSTRAINT: library.constraints}
    texts = {f"{axis}_names": np.array(values, dtype=str) for axis, values in labels.items()}
    arrays["status"] = np.array(str(arrays["status"]))
    units = np.array(CHANNEL_UNITS, dtype=str)
    with path.open("wb") as file:  # else numpy appends .npz to other names
        np.savez(file, allow_pickle=False, channel_units=units, **arrays, **texts)


FORMATS: dict[str, Callable[[GaitLibrary, int, Path], None]] = {
    "csv": write_csv,
    "npz": write_npz,
}
