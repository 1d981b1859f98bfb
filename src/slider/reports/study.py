"""The stage ``study``: variants compared by metrics, as tables; learning curves of trainings."""

import json
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from slider.core import tables
from slider.core.job import Inputs, Job, Section, Summary
from slider.core.quantities import NONE, Quantity, speed_text
from slider.core.tables import Table
from slider.evaluation.results import Evaluation, compare, wilson
from slider.gait import REPORT
from slider.gait.study import MeshGait
from slider.library.stage import acceptable
from slider.reports import report
from slider.reports.figures.walking import draw_curves
from slider.reports.quantities import QUANTITIES, quantity
from slider.reports.report import picture
from slider.training.results import Training

LEARNED = 0.95
"""Success rate in a check from which a policy counts as having learned to walk."""
ALL, SHOWN = 40, 16
"""Greatest number of variants in the tables; of more, those with the greatest changes."""
KEYS = ["variant", "seed", "speed"]
STATISTICS = (
    *("count", "mean", "std", "min", "max", "low", "high"),
    *("change", "change_low", "change_high", "relative_change"),
)
_BINARY = ("converged", "reaches_best")
"""Metrics of a run that are 0 or 1; their interval is Wilson's."""
_CHECKS = ("success", "speed_error", "flight")


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Write ``NAME.csv``, ``NAME_runs.csv`` and ``NAME.md``.

    Where variants are trained also ``NAME_curves.csv`` and ``.svg``.
    """
    name = section["name"]
    curves = _curves(section, inputs)
    runs = pd.concat([_gaits(section, inputs), _policies(section, inputs), _walks(curves)])
    runs = runs.groupby(KEYS, sort=False, dropna=False, as_index=False).first()
    summary = summarise(runs, section["variants"], section["metrics"])
    tables.write(runs, out / f"{name}_runs.csv")
    title, parts, drawn = name.replace("_", " ").capitalize(), [*blocks(name, summary)], None
    if "walking" in inputs:
        tables.write(curves, out / f"{name}_curves.csv")
        shown = strongest(summary).dropna(subset="metric").set_index("variant")["label"]
        drawn = partial(draw_curves, curves, shown.to_dict())
        parts.insert(1, picture(name))
    report.write(out / name, title, section["robot"], summary, parts, drawn)
    return {"runs": len(runs), "variants": len(section["variants"])}


def _curves(section: Section, inputs: Inputs) -> pd.DataFrame:
    """Learning curves: the checks of all trainings over their samples."""
    parts = []
    for (variant, seed, batch), folder in _items(section, inputs, "walking"):
        checks = Training.load(folder).checks
        columns = {"variant": variant, "seed": seed, "samples": checks["iteration"] * batch}
        parts.append(pd.DataFrame({**columns, **checks[[*_CHECKS]]}))
    columns = ["variant", "seed", "samples", *_CHECKS]
    return pd.concat(parts) if parts else pd.DataFrame(columns=columns)


def _walks(curves: pd.DataFrame) -> pd.DataFrame:
    """Samples until a training first walks; ∞ for never."""
    samples = curves["samples"].where(curves["success"] >= LEARNED, np.inf)
    walks = curves[["variant", "seed"]].assign(samples_to_walk=samples)
    return walks.groupby(["variant", "seed"], sort=False)["samples_to_walk"].min().reset_index()


def _policies(section: Section, inputs: Inputs) -> pd.DataFrame:
    """A row per evaluation: the columns of Table 1 and of the quality of walking."""
    if "evaluations" not in inputs:
        return pd.DataFrame(columns=KEYS)
    keys, folders = zip(*_items(section, inputs, "evaluations"), strict=True)
    frame = compare(map(Evaluation.load, folders), inputs.get("library", ()))
    frame = frame.drop(columns=["controller", "speed"])
    return pd.concat([pd.DataFrame([*keys], columns=KEYS), frame], axis=1)


def _gaits(section: Section, inputs: Inputs) -> pd.DataFrame:
    """A row per gait; costs of those that converge, with differences from the reference's gait."""
    table, reference, references = [], section["variants"][0][0], {}
    for (variant, seed, speed), folder in _items(section, inputs, "gaits"):
        report = json.loads((folder / REPORT).read_text(encoding="utf-8"))
        row = dict(zip(KEYS, (variant, seed, speed), strict=True))
        row |= _outcome(report, section["max_violation"])
        if row["converged"] and (folder / "roll.npy").is_file():
            gait = MeshGait.load(folder)
            row |= {"torque_cost": gait.torque_cost, "step_time": gait.step_time}
            if variant == reference:
                references[speed] = gait
            if speed in references:
                changes = gait.difference(references[speed])
                row |= {name: changes[name] for name in changes if name in section["metrics"]}
        table.append(row)
    if not table:
        return pd.DataFrame(columns=KEYS)
    gaits = pd.DataFrame(table)
    base = gaits[gaits["variant"] == reference].set_index("speed")
    for name in ("cost", "torque_cost"):
        gaits[f"{name}_change"] = gaits[name] / gaits["speed"].map(base[name]) - 1.0
    return gaits if section["same_cost"] is None else _with_optima(gaits, section["same_cost"])


