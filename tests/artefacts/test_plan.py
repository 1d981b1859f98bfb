"""Plans: which jobs lead to which result."""

from slider.artefacts.plan import JobSpec, build_plan, jobs_towards
from slider.artefacts.recipe import Code

CODE = Code("a:run", "", {})


def job(stage: str, **inputs: JobSpec) -> JobSpec:
    return JobSpec(stage, stage, CODE, {}, {name: [item] for name, item in inputs.items()})


def test_jobs_are_counted_with_what_they_lead_to():
    gait = job("gait")
    library = job("library", gait=gait)
    walking = job("walking", library=library)
    table = job("table", walking=walking)
    checks = job("checks", library=library)
    plan = build_plan({"library": library, "table": table, "checks": checks})
    assert len(plan.jobs) == 5

    def towards(start: JobSpec) -> list[str]:
        return [found.stage for found in jobs_towards(plan, start.recipe).values()]

    assert towards(checks) == ["gait", "library", "checks"]
    for start in (gait, library, walking, table):
        assert towards(start) == ["gait", "library", "walking", "table"]
