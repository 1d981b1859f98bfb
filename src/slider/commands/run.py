"""``slider run``: run one job of a plan, with its output in a log file."""

import argparse
import logging
import os
import signal
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from slider.artefacts.plan import JobSpec, Plan, jobs_towards, read_plan
from slider.artefacts.runner import Runner
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.disk import not_written
from slider.core.errors import UserError

_QUIET, _LONG_QUIET = 5.0, 30.0  # between two progress lines of a job: at first, at most [s]
_TAIL = 15  # lines of the log shown after a failure


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("recipe", help="recipe of the job")
    parser.add_argument("--plan", type=Path, required=True, help="file below artefacts/plans")
    parser.add_argument("--threads", type=int, default=1, help="processor threads (default: 1)")
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the job; on failure show the end of its log and where the log is."""
    plan = read_plan(arguments.plan)
    spec = plan.jobs.get(arguments.recipe)
    if spec is None:
        raise UserError(f"expected a recipe of {arguments.plan}, found {arguments.recipe}")
    store = Store(arguments.artefacts)
    log = store.log_path(spec.stage, spec.recipe)
    for number in (signal.SIGINT, signal.SIGTERM):  # end tidily and without a trace
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    with _output_to(log) as terminal:
        runner = Runner(store, arguments.threads, progress_lines(spec.label, terminal))
        try:
            outcome = runner.run(spec)
            print(f"{_progress_count(store, plan, spec)} {spec.label}: {outcome}", file=terminal)
        except Exception as error:
            known = error if isinstance(error, UserError) else not_written(error, store.root)
            if known is not None:
                _say(f"slider: {spec.label}: {known}", terminal)
                return 1
            traceback.print_exc()
            sys.stderr.flush()
            print(f"slider: {spec.label} failed; {log} ends with", file=terminal)
            print(_tail(log), file=terminal)
            return 1
    return 0


@contextmanager
def _output_to(log: Path) -> Iterator[TextIO]:
    """Send all output to a log, libraries written in C included; yield the terminal."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with os.fdopen(os.dup(2), "w", buffering=1) as terminal:
        saved = [os.dup(1), os.dup(2)]
        with log.open("wb", buffering=0) as file:
            _redirect((file.fileno(), file.fileno()))
        logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
        try:
            yield terminal
        finally:
            _redirect((saved[0], saved[1]))


def _say(line: str, terminal: TextIO) -> None:
    """Write a line to the terminal and to the log, unless there is no space for it."""
    print(line, file=terminal)
    with suppress(OSError):
        print(line, flush=True)


def _redirect(targets: tuple[int, int]) -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # no space for the end of the log
            stream.flush()
    for descriptor, target in zip((1, 2), targets, strict=True):
        os.dup2(target, descriptor)


def _progress_count(store: Store, plan: Plan, spec: JobSpec) -> str:
    """How many results are there of what the job leads to, whenever they were computed."""
    jobs = jobs_towards(plan, spec.recipe).values()
    done = sum(store.manifest_path(job.stage, job.recipe).is_file() for job in jobs)
    return f"[{done}/{len(jobs)}]"


def progress_lines(label: str, terminal: TextIO) -> Callable[[str], None]:
    """All progress goes to the log, and a line to the terminal, of long jobs ever less often."""
    start = last = time.monotonic()

    def show(message: str) -> None:
        nonlocal last
        print(message, flush=True)
        now = time.monotonic()
        if now - last >= min(max(_QUIET, (now - start) / 4), _LONG_QUIET):
            last = now
            print(f"{label}: {message}", file=terminal)

    return show


def _tail(log: Path) -> str:
    with log.open(encoding="utf-8", errors="replace") as file:
        return "".join(f"  {line}" for line in deque(file, _TAIL)).rstrip()
