"""How long Table 1 took: sums over the jobs that its store notes."""

from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.results.markdown import grid, markdown
from slider.reports.results.origin import ancestry, made
from slider.reports.results.unmade import Unmade
from slider.reports.sections.provenance import STAGES


def times(report: Path, store: Store) -> str:
    """Jobs, wall time and processor time of each stage on the way to Table 1."""
    origin = made(report, store)
    if origin is None:
        raise Unmade(f"{report} is of no job in the store")
    jobs = list(ancestry(origin, store))
    present = dict.fromkeys(job.manifest.stage for job in jobs)
    body = []
    for stage in [*(s for s in STAGES if s in present), *sorted(set(present) - set(STAGES))]:
        facts = [job.facts for job in jobs if job.manifest.stage == stage]
        walls = [fact.get("wall_s", 0.0) for fact in facts]
        cpu = sum(fact.get("cpu_s", 0.0) for fact in facts)
        threads = max(fact.get("threads", 1) for fact in facts)
        minutes = f"{sum(walls) / 60:.1f}"
        row = [STAGES.get(stage, stage), str(len(facts)), str(threads), minutes, f"{cpu / 60:.1f}"]
        body.append(row)
    heads = ["stage", "jobs", "threads of a job", "wall time of all jobs [min]"]
    return markdown(grid([*heads, "processor time [min]"], body))