def _outcome(report: dict[str, Any], limit: float) -> dict[str, Any]:
    converged, residuals = acceptable(report, limit), report["residuals"]
    found = ("cost", "gait_transport", "base_height")
    return {
        "converged": float(converged),
        "status": report["status"],
        "iterations": float(report["iterations"]),
        **{name: report[name] if converged else np.nan for name in found},
        "torque_cost": np.nan,
        "max_violation": report["max_violation"],
        "worst_constraint": max(residuals, key=residuals.__getitem__),
        **{f"between_{name}": worst for name, worst in report.get("between_nodes", {}).items()},
    }


def _with_optima(gaits: pd.DataFrame, same: float) -> pd.DataFrame:
    """Add the number of each optimum, 0 for the cheapest, and the cost above the cheapest.

    At each speed, in order of cost, a new optimum begins where a cost exceeds the previous one by
    more than the share ``same``.
    """
    ascending = gaits.sort_values("cost", kind="stable")
    costs = ascending.groupby("speed")["cost"]
    jumps = (costs.diff() > same * ascending["cost"]).astype(float).where(ascending["cost"].notna())
    gaits["optimum"] = jumps.groupby(ascending["speed"]).cumsum()
    gaits["cost_excess"] = gaits["cost"] / gaits.groupby("speed")["cost"].transform("min") - 1.0
    gaits["reaches_best"] = (gaits["cost_excess"] <= same).astype(float)
    return gaits


def summarise(
    runs: pd.DataFrame, variants: Sequence[Sequence[str]], metrics: Sequence[str]
) -> pd.DataFrame:
    """Statistics of each metric over the runs of a variant, at each speed.

    ``low``, ``high``: 95 % interval of the mean, by Student's t over the runs; of a share of runs,
    or of the robots of a single run, Wilson's. ``change``: mean difference from the reference, the
    first variant, paired by seed where that has several runs, with its interval by Student's t.
    ``runs`` have a row per variant, seed and speed [m/s]; ``variants`` are name, label, changes and
    note of each: one without a result is one row with its note.
    """
    reference, table = variants[0][0], []
    for metric in (name for name in metrics if name in runs):
        for speed, mine in runs.dropna(subset=metric).groupby("speed", sort=True, dropna=False):
            values = {name: own.set_index("seed") for name, own in mine.groupby("variant")}
            base = values[reference][metric] if reference in values else mine[metric][:0]
            for name, own in values.items():
                row = {"variant": name, "speed": speed, "metric": metric}
                table.append(row | _statistics(metric, own) | _change(own[metric], base))
    columns = ["variant", "speed", "metric", *STATISTICS]
    names = pd.DataFrame([*variants], columns=["variant", "label", "changes", "note"])
    return names.merge(pd.DataFrame(table, columns=columns), on="variant", how="left")


def _statistics(metric: str, runs: pd.DataFrame) -> dict[str, float]:
    values = runs[metric].to_numpy(float)
    std, low, high = _spread(values)
    if metric in _BINARY and len(values) > 1:
        low, high = wilson(int(values.sum()), len(values))
    elif len(values) == 1 and metric == "success_rate":  # of the robots of the run
        low, high = runs[["success_low", "success_high"]].iloc[0]
    row = (len(values), values.mean(), std, values.min(), values.max(), low, high)
    return dict(zip(STATISTICS, row, strict=False))


