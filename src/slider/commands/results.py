"""``slider results``: fill the tables of README.md and docs/ from a finished run.

A page marks a table by ``<!-- results: NAME -->`` and ``<!-- /results -->``. NAME is in ``BLOCKS``,
or any Markdown report of ``reports/``, of which headings and tables are taken.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from slider.artefacts.current import add_store_argument
from slider.artefacts.manifest import Manifest, parse_manifest
from slider.artefacts.run_metadata import config_option
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError
from slider.core.quantities import speed_text
from slider.core.tables import Table, read
from slider.reports.provenance import in_order, stage_title
from slider.reports.quantities import PAPER, QUANTITIES
from slider.reports.report import across

MARKED = re.compile(r"^(<!-- results: (\S+) -->\n).*?^<!-- /results[^\n]*-->", re.S | re.M)
_STEPS = ("alternation", "touchdown_rate", "flight", "slip", "clearance")
_LEGS = ("leg_distance", "robots_touch", "robots_cross", "heading_worst")
_VARIANCES = ("velocity_variance", "reference_velocity_variance")
_LEARNING = "policy", "hzd", "mpc_wbc_tuned"
_SHOWN = ("success_rate", "mse_steady")
_SUMMARY = ("policy", "policy_onboard", "hzd", "mpc_wbc_tuned", "guided_drl")
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
    file, count = BLOCKS.get(name, (f"{name}.md", None))
    report = reports / file
    command = f"snakemake -j2 reports/{report.stem}.csv"
    if not report.is_file():
        print(f"slider results: {name} stays, {report} is missing: {command}", file=sys.stderr)
        return match[0]
    jobs = store.mentioning(files.digest_file(report))
    if name == "times":
        body = stage_times(jobs, store)
    elif name in _OF_CSV:
        try:
            body = _OF_CSV[name](report).markdown
        except KeyError as error:
            raise UserError(f"expected the column {error} in {report}, found none") from None
    else:
        body = markdown_tables(report, count)
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


def learning(report: Path) -> Table:
    """How the policy, HZD and MPC walk: quantities and controllers down, speeds across."""
    frame = read(report)
    frame = frame[frame["controller"].isin(_LEARNING)]
    return across("", "command [m/s]", "speed", _WALKING, frame, ["label"], speed_text)


def summary(report: Path) -> Table:
    """Success and error in Table 1; a lower tracking rate stands in parentheses.

    Below the policy stands the range over all trainings of ``seeds_runs.csv``, if any.
    """
    percent, error = (QUANTITIES[name].text for name in _SHOWN)
    rows = []
    for row in read(report).to_dict("records"):
        success, tracking = row["success_rate"], row["tracking_rate"]
        lower = f" ({percent(tracking)})" if tracking < success else ""
        mse = error(row["mse" if row["source"] == PAPER else "mse_steady"])
        shown = dict(zip(_SHOWN, (percent(success) + lower, mse), strict=True))
        rows.append({name: row[name] for name in ("controller", "label", "speed")} | shown)
    seeds = report.with_name("seeds_runs.csv")
    if seeds.is_file():
        runs = read(seeds)
        label = f"policy (ours), {runs['seed'].nunique()} trainings"
        for speed, mine in runs.groupby("speed"):
            ends = zip(*(mine[[*_SHOWN]].agg(end) for end in ("min", "max")), strict=True)
            texts = [
                "–".join(dict.fromkeys(map(QUANTITIES[name].text, pair)))
                for name, pair in zip(_SHOWN, ends, strict=True)
            ]
            shown = dict(zip(_SHOWN, texts, strict=True))
            rows.append({"controller": "policy", "label": label, "speed": speed} | shown)
    frame = pd.DataFrame(rows)
    frame = frame[frame["controller"].isin(_SUMMARY)]
    frame = frame.sort_values("controller", key=lambda c: c.map(_SUMMARY.index), kind="stable")
    return across("", "command [m/s]", "speed", _SHOWN, frame, ["label"], speed_text)


def markdown_tables(report: Path, count: int | None) -> str:
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


_OF_CSV = {"learning": learning, "summary": summary}
BLOCKS: dict[str, tuple[str, int | None]] = {
    "summary": ("table1.csv", None),
    "times": ("table1.csv", None),
    "learning": ("gait_quality.csv", None),
    **{name: (f"{name}.md", 1) for name in ("gauge", "sweep", "stability", "verification")},
    **{name: (f"{name}.md", 6) for name in ("ablation", "seeds")},
    "second_engine": ("second_engine.md", 2),
}
"""Name of the block → report, and how many of its tables; of others all."""
