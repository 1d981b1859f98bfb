"""Real jobs that signals interrupt: the bytes of the undisturbed ones.

A gait, a training, an evaluation and a search for settings run as the Snakefile runs them; ``make
faults`` interrupts each at many moments.
"""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import product
from pathlib import Path

import pytest

from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import baseline_tuning
from slider.artefacts.plan import JobSpec, build_plan, write_plan
from slider.artefacts.store import Store
from slider.core import environment
from tests.config.composed import composed

SIGNALS = (signal.SIGINT, signal.SIGTERM)
MOMENTS = 10  # of each job and signal
BUILT = "built"  # the progress of a gait whose solver begins
OVERRIDES = (
    *("experiment=test", "gait.grid.vx=[0.4]", "gait.grid.vy=[0.0,0.1]"),
    *("train.walking.iterations=12", "train.walking.selection.interval=3"),
    *("evaluation.duration=3", "evaluation.robots=20"),
    *("tuning.trials=4", "tuning.finalists=2", "tuning.finalist_robots=4"),
)


class Jobs:
    """Jobs below a folder; ``specs`` are those to be interrupted."""

    def __init__(self, folder: Path) -> None:
        config = composed(*OVERRIDES)
        targets = table1_jobs(config)
        self.specs = {
            "gait": targets["library"].inputs["gaits"][1],  # which has an anchor
            "training": targets["walking"],
            "evaluation": targets["table1"].inputs["evaluations"][0],
            "search": baseline_tuning(config, targets).inputs["searches"][0],
        }
        self.store = Store(folder / "artefacts")
        plan = write_plan(build_plan(self.specs), self.store.root / "plans")
        self.command = [sys.executable, "-I", "-X", "utf8", environment.__file__, "run"]
        self.command += ["--plan", str(plan), "--artefacts", str(self.store.root)]

    def start(self, spec: JobSpec) -> "subprocess.Popen[bytes]":
        return subprocess.Popen([*self.command, spec.recipe], cwd=self.store.root)

    def is_done(self, spec: JobSpec) -> bool:
        return self.store.manifest_path(spec.stage, spec.recipe).is_file()

    def run(self, spec: JobSpec) -> str:
        """Run a job, and those that it needs, to the end; its object."""
        if not self.is_done(spec):
            for need in spec.needs:
                self.run(need)
            assert self.start(spec).wait() == 0, spec.label
        return self.store.read_manifest(spec.stage, spec.recipe).result.object

    def forget(self, spec: JobSpec) -> None:
        """Let the next job compute the result anew."""
        self.store.index_path(self.store.read_manifest(spec.stage, spec.recipe).key).unlink()
        self.store.manifest_path(spec.stage, spec.recipe).unlink()

    def interrupt(self, spec: JobSpec, number: signal.Signals, seconds: float, after="") -> None:
        """Send a signal to a job after so much processor time from its start, or from a line on.

        The signal ends it, unless it is done before.
        """
        note = self.store.progress_path(spec.stage, spec.recipe)
        note.unlink(missing_ok=True)
        process = self.start(spec)
        since = None if after else 0.0
        while process.poll() is None and (since is None or used(process.pid) < since + seconds):
            with suppress(OSError):
                if since is None and note.read_text().endswith(after):
                    since = used(process.pid)
            time.sleep(0.01)
        process.send_signal(number)
        status = process.wait()
        assert status in (0, -number), (spec.label, status)


def used(process: int) -> float:
    """Processor time of a process of Linux [s]; see proc_pid_stat(5)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def of_children() -> float:
    """Processor time of the children that ended [s]."""
    return sum(os.times()[2:4])


@pytest.fixture(scope="module")
def jobs(tmp_path_factory) -> Jobs:
    return Jobs(tmp_path_factory.mktemp("jobs"))


def test_a_gait_that_was_interrupted_within_ipopt_has_the_same_bytes(jobs):
    """CasADi swallows what a handler of Python raises there, and would try the next guess."""
    gait = jobs.specs["gait"]
    truth = jobs.run(gait)
    jobs.forget(gait)
    for number in SIGNALS:
        jobs.interrupt(gait, number, 0.2, after=BUILT)
    assert jobs.run(gait) == truth


@pytest.mark.faults
@pytest.mark.parametrize("kind", ["gait", "training", "evaluation", "search"])
def test_any_moment_of_any_job(jobs, kind):
    spec = jobs.specs[kind]
    for need in spec.needs:
        jobs.run(need)
    if jobs.is_done(spec):
        jobs.forget(spec)
    before = of_children()
    truth, interrupted = jobs.run(spec), set()
    whole = of_children() - before
    for number, moment in product(SIGNALS, range(MOMENTS)):
        jobs.forget(spec)
        jobs.interrupt(spec, number, whole * (moment + 0.5) / MOMENTS)
        if not jobs.is_done(spec):
            interrupted.add(number)
        assert jobs.run(spec) == truth, (number.name, moment)
    assert interrupted == {*SIGNALS}
