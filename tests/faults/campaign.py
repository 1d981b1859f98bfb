"""``python -m tests.faults.campaign``: break the store in every way, and see what becomes of it.

Each trial ends with the true table or, before that, with one line that says what to do. ``--every
N`` takes each N-th trial.
"""

import argparse
import json
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from pathlib import Path

from tests.faults.chain import TRUTH, Chain, Ended, chain, no_file_beyond, process
from tests.faults.operations import count, kill_at, no_space_from

SIZES = (0, 1, 20, 200, 2000)  # of the largest file on a full disk [bytes]
PLACES = {"first byte": 0.0, "middle": 0.5, "last byte": 1.0}


@dataclass(frozen=True)
class Trial:
    """What is done to a pipeline in an empty folder of its own."""

    kind: str
    name: str
    act: Callable[[Chain], "Ended | None"]


def trials(whole: Chain, scratch: Path) -> Iterator[Trial]:
    """All of them; ``whole`` is a finished pipeline, to be copied."""
    for name in whole.actions:
        for number in range(1, operations(whole, name, scratch) + 1):
            at = f"{name}, operation {number}"
            yield Trial("killed at a file operation", at, broken(name, kill_at, number))
            yield Trial("disk full at a file operation", at, broken(name, no_space_from, number))
        for size in SIZES:
            at = f"{name}, {size} bytes"
            yield Trial("disk full within a file", at, limited(name, size))
    for path in sorted(whole.folder.rglob("*")):
        if path.is_file():
            where = path.relative_to(whole.folder)
            for name, share in PLACES.items():
                at = f"{where}, {name}"
                yield Trial("a flipped bit", at, flipped(whole, where, share))
                if where.parts[1] == "objects":
                    act = flipped(whole, where, share, forget=True)
                    yield Trial("a flipped bit before further jobs", at, act)
            yield Trial("a lost file", str(where), lost(whole, where))
        elif path.is_relative_to(whole.store.root) and path != whole.store.root:
            where = where_in(path, whole)
            yield Trial("a file for a folder", str(where), blocked(whole, where))
    for pattern in ("gait/" + "?" * 64 + ".json", "index/*/*.json"):
        paths = sorted(whole.store.root.glob(pattern))
        for first, second in combinations([where_in(path, whole) for path in paths], 2):
            names = f"{first} and {second}"
            yield Trial("two manifests swapped", names, swapped(whole, first, second))
            yield Trial("another's object", names, redirected(whole, first, second))


def where_in(path: Path, whole: Chain) -> Path:
    return path.relative_to(whole.folder)


def operations(whole: Chain, name: str, scratch: Path) -> int:
    """How many file operations an action takes in a pipeline that comes from nothing."""
    fresh = Chain(Path(tempfile.mkdtemp(dir=scratch)) / "chain", whole.plan)
    note = scratch / "count"
    before(fresh, name)
    assert process(fresh.actions[name], count(fresh.folder, note)).status == 0
    return int(note.read_text())


def before(pipeline: Chain, name: str) -> None:
    """Do what comes before an action."""
    for other, action in pipeline.actions.items():
        if other == name:
            return
        assert process(action).status == 0


def broken(name: str, fault: Callable[[Path, int], Callable[[], None]], number: int):
    def act(pipeline: Chain) -> Ended:
        before(pipeline, name)
        return process(pipeline.actions[name], fault(pipeline.folder, number))

    return act


def limited(name: str, size: int):
    def act(pipeline: Chain) -> Ended:
        before(pipeline, name)
        return process(pipeline.actions[name], lambda: no_file_beyond(size))

    return act


def flipped(whole: Chain, where: Path, share: float, forget: bool = False):
    """Flip a bit; with ``forget`` the training and the table are computed again."""

    def act(pipeline: Chain) -> None:
        path = whole.copy(pipeline.folder).folder / where
        for place in ("index", "walking", "table1") if forget else ():
            shutil.rmtree(pipeline.store.root / place)
        content = bytearray(path.read_bytes())
        if content:
            content[round(share * (len(content) - 1))] ^= 1
            path.chmod(0o644)
            path.write_bytes(bytes(content))

    return act


