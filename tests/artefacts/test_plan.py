"""Plans: recipes of their jobs, and what is read back."""

import pytest

from slider.artefacts.plan import JobSpec, read_plan, write_plan
from slider.artefacts.recipe import Code
from slider.core.errors import UserError
from tests.artefacts.samples import PLAN

CODE = Code("slider.gait.stage:run", "abc", {"python": "3.11", "casadi": "3.8.2"})
SECTION = {"gait": {"nodes": 21}, "velocity": [0.2, 0.0]}


def key(stage, section, code, inputs):
    return JobSpec(stage, "a job", code, section).key(inputs)


BASE = key("gait", SECTION, CODE, {"x": ["1", "2"]})


@pytest.mark.parametrize(
    "changed",
    [
        key("gaits", SECTION, CODE, {"x": ["1", "2"]}),
        key("gait", SECTION | {"velocity": [0.2, 0.1]}, CODE, {"x": ["1", "2"]}),
        key("gait", SECTION, Code(CODE.entry, "abd", CODE.versions), {"x": ["1", "2"]}),
        key("gait", SECTION, Code(CODE.entry, "abc", {}), {"x": ["1", "2"]}),
        key("gait", SECTION, CODE, {"x": ["2", "1"]}),
        key("gait", SECTION, CODE, {"y": ["1", "2"]}),
        key("gait", dict(reversed(SECTION.items())), CODE, {"x": ["1", "2"]}),
    ],
)
def test_recipe_depends_on_everything_that_may_change_a_result(changed):
    assert changed != BASE


def test_not_a_number_is_refused():
    with pytest.raises(ValueError, match="Out of range"):
        key("gait", {"a": float("nan")}, CODE, {})


def test_plan_round_trip(tmp_path):
    path = write_plan(PLAN, tmp_path)
    assert read_plan(path) == PLAN
    assert [job.label for job in read_plan(path).jobs.values()][-2:] == ["library", "table"]
    path.write_text(path.read_text().replace('"number"', '"numbers"'))
    with pytest.raises(UserError, match=f"^expected a plan, found none at {path}$"):
        read_plan(path)


def test_plan_digests_are_those_of_all_jobs_before_without_the_machine():
    def digests(section: dict, code: Code) -> dict[str, str]:
        training = JobSpec("walking", "walking", code, section)
        return JobSpec("table1", "table", CODE, {}, {"walking": [training]}).plan_digests

    base = digests({"train": {"weight": 1.0, "device": "cpu"}, "folder": "a"}, CODE)
    assert digests({"train": {"weight": 1.0, "device": "cuda"}, "numerics": "sse"}, CODE) == base
    changed = digests({"train": {"weight": 2.0, "device": "cpu"}, "numerics": "avx2"}, CODE)
    assert changed["settings"] != base["settings"]
    assert changed["source"] == base["source"]
    others = digests({"train": {"weight": 1.0, "device": "cpu"}}, Code("e:f", "other", {}))
    assert others["settings"] == base["settings"]
    assert others["source"] != base["source"]
