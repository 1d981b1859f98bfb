"""The robot's parameters are found whatever they are called; changing one leaves the others."""

import pytest

from slider.config.convert import to_dict
from slider.config.parameters import choose, parameters, scaled, tag
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from tests.config.composed import composed


@pytest.fixture(scope="module")
def robot() -> RobotConfig:
    return composed().robot


def numbers(node: object) -> int:
    """Numbers in nested values, counted without regard to names."""
    if isinstance(node, dict):
        return sum(numbers(value) for value in node.values())
    if isinstance(node, (list, tuple)):
        return sum(numbers(value) for value in node)
    return int(isinstance(node, float))


def test_every_number_is_in_one_parameter(robot):
    found = parameters(robot)
    assert len({item.path for item in found}) == len(found)
    directions = 15  # of axes: no sizes
    assert sum(len(item.value) for item in found) == numbers(to_dict(robot)) - directions
    assert not any(item.path.startswith(("provenance", "name")) for item in found)


def test_the_tag_is_that_of_the_longest_path(robot):
    tags = {"links": "assumed", "links.roll": "earlier", "links.roll.com": "assumed"}
    assert tag(tags, "links.base.mass") == "assumed"
    assert tag(tags, "links.roll.mass") == "earlier"
    assert tag(tags, "links.roll.com") == "assumed"
    assert tag(tags, "links.rolled") == "assumed"  # no part of links.roll
    assert tag(tags, "contact.friction") == ""
    assert {item.provenance for item in parameters(robot)} == {"paper", "earlier", "assumed"}


def test_named_paths_are_parameters_or_groups(robot):
    found = parameters(robot)
    assert [p.path for p in choose(found, ["assumed"], ["geometry.toe"])] == ["geometry.toe"]
    base = choose(found, ["assumed"], ["links.base"])
    assert [item.path.rpartition(".")[2] for item in base] == ["mass", "com", "inertia", "products"]
    assert choose(found, ["paper"], ["links.base"]) == []


IMPOSSIBLE = {0.8: set(), 1.2: {"geometry.leg_length"}}  # a leg longer than thigh and shank


@pytest.mark.parametrize("factor", IMPOSSIBLE)
def test_one_parameter_changes_and_nothing_else(robot, factor):
    before = {item.path: item.value for item in parameters(robot)}
    for path in before.keys() - IMPOSSIBLE[factor]:
        changed = scaled(robot, path, factor)
        after = {item.path: item.value for item in parameters(changed)}
        assert after.pop(path) == pytest.approx([factor * v for v in before[path]], rel=1e-9)
        assert after == {name: value for name, value in before.items() if name != path}
        assert changed.provenance == robot.provenance
    for path in IMPOSSIBLE[factor]:
        with pytest.raises(UserError, match="expected thigh \\+ shank longer than the leg"):
            scaled(robot, path, factor)
    digits = scaled(robot, "links.base.inertia", 1.2).links.base.inertia
    assert digits == (0.036, 0.0216, 0.0336)
