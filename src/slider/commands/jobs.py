"""Commands that the pipeline calls: ``slider run`` and ``slider publish``."""

import argparse
import io
import logging
import os
import shutil
import sys
import traceback
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import TextIO

from slider.artefacts.current import add_store_argument
from slider.artefacts.manifest import damaged, parse_manifest
from slider.artefacts.plan import read_plan
from slider.artefacts.runner import Runner
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError, no_memory, not_written

_TAIL = 15  # lines of the log shown after a failure


def run_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``run``."""
    parser.add_argument("recipe", help="recipe of the job")
    parser.add_argument("--plan", type=Path, required=True, help="file below artefacts/plans")
    parser.add_argument("--threads", type=int, default=1, help="processor threads (default: 1)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run the job; on failure show the path and the end of its log."""
    plan = read_plan(arguments.plan)
    spec = plan.jobs.get(arguments.recipe)
    if spec is None or spec.key(spec.input_recipes) != spec.recipe:
        raise UserError(f"expected a recipe of {arguments.plan}, found {arguments.recipe}")
    store = Store(arguments.artefacts)
    log = store.log_path(spec.stage, spec.recipe)
    peers = (job for job in plan.jobs.values() if job.stage == spec.stage)
    waiting = sum(not store.manifest_path(spec.stage, job.recipe).is_file() for job in peers)
    progress = store.progress_path(spec.stage, spec.recipe).absolute()

    def show(message: str) -> None:
        """Write progress to the log, and the latest line to a file for the display of the run."""
        print(message, flush=True)
        progress.parent.mkdir(parents=True, exist_ok=True)
        progress.write_text(message, encoding="utf-8")

    with _output_to(log) as terminal:
        try:
            outcome = Runner(store, arguments.plan, arguments.threads, show, waiting).run(spec)
            print(f"{spec.label}: {outcome}")
        except Exception as error:
            own = error if isinstance(error, UserError) else None
            line = own or not_written(error, store.root) or no_memory(error)
            if line is not None:
                for stream in (terminal, sys.stdout):
                    with suppress(OSError):  # the disk may be full
                        print(f"slider: {spec.label}: {line}", file=stream, flush=True)
                return 1
            traceback.print_exc()
            sys.stderr.flush()
            print(f"slider: {spec.label} failed; {log} ends with", file=terminal)
            with log.open(encoding="utf-8", errors="replace") as file:
                print("".join(f"  {text}" for text in deque(file, _TAIL)).rstrip(), file=terminal)
            return 1
    return 0


@contextmanager
def _output_to(log: Path) -> Iterator[TextIO]:
    """Redirect all output to a log, including that of C libraries; yield the terminal."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with os.fdopen(os.dup(2), "w", buffering=1, encoding="utf-8") as terminal:
        saved = [os.dup(1), os.dup(2)]
        with log.open("wb", buffering=0) as file:
            _redirect((file.fileno(), file.fileno()))
            # Unbuffered: otherwise output that a full disk rejects would end up on the terminal.
            stream = io.TextIOWrapper(file, "utf-8", "replace", write_through=True)
            logging.basicConfig(level=logging.WARNING, stream=stream)
            try:
                with redirect_stdout(stream), redirect_stderr(stream):
                    yield terminal
            finally:
                _redirect((saved[0], saved[1]))


def _redirect(targets: tuple[int, int]) -> None:
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    for descriptor, target in zip((1, 2), targets, strict=True):
        os.dup2(target, descriptor)


def publish_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``publish``."""
    parser.add_argument("manifest", type=Path, help="manifest of the result")
    parser.add_argument(
        "targets", type=Path, nargs="+", help="files to write; the result has some of their names"
    )
    add_store_argument(parser)


def publish(arguments: argparse.Namespace) -> None:
    """Copy each file atomically, so that a target is the old file or the new one."""
    manifest = parse_manifest(arguments.manifest)
    result = manifest.result
    folder = Store(arguments.artefacts).object_folder(result.object)
    for target in arguments.targets:
        if target.name not in result.files:
            raise UserError(f"expected {target.name} in {arguments.manifest}, found none")
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            with suppress(FileNotFoundError):
                shutil.copyfile(folder / target.name, part)
            expected = result.files[target.name].sha256
            if not part.is_file() or files.digest_file(part) != expected:
                raise damaged(manifest.stage, result.object)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
        print(f"{target} is ready")
