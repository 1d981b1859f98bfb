"""``python -m tests.faults.signals``: interrupt real jobs at many moments, and compare the bytes.

A gait, a training, an evaluation and a search for settings run as the Snakefile runs them. Each
trial sends a signal to the job, runs it again to its end, and expects the object of the undisturbed
job.
"""

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path

from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import baseline_tuning
from slider.artefacts.plan import JobSpec, build_plan, write_plan
from slider.artefacts.store import Store
from slider.core import environment
from tests.config.composed import composed

SIGNALS = (signal.SIGINT, signal.SIGTERM)
OTHER = "OTHER"
BUILT = "built"  # the progress of a gait whose solver begins
OVERRIDES = (
    *("experiment=test", "gait.grid.vx=[0.4]", "gait.grid.vy=[0.0,0.1]"),
    *("train.walking.iterations=12", "train.walking.selection.interval=3"),
    *("evaluation.duration=3", "evaluation.robots=20"),
    *("tuning.trials=4", "tuning.finalists=2", "tuning.finalist_robots=4"),
)


@dataclass(frozen=True)
class Jobs:
    """Jobs below a folder; ``specs`` are those to be interrupted."""

    folder: Path
    specs: Mapping[str, JobSpec]

    @classmethod
    def laid_out(cls, folder: Path) -> "Jobs":
        config = composed(*OVERRIDES)
        targets = table1_jobs(config)
        specs = {
            "gait": targets["library"].inputs["gaits"][1],  # which has an anchor
            "training": targets["walking"],
            "evaluation": targets["table1"].inputs["evaluations"][0],
            "search": baseline_tuning(config, targets).inputs["searches"][0],
        }
        return cls(folder, specs)

    @property
    def store(self) -> Store:
        return Store(self.folder / "artefacts")

    @cached_property
    def plan(self) -> Path:
        return write_plan(build_plan(self.specs), self.store.root / "plans")

    def start(self, spec: JobSpec) -> "subprocess.Popen[bytes]":
        python = [sys.executable, "-I", "-X", "utf8", environment.__file__]
        place = ["--plan", str(self.plan), "--artefacts", str(self.store.root)]
        return subprocess.Popen([*python, "run", spec.recipe, *place], cwd=self.folder)

    def run(self, spec: JobSpec) -> str:
        """Run a job, and those that it needs, to the end; its object."""
        path = self.store.manifest_path(spec.stage, spec.recipe)
        if not path.is_file():
            for need in spec.needs:
                self.run(need)
            assert self.start(spec).wait() == 0, spec.label
        return self.store.read_manifest(spec.stage, spec.recipe).result.object

    def forget(self, spec: JobSpec) -> None:
        """Let the next job compute the result anew."""
        path = self.store.manifest_path(spec.stage, spec.recipe)
        manifest = self.store.read_manifest(spec.stage, spec.recipe)
        for known in (path, self.store.index_path(manifest.key)):
            known.unlink()

    def interrupt(self, spec: JobSpec, number: signal.Signals, seconds: float, after="") -> None:
        """Send a signal to a job after so much processor time from its start, or from a line on.

        The signal ends it, unless it is done before.
        """
        process = self.start(spec)
        note = self.store.progress_path(spec.stage, spec.recipe)
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
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def outcome(jobs: Jobs, spec: JobSpec, truth: str, number: signal.Signals, seconds: float) -> str:
    """What became of a job that a signal interrupts, and of the one that goes on."""
    jobs.forget(spec)
    jobs.interrupt(spec, number, seconds)
    done = jobs.store.manifest_path(spec.stage, spec.recipe).is_file()
    same = jobs.run(spec) == truth
    return f"{'done before' if done else 'interrupted'}, {'the same' if same else OTHER} bytes"


def main() -> int:
    """Print the counts of each kind and outcome.

    Status 1 if a result is another one, or a signal interrupted no job of a kind.
    """
    parser = argparse.ArgumentParser("signals", description=__doc__)
    parser.add_argument("--moments", type=int, default=10, metavar="N", help="of each job")
    moments = parser.parse_args().moments
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the background of a shell ignores it
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        jobs = Jobs.laid_out(Path(folder))
        for kind, spec in jobs.specs.items():
            for need in spec.needs:
                jobs.run(need)
            before = of_children()
            truth = jobs.run(spec)
            whole = of_children() - before
            for number, moment in product(SIGNALS, range(moments)):
                seconds = whole * (moment + 0.5) / moments
                counts[
                    f"{kind:<12}{number.name:<10}{outcome(jobs, spec, truth, number, seconds)}"
                ] += 1
    for kind, count in sorted(counts.items()):
        print(f"{kind:<56}{count:>5}")
    interrupted = sum("interrupted" in kind for kind in counts)
    missed = interrupted < len(jobs.specs) * len(SIGNALS)
    return int(missed or any(OTHER in kind for kind in counts))


if __name__ == "__main__":
    sys.exit(main())
