"""Recipes and versions."""

from importlib import metadata

import pytest

from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import ABSENT, Code, distribution, versions
from slider.core.errors import UserError
from slider.core.files import digest_value

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
    ],
)
def test_recipe_depends_on_everything_that_may_change_a_result(changed):
    assert changed != BASE


def test_order_of_a_term_table_counts():
    assert digest_value({"a": 1, "b": 2}) != digest_value({"b": 2, "a": 1})


def test_not_a_number_is_refused():
    with pytest.raises(ValueError, match="Out of range"):
        digest_value({"a": float("nan")})


def test_version_by_package_name_even_where_the_distribution_is_called_otherwise():
    found = versions(("casadi", "rsl_rl", "yaml"))
    assert found["casadi"] == metadata.version("casadi")
    assert found["rsl_rl"] == metadata.version("rsl-rl-lib")
    assert found["yaml"] == metadata.version("PyYAML")


def test_optional_package_that_is_not_installed():
    assert versions(("no_such_package",))["no_such_package"] == ABSENT


def test_package_without_distribution_is_refused(tmp_path, monkeypatch):
    (tmp_path / "orphan.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    message = "^expected an installed distribution with package orphan, found none$"
    with pytest.raises(UserError, match=message):
        versions(("orphan",))


def test_a_package_below_a_prefix_belongs_to_its_distribution():
    found = distribution("pinocchio")
    assert found is not None
    assert found.name == "pin"
    assert versions(("pinocchio",))["pinocchio"] == metadata.version("pin")
