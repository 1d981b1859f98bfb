"""``slider results``: fill the tables of README.md and docs/ from a finished run.

A page marks a table by ``<!-- results: NAME -->`` and ``<!-- /results -->``. NAME is in ``BLOCKS``,
or a Markdown report of ``reports/``, whose headings and tables are copied. The end mark of a
filled table lists its targets with the digests of their plan (``JobSpec.plan_digests``). A table
whose plan differs from the current one is marked as outdated. A filled table is replaced only by
one of the same settings or of the same ``--config``.
"""

import argparse
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import bootstrap

from slider.artefacts.current import add_store_argument, current_plan, recent_plans
from slider.artefacts.manifest import Manifest, readable
from slider.artefacts.run_metadata import config_option
from slider.artefacts.store import ARTEFACTS, Store
from slider.config.control import ONBOARD, POLICY_LABEL
from slider.core import files
from slider.core.errors import UserError, require
from slider.core.quantities import speed_text
from slider.core.tables import Table, read
from slider.reports.provenance import in_order, stage_title
from slider.reports.quantities import PAPER, QUANTITIES
from slider.reports.report import across

MARKED = re.compile(r"^(<!-- results: (\S+) -->\n).*?^<!-- /results[^\n]*-->", re.S | re.M)
_ORIGIN = re.compile(r"^(Made by `([^`]*)`[^\n]*?)( Since then [^\n]*)?$", re.M)
_DIGESTS = re.compile(r" (\w+) settings (\w+) source (\w+)")
_STEPS = ("alternation", "touchdown_rate", "flight", "slip", "clearance")
_LEGS = ("leg_distance", "robots_touch", "robots_cross", "heading_worst")
_VARIANCES = ("velocity_variance", "reference_velocity_variance")
_LEARNING = "policy", "hzd", "mpc_wbc_tuned"
_ERROR = "mse_steady"
_COMPARABLE = 0.01  # of the survivors, as in Table 1
_RATES = {"success_rate": "survive", "tracking_rate": "track"}
_SUMMARY = ("policy", "policy_onboard", "hzd", "mpc_wbc_tuned", "guided_drl")
_WALKING = (*_STEPS, *_LEGS, *_VARIANCES, "peak_effort", "peak_speed", "cost_of_transport")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("pages", type=Path, nargs="*", help="default: README.md and docs/")
    parser.add_argument("--reports", type=Path, default=Path("reports"), help="default: reports")
    parser.add_argument("--check", action="store_true", help="list tables of another plan")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Fill each table whose report exists and mark outdated tables; with ``--check`` list those.

    Missing reports are listed on stderr, and tables of another ``--config``: of named pages they
    are status 1.
    """
    pages = arguments.pages or [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]
    outdated, refused = False, list[str]()
    fill = partial(_filled, arguments.reports, Store(arguments.artefacts), refused)
    for page in pages:
        text = page.read_text(encoding="utf-8")
        filled = text if arguments.check else MARKED.sub(fill, text)
        for block in MARKED.finditer(filled):
            change = changed_since(block[0])
            outdated = outdated or bool(change)
            if change and arguments.check:
                print(f"{page}: {block[2]}: {change}")
            if not arguments.check:
                sentence = f"\\1 Since then {change}." if change else "\\1"
                filled = filled.replace(block[0], _ORIGIN.sub(sentence, block[0]))
        if filled != text:
            files.write_atomic(page, filled)
            print(f"{page} is filled")
    return int(bool(refused and arguments.pages) or (outdated and arguments.check))


def changed_since(block: str) -> str:
    """Which part of a table's plan has changed since; empty if none, or if it was never filled."""
    origin = _ORIGIN.search(block)
    if origin is None:
        return ""
    made = _DIGESTS.findall(block.splitlines()[-1])
    if not made:
        return "settings may have changed"  # its plan is unknown
    plan = _todays_digests(*shlex.split(origin[2]))
    if not plan:  # for example, an extra is not installed
        return (origin[3] or "").removeprefix(" Since then ").removesuffix(".")
    for place, part in enumerate(("settings", "source"), 1):
        if not all(plan.get(m[0], {}).get(part, "").startswith(m[place]) for m in made):
            return f"{'settings have' if part == 'settings' else 'the source has'} changed"
    return ""