def lost(whole: Chain, where: Path):
    def act(pipeline: Chain) -> None:
        (whole.copy(pipeline.folder).folder / where).unlink()

    return act


def blocked(whole: Chain, where: Path):
    """Put a file in the place of a folder."""

    def act(pipeline: Chain) -> None:
        path = whole.copy(pipeline.folder).folder / where
        shutil.rmtree(path)
        path.write_text("")

    return act


def swapped(whole: Chain, first: Path, second: Path):
    """Exchange two files, and forget the table."""

    def act(pipeline: Chain) -> None:
        folder = whole.copy(pipeline.folder).folder
        content = (folder / first).read_bytes()
        (folder / second).replace(folder / first)
        (folder / second).write_bytes(content)
        forget_table(pipeline)

    return act


def redirected(whole: Chain, first: Path, second: Path):
    """Let a manifest name the object of another, and forget the table."""

    def act(pipeline: Chain) -> None:
        folder = whole.copy(pipeline.folder).folder
        values, other = (json.loads((folder / path).read_text()) for path in (first, second))
        values |= {name: other[name] for name in ("object", "files", "summary")}
        (folder / first).write_text(json.dumps(values))
        forget_table(pipeline)

    return act


def forget_table(pipeline: Chain) -> None:
    """Let all that follows the gaits be computed again."""
    for stage in ("library", "walking", "table1"):
        shutil.rmtree(pipeline.store.root / stage)


def outcome(trial: Trial, pipeline: Chain) -> str:
    """What became of a trial; an error if it was neither the true table nor one line."""
    ended = trial.act(pipeline)
    if ended and ended.status not in (0, -signal.SIGKILL):
        expect(is_one_line(ended), trial, ended)
    again = pipeline.complete()
    word = "at once"
    if again.status:
        expect(is_one_line(again), trial, again)
        pipeline.verify()
        again, word = pipeline.complete(), "after store verify"
    expect(again.status == 0, trial, again)
    expect(pipeline.report.read_text() == TRUTH, trial, pipeline.report.read_text())
    first = pipeline.verify()
    if first.status:  # what nobody needed was damaged: it goes once
        expect("Traceback" not in first.said, trial, first)
        expect(pipeline.complete().status == 0, trial, "incomplete")
    last = pipeline.verify()
    expect(last.status == 0, trial, last)
    expect(pipeline.report.read_text() == TRUTH, trial, pipeline.report.read_text())
    return word


def is_one_line(ended: Ended) -> bool:
    return ended.status == 1 and len(ended.lines) == 1 and ended.said.startswith("slider: ")


def expect(met: bool, trial: Trial, found: object) -> None:
    if not met:
        raise AssertionError(f"{trial.kind}: {trial.name}: found {found}")


def run(every: int, only: str, scratch: Path) -> tuple[Counter[tuple[str, str]], list[str]]:
    """Counts of (kind, outcome), and what failed."""
    counts: Counter[tuple[str, str]] = Counter()
    failures = []
    with chain(scratch) as whole:
        assert whole.complete().status == 0
        wanted = (trial for trial in trials(whole, scratch) if only in trial.kind)
        for number, trial in enumerate(islice(wanted, 0, None, every)):
            pipeline = Chain(scratch / "trials" / str(number) / "chain", whole.plan)
            try:
                counts[trial.kind, outcome(trial, pipeline)] += 1
            except AssertionError as error:
                failures.append(str(error))
    return counts, failures


def main(arguments: list[str] | None = None) -> int:
    """Print the counts; status 1 if a trial failed."""
    parser = argparse.ArgumentParser("faults", description=__doc__)
    parser.add_argument("--every", type=int, default=1, metavar="N", help="each N-th trial")
    parser.add_argument("--only", default="", metavar="KIND", help="part of the name of a kind")
    chosen = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        counts, failures = run(chosen.every, chosen.only, Path(scratch))
    for (kind, word), number in sorted(counts.items()):
        print(f"{kind:<36}{word:<20}{number:>5}")
    for failure in failures:
        print(failure, file=sys.stderr)
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
