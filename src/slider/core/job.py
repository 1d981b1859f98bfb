"""Interface of a stage: its arguments and its return value.

Every stage is one function ``run(section, inputs, out, job) -> summary``:

* ``section``: the stage's own part of the resolved configuration, plain nested dictionaries;
* ``inputs``: name → object folders of the stages it depends on, in a fixed order;
* ``out``: empty folder for the result's files, which must be the same bytes for the same input;
* ``job``: work folder, threads, metrics and progress; must not affect the result;
* ``summary``: small, deterministic values for the manifest (JSON).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Section = dict[str, Any]
Inputs = Mapping[str, Sequence[Path]]
Summary = dict[str, Any]
LogMetrics = Callable[[Mapping[str, float], int], None]


@dataclass(frozen=True)
class Job:
    """Runtime context of a stage.

    Attributes:
        work: folder that survives a killed job, for checkpoints.
        threads: number of threads that the job may use.
        log_metrics: records metrics by name at a step. Never raises.
        progress: shows one line to the user.
        metadata: values that differ between runs, such as times; stored as run metadata.
        cache: folder shared by jobs of the same source; may be deleted at any time.
        waiting: number of jobs of the stage without a result in the plan, including this one.
        input_metadata: for each name in ``inputs``, the run metadata of those stages in the same
            order, with ``wall_s`` and ``cpu_s`` (an empty dictionary where none are known). For
            display and tracking only.
    """

    work: Path
    threads: int = 1
    log_metrics: LogMetrics = lambda *_: None
    progress: Callable[[str], None] = lambda _: None
    metadata: dict[str, Any] = field(default_factory=dict)
    cache: Path | None = None
    waiting: int = 1
    input_metadata: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)


StageFunction = Callable[[Section, Inputs, Path, Job], Summary]