@cache
def _todays_digests(*command: str) -> dict[str, dict[str, str]]:
    """Plan digests by target, from a dry run of a ``snakemake`` command on this checkout.

    Empty if the dry run fails, which is reported on stderr.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "docs").symlink_to(Path("docs").absolute())  # some robots are examples
        place = ["--snakefile", f"{Path.cwd()}/Snakefile", "--directory", folder]
        dry = [sys.executable, "-I", "-m", command[0], "-n", *place, *command[1:]]
        done = subprocess.run(dry, check=False, capture_output=True, text=True)
        plan = current_plan(Store(Path(folder) / ARTEFACTS)) if done.returncode == 0 else None
    if plan is None:
        lines = "".join(line for line in done.stderr.splitlines(True) if "slider: " in line)
        print(f"{shlex.join(command)}: {lines or done.stderr}", end="", file=sys.stderr)
        return {}
    return {target: plan.jobs[recipe].plan_digests for target, recipe in plan.targets.items()}


def _filled(reports: Path, store: Store, refused: list[str], match: re.Match[str]) -> str:
    name = match[2]
    file, body, *others = BLOCKS.get(name, (f"{name}.md", markdown_tables))
    report = reports / file
    targets = [file if report.suffix == ".svg" else f"{report.stem}.csv", *others]
    command = " ".join(["snakemake -j2", *(f"reports/{target}" for target in targets)])
    read_from = [report, *(reports / target for target in targets[1:])]
    missing = [path for path in read_from if not path.is_file()]
    if missing:
        print(
            f"slider results: {name} is unchanged, no {missing[0]}: {command}",
            file=sys.stderr,
        )
        return match[0]
    jobs = [job for path in read_from for job in _newest(path, store)]
    runs = _run_metadata(jobs, store)
    try:
        text = body(report) if body else stage_times(runs)
    except KeyError as error:
        raise UserError(f"expected the column {error} in {report}, found none") from None
    latest = store.metadata(jobs[0].stage, jobs[0].recipe) if jobs else {}
    digests = "".join(_digests(job.recipe, store) for job in jobs)
    made = origin(command, latest, runs["cpu_s"].sum(min_count=1) / 60)
    before, settings = _ORIGIN.search(match[0]), _settings(match[0])
    if before and settings != _settings(digests):
        old, new = (_overrides(line) or "no --config" for line in (before[0], made))
        if old != new:
            line = f"expected {report} made with {old}, found {new}; empty the block to replace it"
            print(f"slider results: {name} is unchanged: {line}", file=sys.stderr)
            refused.append(name)
            return match[0]
    return f"{match[1]}\n{text}\n\n{made}\n\n<!-- /results{digests} -->"


def _newest(report: Path, store: Store) -> list[Manifest]:
    """Manifest of the latest job that produced a report, if the store has one."""
    jobs = store.mentioning(files.digest_file(report))
    jobs.sort(key=lambda job: str(store.metadata(job.stage, job.recipe).get("ended", "")))
    return jobs[-1:]


def _digests(recipe: str, store: Store) -> str:
    """Target and plan digests of a recipe, as text of an end mark; empty if no plan has it."""
    for plan in recent_plans(store):
        for target, other in plan.targets.items():
            if other == recipe:
                digests = plan.jobs[recipe].plan_digests.items()
                return " ".join(["", target, *(f"{part} {d[:12]}" for part, d in digests)])
    return ""


def origin(command: str, metadata: dict[str, Any], minutes: float) -> str:
    """Line below a table: command, commit, date, processor time of all jobs, machine."""
    command += config_option(str(metadata.get("overrides", "")))
    commit = f"commit `{metadata['commit'][:8]}`" if "commit" in metadata else "commit unknown"
    changed = " with changes" if metadata.get("dirty") == "true" else ""
    date, machine = metadata.get("ended", "unknown date")[:10], metadata.get("machine", "unknown")
    time = "unknown processor time" if np.isnan(minutes) else f"{minutes:.0f} min of processor time"
    return f"Made by `{command}`, {commit}{changed}, {date}, {time}, {machine}."


def _settings(mark: str) -> set[tuple[str, str]]:
    """Targets and digests of their settings in an end mark."""
    return {(target, settings) for target, settings, _ in _DIGESTS.findall(mark)}


def _overrides(line: str) -> str:
    """Value of ``--config`` of the command in a line of :func:`origin`; empty without it."""
    command = shlex.split(line.split("`")[1])
    return command[-1].strip() if "--config" in command else ""


def picture(report: Path) -> str:
    """Copy a figure that README shows to ``docs/images``."""
    image = Path("docs/images", report.name)
    files.write_atomic(image, report.read_text(encoding="utf-8"))
    return f"![Velocity error over cost of transport of each controller]({image.as_posix()})"


def learning(report: Path) -> str:
    """Gait quality of policy, HZD and MPC: rows are quantities and controllers, columns speeds."""
    frame = read(report)
    frame = frame[frame["controller"].isin(_LEARNING)]
    return across("", "command [m/s]", "speed", _WALKING, frame, ["label"], speed_text).markdown


def summary(report: Path) -> str:
    """Errors of Table 1, with the rates of survival and tracking where they are below 100 %."""
    return _errors(_summarised(report)).markdown


def overview(report: Path) -> str:
    """The summary, with median and range of the policy over trainings with several seeds."""
    frame, runs = _summarised(report), read(report.with_name("seeds_runs.csv"))
    speeds, mine = runs.groupby("speed"), frame["controller"] == "policy"
    _check_speeds(frame[mine], runs)
    values = speeds[[*_RATES]].min().assign(**{_ERROR: speeds[_ERROR].median()})
    frame.loc[mine, [*values]] = values.loc[frame.loc[mine, "speed"]].to_numpy()
    frame.loc[mine, "label"] += f", median of {runs['seed'].nunique()} trainings"
    ends = (speeds[_ERROR].agg(end).map(QUANTITIES[_ERROR].text) for end in ("min", "max"))
    (first, *others) = (table := _errors(frame)).rows
    rows = [first, ["", "range", *map("–".join, zip(*ends, strict=True))], *others]
    return table._replace(rows=rows).markdown


def _summarised(report: Path) -> pd.DataFrame:
    frame = read(report)
    frame = frame[frame["controller"].isin(_SUMMARY)].astype(dict.fromkeys(_RATES, float))
    printed = frame["source"] == PAPER  # the paper has one MSE, with or without warm-up
    frame[_ERROR] = frame[_ERROR].mask(printed, frame["mse"])
    return frame.sort_values("controller", key=lambda c: c.map(_SUMMARY.index), kind="stable")


def _errors(frame: pd.DataFrame) -> Table:
    """Errors and rates; the least error with the true state is bold, among the best survivors."""
    rivals = frame[(frame["source"] != PAPER) & ~frame["controller"].str.endswith(ONBOARD)]
    most = rivals.groupby("speed")["success_rate"].transform("max")
    rivals = rivals[rivals["success_rate"] >= most - _COMPARABLE]
    least, texts = rivals.groupby("speed")[_ERROR].min().map(QUANTITIES[_ERROR].text), []
    for index, row in zip(frame.index, frame.to_dict("records"), strict=True):
        error = QUANTITIES[_ERROR].text(row[_ERROR])
        if index in rivals.index and error == least[row["speed"]]:
            error = f"**{error}**"
        rates = ", ".join(
            f"{QUANTITIES[n].text(row[n])} % {verb}" for n, verb in _RATES.items() if row[n] < 1.0
        )
        texts.append(f"{error} ({rates})" if rates else error)
    frame = frame.assign(**{_ERROR: texts})
    return across("", "command [m/s]", "speed", [_ERROR], frame, ["label"], speed_text)


def trainings(report: Path) -> str:
    """Difference between the mean over trainings with several seeds and the tuned MPC."""
    runs = read(report.with_name("seeds_runs.csv"))
    mpc = read(report.with_name("table1.csv")).query("controller == 'mpc_wbc_tuned'")
    _check_speeds(mpc, runs)
    rows, mpc, speeds = [], mpc.set_index("speed"), runs.groupby("speed")
    for name in ("success_rate", _ERROR):
        shown = QUANTITIES[name]
        away = (_interval(mine - mpc.at[v, name], shown.text) for v, mine in speeds[name])
        rows.append([shown.heading, *away])
    return Table(["command [m/s]", *map(speed_text, speeds.groups)], rows).markdown


def _check_speeds(frame: pd.DataFrame, runs: pd.DataFrame) -> None:
    """Reject runs of a study at other speeds than those of Table 1."""
    ours, theirs = (sorted(set(values["speed"].dropna())) for values in (frame, runs))
    require(ours == theirs, "seeds_runs.csv", f"the speeds of table1.csv, {ours}", theirs)


def _interval(differences: pd.Series, text: Callable[[float], str]) -> str:
    """95 % bootstrap confidence interval of a mean; "no difference" if it contains zero."""
    values = differences.to_numpy(float)
    low, high = values[0], values[0]
    if np.ptp(values) > 0:
        low, high = bootstrap((values,), np.mean, method="percentile", rng=0).confidence_interval
    if low * high <= 0:
        return "no difference"
    return " to ".join(
        dict.fromkeys(f"{'+' if end > 0 else '−'}{text(abs(end))}" for end in (low, high))
    )


def robots(report: Path) -> str:
    """A row per robot: its overrides, and the survival and tracking rates of each controller."""
    frame = read(report).fillna({"changes": ""})
    frame["text"] = (100 * frame["mean"]).map("{:.0f}".format)
    texts = frame.groupby(["metric", "variant"])["text"].agg(list)
    labels = frame.drop_duplicates("variant").set_index("variant")[["label", "changes"]]
    mine, beside = labels[labels["changes"] != ""], {*labels.index[labels["changes"] == ""]}
    first, name = mine.index[0], f"{mine['label'].iloc[0]}, "
    ends = [variant.removeprefix(first) for variant in labels.index if variant in beside]
    ends = [end for end in ends if all(robot + end in beside for robot in mine.index)]
    body = []
    for robot, label, changes in mine.itertuples():
        rates = ([texts[rate, robot + end] for rate in _RATES] for end in ("", *ends))
        cells = (" ".join(map("/".join, zip(*pair, strict=True))) for pair in rates)
        body.append([label, f"`{changes}`", *cells])
    heads = [labels.at[first + end, "label"].removeprefix(name) for end in ends]
    return Table(["robot", "overrides", POLICY_LABEL, *heads], body).markdown


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


def _run_metadata(jobs: list[Manifest], store: Store) -> pd.DataFrame:
    """Stage, threads, wall and processor time of some jobs and of all that they depend on."""
    waiting, seen, runs = [*jobs], set[str](), {}
    while waiting:
        job = waiting.pop()
        seen.add(job.recipe)
        metadata = store.metadata(job.stage, job.recipe)
        runs[metadata.get("reused_from", job.recipe)] = {"stage": job.stage} | metadata
        recipes = {recipe for group in job.inputs.values() for recipe in group} - seen
        paths = [path for recipe in recipes for path in store.root.glob(f"*/{recipe}.json")]
        waiting += [manifest for path in paths if (manifest := readable(path))]
    return pd.DataFrame([*runs.values()], columns=["stage", "threads", "wall_s", "cpu_s"])


def stage_times(runs: pd.DataFrame) -> str:
    """Jobs, threads, wall and processor time of each stage."""
    stages, body = runs.groupby("stage"), []
    for stage in in_order(runs["stage"]):
        mine = stages.get_group(stage)
        minutes = (mine[["wall_s", "cpu_s"]].sum() / 60).map("{:.1f}".format)
        body.append([stage_title(stage), f"{len(mine)}", f"{mine['threads'].max():g}", *minutes])
    heads = ["stage", "jobs", "threads of a job", "wall time of all jobs [min]"]
    return Table([*heads, "processor time [min]"], body).markdown


_COUNTS = {"gauge": 1, "sweep": 1, "stability": 1, "verification": 1, "second_engine": 2}
_COUNTS |= {"ablation": 8, "seeds": 6}
BLOCKS: dict[str, tuple[str, Callable[[Path], str] | None, *tuple[str, ...]]] = {
    "trainings": ("seeds.csv", trainings, "table1.csv"),
    "overview": ("table1.csv", overview, "seeds.csv"),
    "tradeoff": ("figures/tradeoff.svg", picture),
    "summary": ("table1.csv", summary),
    "robots": ("robots.csv", robots),
    "times": ("table1.csv", None),
    "learning": ("gait_quality.csv", learning),
    **{n: (f"{n}.md", partial(markdown_tables, count=count)) for n, count in _COUNTS.items()},
}
"""Name of the block → report, function that converts it, further reports that it reads."""
