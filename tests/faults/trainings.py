"""``python -m tests.faults.trainings``: end trainings at random moments, and compare their bytes.

With one thread and with two; the other number goes on.
"""

import resource
import signal
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from slider.training.trainer import Trainer
from tests.faults.chain import process
from tests.training.test_trainer import KINDS, files, job, of_kind

MOMENTS = 5
ENDED = -signal.SIGPROF  # which nobody handles: as SIGKILL


def run(kind: str, work: Path, threads: int) -> int:
    trainer = Trainer(of_kind(kind), job(work, threads))
    trainer.run()
    for name, content in files(trainer).items():
        (work / f"out_{name}").write_bytes(content)
    return 0


def result(work: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in work.glob("out_*")}


def processor_time() -> float:
    """Of all processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def end_after(seconds: float) -> None:
    """Let the kernel end this process when it has used so much processor time [s]."""
    signal.setitimer(signal.ITIMER_PROF, seconds)


def trial(kind: str, threads: int, folder: Path, random: np.random.Generator) -> tuple[int, int]:
    """How many of some trainings were ended half way, and how many gave the same bytes."""
    before = processor_time()
    whole = process(partial(run, kind, folder / "whole", threads))
    assert whole.status == 0, whole.said
    seconds, ended, same = processor_time() - before, 0, 0
    for number, share in enumerate(random.uniform(0.0, 0.95, MOMENTS)):
        work = folder / str(number)
        first = process(partial(run, kind, work, threads), partial(end_after, share * seconds))
        assert first.status in (0, ENDED), first.said
        again = process(partial(run, kind, work, 3 - threads))
        assert again.status == 0, again.said
        ended += first.status == ENDED
        same += result(work) == result(folder / "whole")
    return ended, same


def main() -> int:
    """Print the counts of each kind of training; status 1 if bytes differ, or nothing ended."""
    failed, random = False, np.random.default_rng(0)
    for kind in KINDS:
        for threads in (1, 2):
            with tempfile.TemporaryDirectory() as folder:
                ended, same = trial(kind, threads, Path(folder), random)
            print(f"{kind:<10}{threads} threads: {ended} of {MOMENTS} ended, {same} the same bytes")
            failed |= same < MOMENTS or ended == 0
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
