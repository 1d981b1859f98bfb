"""What a stage is given besides its configuration and inputs, and what it returns.

Every stage is one function ``run(section, inputs, out, job) -> summary``:

* ``section``: the stage's own part of the resolved configuration, plain nested dictionaries;
* ``inputs``: name → object folders of the stages it depends on, in a fixed order;
* ``out``: empty folder for the result's files (same input, same bytes);
* ``job``: work folder, threads, metrics and progress: nothing that may change the result;
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
    """Surroundings of one stage.

    Attributes:
        work: folder that survives a killed job; checkpoints go here.
        threads: processor threads the job may use.
        log_metrics: records numbers by name at a step. Never raises.
        progress: shows one line to the person who waits.
        metadata: what differs between runs, such as times; run metadata beside the manifest.
        cache: folder that jobs of the same source share, of what may be deleted at any time.
        waiting: jobs of the stage whose results the plan still lacks, this one among them.
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