def _change(own: pd.Series, reference: pd.Series) -> dict[str, float]:
    base = reference.iloc[0] if len(reference) == 1 else reference
    with np.errstate(invalid="ignore"):
        differences = (own - base).dropna().to_numpy(float)
    if not len(differences):
        return {}
    change, size = float(differences.mean()), float(np.mean(base))
    _, low, high = _spread(differences)
    relative = change / abs(size) if size and np.isfinite(size) else np.nan
    return dict(zip(STATISTICS[7:], (change, low, high, relative), strict=True))


def _spread(values: np.ndarray) -> tuple[float, float, float]:
    """Standard deviation, and the mean's 95 % interval by Student's t; NaN of a single value."""
    if len(values) < 2 or not np.isfinite(values).all():
        return np.nan, np.nan, np.nan
    mean, std = float(values.mean()), float(values.std(ddof=1))
    half = float(stdtrit(len(values) - 1, 0.975) * std / np.sqrt(len(values)))
    return std, mean - half, mean + half


def strongest(summary: pd.DataFrame) -> pd.DataFrame:
    """The reference and the variants whose shares [%] change most, ``SHOWN`` in all; all notes."""
    names = summary.loc[summary["metric"].notna(), "variant"].drop_duplicates()
    if len(names) <= ALL:
        return summary
    shares = summary["metric"].isin(name for name, metric in QUANTITIES.items() if metric.share)
    size = summary["change"].where(shares).abs().groupby(summary["variant"]).max()
    order = size.reindex(names[1:]).fillna(0.0).sort_values(ascending=False, kind="stable")
    chosen = [names.iloc[0], *order.index[: SHOWN - 1]]
    shown = [summary[summary["variant"] == name] for name in chosen]
    return pd.concat([*shown, summary[summary["metric"].isna()]])


def blocks(name: str, summary: pd.DataFrame) -> Iterator[str | Table]:
    """Tables of a study, one per metric: a row per variant, a column per speed."""
    shown, count = strongest(summary), summary["variant"].nunique()
    yield (
        "Means over runs (min to max); of a single run with its 95 % interval where there "
        "is one. Errors and quality are those of surviving robots. \\*: the 95 % interval of the "
        f"change against the first row excludes 0. `{name}.csv` has all {count} variants."
    )
    yield _variants(shown)
    for metric, mine in shown.dropna(subset="metric").groupby("metric", sort=False):
        yield _table(quantity(str(metric)), mine)


def _variants(summary: pd.DataFrame) -> Table:
    heads = ["variant", "overrides", "not compared"]
    variants = summary.drop_duplicates("variant").fillna({"changes": "", "note": ""})
    described = variants["changes"] + variants["note"] != ""  # not another controller's row
    described.iloc[:1] = True
    body = [
        [row.label, " ".join(f"`{text}`" for text in row.changes.split()) or "none"]
        + [" ".join(row.note.split())]
        for row in variants[described].itertuples()
    ]
    return Table(heads, body)


def _table(metric: Quantity, summary: pd.DataFrame) -> Table:
    speeds = summary["speed"].sort_values().unique()  # NaN of a training
    body = []
    for (_, label), mine in summary.groupby(["variant", "label"], sort=False):
        cells = pd.Series([_cell(metric, row) for row in mine.itertuples()], mine["speed"])
        body.append([str(label), *cells.reindex(speeds, fill_value=NONE)])
    heads = ["variant", *(f"{speed_text(v)} m/s" if v == v else "training" for v in speeds)]
    return Table(heads, body, metric.heading)


def _cell(metric: Quantity, row: Any) -> str:
    if row.count == 1:
        text = metric.between(row.mean, row.low, row.high)
    else:
        text = metric.ranged(row.mean, row.min, row.max)
    different = row.change_low > 0 or row.change_high < 0
    return f"{text} \\*" if different else text


def _items(section: Section, inputs: Inputs, group: str) -> Iterator[tuple[list[Any], Path]]:
    """Key and folder of each job of a group."""
    return zip(section["keys"].get(group, ()), inputs.get(group, ()), strict=True)
