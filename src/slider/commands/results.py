"""``slider results``: fill the tables of README.md and docs/ from a finished run.

A page marks a table by ``<!-- results: NAME -->`` and ``<!-- /results -->``. NAME is in ``BLOCKS``,
or any Markdown report of ``reports/``, of which headings and tables are taken.
"""

import argparse
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slider.artefacts.current import add_store_argument
from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.run_metadata import config_option
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError
from slider.core.quantities import NONE, speed_text
from slider.core.tables import Table, read
from slider.reports.provenance import in_order, stage_title
from slider.reports.quantities import PAPER, QUANTITIES
from slider.reports.table1 import METRICS

MARKED = re.compile(r"^(<!-- results: (\S+) -->\n).*?^<!-- /results[^\n]*-->", re.S | re.M)
_TABLE1 = ("success_rate", "mse_steady", "mse", "tracking_rate")
_SUMMARY = ("success_rate", "tracking_rate", "mse_steady")
_README = ("success_rate", "mse_steady")
_COMPARED = ("policy", "policy_onboard", "hzd", "mpc_wbc_tuned", "guided_drl")  # in README.md
_STEPS = ("alternation", "touchdown_rate", "flight", "slip", "clearance")
_LEGS = ("leg_distance", "robots_touch", "robots_cross", "heading_worst")
_VARIANCES = ("velocity_variance", "reference_velocity_variance")
_WALKING = (*_STEPS, *_LEGS, *_VARIANCES, "peak_effort", "peak_speed", "cost_of_transport")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("pages", type=Path, nargs="*", help="default: README.md and docs/")
    parser.add_argument(
        "--reports", type=Path, default=Path("reports"), help="folder (default: reports)"
    )
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Fill each table whose report is there; say on stderr which reports are missing."""
    pages = arguments.pages or [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]
    fill = partial(_filled, arguments.reports, Store(arguments.artefacts))
    for page in pages:
        try:
            text = page.read_text(encoding="utf-8")
        except OSError as error:
            raise UserError(f"expected a page at {page}: {error.strerror}") from None
        filled = MARKED.sub(fill, text)
        if filled != text:
            files.write_atomic(page, filled)
            print(f"{page} is filled")


def _filled(reports: Path, store: Store, match: re.Match[str]) -> str:
    name = match[2]
    file, table = BLOCKS.get(name, (f"{name}.md", markdown_tables))
    report = reports / file
    command = f"snakemake -j2 reports/{report.stem}.csv"
    if not report.is_file():
        print(f"slider results: {name} stays, {report} is missing: {command}", file=sys.stderr)
        return match[0]
    jobs = store.mentioning(files.digest_file(report))
    try:
        body = stage_times(jobs, store) if name == "times" else table(report)
    except KeyError as error:
        raise UserError(f"expected the column {error} in {report}, found none") from None
    metadata = [store.metadata(job.stage, job.recipe) for job in jobs]
    oldest = min(metadata, key=lambda fact: str(fact.get("ended", "")), default={})
    return f"{match[1]}\n{body}\n\n{origin(command, oldest)}\n\n<!-- /results -->"


def origin(command: str, metadata: dict[str, Any]) -> str:
    """Line below a table: command, commit, date, machine."""
    command += config_option(str(metadata.get("overrides", "")))
    commit = f"commit `{metadata['commit'][:8]}`" if "commit" in metadata else "commit unknown"
    changed = " with changes" if metadata.get("dirty") == "true" else ""
    date, machine = (
        str(metadata.get("ended", "unknown date"))[:10],
        metadata.get("machine", "unknown"),
    )
    return f"Made by `{command}`, {commit}{changed}, {date}, {machine}."


def across(
    names: Sequence[str], controllers: Sequence[str], report: Path, intervals: bool = True
) -> str:
    """Quantities and controllers down, speeds across; with intervals where the report has them.

    Without intervals a success rate has the tracking rate in parentheses, where that is lower. The
    paper's error stands at both of ours.
    """

    def text(row: Mapping[str, Any], name: str) -> str:
        quantity = QUANTITIES[name]
        if intervals and name == "success_rate":
            return quantity.between(row[name], row["success_low"], row["success_high"])
        if name == "success_rate" and row["tracking_rate"] < row[name]:
            return f"{quantity.text(row[name])} ({quantity.text(row['tracking_rate'])})"
        printed = row.get("source") == PAPER
        return QUANTITIES[name].text(row[(METRICS[name] or name) if printed else name])

    frame = read(report)
    if controllers:
        frame = frame[frame["controller"].isin(controllers)]
    speeds, body = np.sort(frame["speed"].unique()), []
    for name in names:
        title = QUANTITIES[name].heading
        for (_, label), mine in frame.groupby(["controller", "label"], sort=False):
            cells = {row["speed"]: text(row, name) for row in mine.to_dict("records")}
            if set(cells.values()) != {NONE}:
                body.append([title, label, *(cells.get(speed, NONE) for speed in speeds)])
                title = ""
    return Table(["command [m/s]", "", *map(speed_text, speeds)], body).markdown


def summary(report: Path) -> str:
    """Success and error of our controllers and of the paper's policy.

    Below the policy's error stands the range over all trainings of ``seeds_runs.csv``, if any.
    """
    lines = across(_README, _COMPARED, report, intervals=False).splitlines()
    runs = report.with_name("seeds_runs.csv")
    if runs.is_file():
        errors = read(runs)
        speeds = np.sort(read(report)["speed"].unique())
        ends = errors.groupby("speed")["mse_steady"].agg(["min", "max"]).reindex(speeds)
        ranges = ["–".join(map(_two_digits, pair[~np.isnan(pair)])) for pair in ends.to_numpy()]
        seeds = ", ".join(f"{seed:g}" for seed in np.sort(errors["seed"].unique()))
        policy = next(i for i, line in enumerate(lines) if "MSE" in line)
        lines.insert(policy + 1, f"|  | policy (ours), seeds {seeds} | {' | '.join(ranges)} |")
    return "\n".join(lines)


def _two_digits(value: float) -> str:
    return f"{value:#.2g}".rstrip(".")


def markdown_tables(report: Path, count: int | None = None) -> str:
    """Headings, as bold lines, and the first ``count`` tables of a Markdown report."""
    parts: list[str] = []
    for part in report.read_text(encoding="utf-8").split("\n\n"):
        if part.startswith("## "):
            parts.append(f"**{part.removeprefix('## ')}**")
        elif part.startswith("|"):
            parts.append(part.strip("\n"))
            if sum(part.startswith("|") for part in parts) == count:
                break
    return "\n\n".join(parts)


def stage_times(jobs: Sequence[Manifest], store: Store) -> str:
    """Jobs, threads, wall and processor time of each stage that a result was made by."""
    waiting, ancestors = list(jobs[:1]), {}
    while waiting:
        job = waiting.pop()
        ancestors[job.recipe] = job.stage
        recipes = {recipe for group in job.inputs.values() for recipe in group} - set(ancestors)
        waiting += [parse_manifest(p) for r in recipes for p in store.root.glob(f"*/{r}.json")]
    metadata = pd.DataFrame(
        [{"stage": stage} | store.metadata(stage, recipe) for recipe, stage in ancestors.items()],
        columns=["stage", "threads", "wall_s", "cpu_s"],
    )
    stages, body = metadata.groupby("stage"), []
    for stage in in_order(metadata["stage"]):
        mine = stages.get_group(stage)
        minutes = (mine[["wall_s", "cpu_s"]].sum() / 60).map("{:.1f}".format)
        body.append([stage_title(stage), f"{len(mine)}", f"{mine['threads'].max():g}", *minutes])
    heads = ["stage", "jobs", "threads of a job", "wall time of all jobs [min]"]
    return Table([*heads, "processor time [min]"], body).markdown


BLOCKS: dict[str, tuple[str, Callable[[Path], str]]] = {
    "table1": ("table1.csv", partial(across, _TABLE1, ())),
    "summary": ("table1.csv", summary),
    "times": ("table1.csv", str),
    "learning": ("gait_quality.csv", partial(across, _WALKING, ("policy", "hzd", "mpc_wbc_tuned"))),
    "robust": ("robust.csv", partial(across, _SUMMARY, ())),
    "onboard": ("onboard.csv", partial(across, _SUMMARY, ())),
    "gauge": ("gauge.md", partial(markdown_tables, count=1)),
    "sweep": ("sweep.md", partial(markdown_tables, count=1)),
    "stability": ("stability.md", partial(markdown_tables, count=1)),
    "verification": ("verification.md", partial(markdown_tables, count=1)),
    "ablation": ("ablation.md", partial(markdown_tables, count=6)),
    "seeds": ("seeds.md", partial(markdown_tables, count=6)),
    "second_engine": ("second_engine.md", partial(markdown_tables, count=2)),
}
"""Name of the block → report, and the Markdown made from it."""
