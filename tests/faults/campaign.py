"""``python -m tests.faults.campaign N``: break the store in every way, and see what becomes of it.

Each trial ends with the true table or, before that, with one line that says what to do. Each N-th
one is taken.
"""

import errno
import os
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from tests.faults.chain import TRUTH, Chain, Ended, chain, process
from tests.faults.operations import count, kill_at, no_file_beyond, no_reading_at, no_space_from

SIZES = (0, 1, 20, 200, 2000)  # of the largest file on a full disk [bytes]
PLACES = {"first byte": 0.0, "middle": 0.5, "last byte": 1.0}


@dataclass(frozen=True)
class Trial:
    """What is done to a pipeline in an empty folder of its own."""

    kind: str
    name: str
    act: Callable[[Chain], object]


def trials(whole: Chain, scratch: Path) -> Iterator[Trial]:
    """All of them; ``whole`` is a finished pipeline, to be copied."""
    for name in whole.actions:
        for number in range(1, operations(whole, name, scratch) + 1):
            at = f"{name}, operation {number}"
            yield Trial("killed at a file operation", at, broken(name, kill_at, number))
            yield Trial("disk full at a file operation", at, broken(name, no_space_from, number))
        for size in SIZES:
            at = f"{name}, {size} bytes"
            yield Trial("disk full within a file", at, broken(name, no_file_beyond, size))
    for name in (*whole.actions, *whole.care):
        for number in range(1, readings(whole, name, scratch) + 1):
            for code in (errno.EIO, errno.EMFILE, errno.EACCES):
                at = f"{name}, reading {number}, {errno.errorcode[code]}"
                yield Trial("a passing fault", at, unread(whole, name, number, code))
    for path in sorted(whole.folder.rglob("*")):
        if path.is_file():
            yield from of_a_file(whole, path.relative_to(whole.folder))


def of_a_file(whole: Chain, where: Path) -> Iterator[Trial]:
    for name, share in PLACES.items():

        def flip(path: Path, share: float = share) -> None:
            content = bytearray(path.read_bytes())
            if content:
                content[round(share * (len(content) - 1))] ^= 1
                path.chmod(0o644)
                path.write_bytes(bytes(content))

        yield Trial("a flipped bit", f"{where}, {name}", damaged(whole, flip, where))
    yield Trial("a lost file", str(where), damaged(whole, Path.unlink, where))


def operations(whole: Chain, name: str, scratch: Path) -> int:
    """How many file operations an action takes in a pipeline that comes from nothing."""
    fresh = Chain(Path(tempfile.mkdtemp(dir=scratch)) / "chain", whole.plan)
    note = scratch / "count"
    assert broken(name, lambda root, _: count(root, note), 0)(fresh).status == 0
    return int(note.read_text())


def readings(whole: Chain, name: str, scratch: Path) -> int:
    """How much an action reads in a finished pipeline."""
    copied = whole.copy(Path(tempfile.mkdtemp(dir=scratch)) / "chain")
    note = scratch / "count"
    action = (copied.actions | copied.care)[name]
    assert process(action, count(copied.folder, note, reading=True)).status == 0
    return int(note.read_text())


def unread(whole: Chain, name: str, number: int, code: int):
    """One reading fails in a finished pipeline: it loses nothing."""

    def act(pipeline: Chain) -> None:
        whole.copy(pipeline.folder)
        before = pipeline.content()
        action = (pipeline.actions | pipeline.care)[name]
        ended = process(action, no_reading_at(pipeline.folder, number, code))
        assert "Traceback" not in ended.said, ended.said
        assert ended.status == 0 or os.strerror(code) in ended.said, ended
        lost = before.keys() - pipeline.content().keys()
        assert not lost, f"{ended}: lost {lost}"

    return act


def broken(name: str, fault: Callable[[Path, int], Callable[[], None]], number: int):
    """An action with a fault in it, after all that come before it."""

    def act(pipeline: Chain) -> Ended:
        for other, action in pipeline.actions.items():
            if other == name:
                break
            assert process(action).status == 0
        return process(pipeline.actions[name], fault(pipeline.folder, number))

    return act


def damaged(whole: Chain, damage: Callable[[Path], object], place: Path):
    """A finished pipeline, after damage to a place."""
    return lambda pipeline: damage(whole.copy(pipeline.folder).folder / place)


def outcome(trial: Trial, pipeline: Chain) -> str:
    """What became of a trial; an error if it was neither the true table nor one line."""
    ended = trial.act(pipeline)
    if isinstance(ended, Ended) and ended.status not in (0, -signal.SIGKILL):
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
    lines = ended.said.splitlines()
    return ended.status == 1 and len(lines) == 1 and lines[0].startswith("slider: ")


def expect(met: bool, trial: Trial, found: object) -> None:
    if not met:
        raise AssertionError(f"{trial.kind}: {trial.name}: found {found}")


def main() -> int:
    """Print the counts of each kind and outcome; status 1 if a trial failed."""
    every, counts = int(sys.argv[1]), Counter[str]()
    with tempfile.TemporaryDirectory() as name, chain(Path(name)) as whole:
        assert whole.complete().status == 0
        for number, trial in enumerate(islice(trials(whole, Path(name)), 0, None, every)):
            pipeline = Chain(Path(name) / "trials" / str(number) / "chain", whole.plan)
            try:
                counts[f"{trial.kind:<36}{outcome(trial, pipeline)}"] += 1
            except AssertionError as error:
                counts["failed"] += 1
                print(error, file=sys.stderr)
    for kind, number in sorted(counts.items()):
        print(f"{kind:<56}{number:>5}")
    return int("failed" in counts)


if __name__ == "__main__":
    sys.exit(main())
