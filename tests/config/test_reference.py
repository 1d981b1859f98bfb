"""Bounds, units and meanings are those of the schema's types; every key has them."""

import dataclasses
from pathlib import Path

import pytest

from slider.cli import main
from slider.config.compose import compose
from slider.config.gait import GaitConfig
from slider.config.reference import OPTIONAL, Entry, entries, kind_at, matching, meaning, page
from slider.config.schema import Config
from slider.config.verification import VerificationConfig
from slider.core.errors import UserError
from slider.env.terms import kinds

CONF = Path(__file__).parents[2] / "conf"


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("train.walking.ppo.gamma", "a number in (0, 1]"),
        ("train.walking.ppo.actor_ema", "a number in [0, 1)"),
        ("train.walking.ppo.schedule", "one of adaptive, fixed"),
        ("train.walking.reward.terms.heading.params.width", "a number"),
        ("train.walking.velocities.vx.lower", "a number in [-100, 100] m/s"),
        ("train.walking.velocities.yaw_rate.lower", "a number in [-10000, 10000] rad/s"),
        ("evaluation.disturbance.friction", "values of lower, upper, or null"),
        ("evaluation.disturbance.friction.lower", "a number in (0, 1000]"),
        ("evaluation.disturbance.delay.lower", "a number in [0, 100000] s"),
        ("gait.nodes", "an integer in [5, 201], an odd number"),
        ("gait.grid.extra", "a list of values of vx, vy, yaw_rate"),
        ("gait.grid.vx.step", "a number in (0, 100] m/s"),
        (
            "robot.links.base.inertia",
            "3 numbers in (0, 10000] kg m², none above the sum of the others",
        ),
        ("robot.joints", "values by name"),
        ("library.allow_holes", "true or false"),
        ("tracking.experiment", "text"),
        ("nonsense", "value"),
    ],
)
def test_what_a_value_may_be(path, text):
    assert str(kind_at(Config, path.split("."))) == text


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("robot.geometry.toe", "m"),
        ("robot.links.base.inertia", "kg m²"),
        ("robot.joints.ankle.lower", "rad"),
        ("robot.joints.slide.upper", "m"),
        ("robot.joints.slide.damping", "N s/m"),
        ("robot.joints.ankle.armature", "kg m²"),
        ("robot.gains.ankle.kp", "N m/rad"),
        ("robot.drives.capstan.stall_ratio", "-"),
        ("env.action.scale.slide", "m"),
        ("control.mpc_wbc_tuned.whole_body.regularisation", "1/(rad/s²)², 1/N²"),
        ("train.walking.robots", ""),
    ],
)
def test_units(path, unit):
    assert kind_at(Config, path.split(".")).unit == unit


def test_items_of_a_list_and_of_a_vector():
    speed = kind_at(Config, ("evaluation", "speeds", 3))
    assert str(speed) == "a number in [-100, 100] m/s"
    assert kind_at(Config, ("gait", "grid", "vx", 0)).unit == "m/s"
    assert kind_at(Config, ("robot", "links", "base", "com", 2)).unit == "m"


def test_the_text_under_a_field_is_its_meaning_also_where_it_is_inherited():
    assert meaning(GaitConfig, "nodes") == "collocation nodes per step"
    assert meaning(VerificationConfig, "points").startswith("per step")
    assert meaning(GaitConfig, "grid") == ""


@pytest.fixture(scope="module")
def config() -> Config:
    return compose(OPTIONAL, CONF)


@pytest.fixture(scope="module")
def found(config) -> list[Entry]:
    return entries(config, kinds(config))


def test_every_value_has_an_entry_and_a_meaning(found):
    paths = {entry.path for entry in found}
    assert {"gait.nodes", "train.walking.ppo.schedule", "report.video.quality"} <= paths
    assert {"robot.joints.slide.upper", "protocols.heldout.profile.rows"} <= paths
    assert len(paths) == len(found) > 500
    assert [entry.path for entry in found if not entry.meaning] == []
    assert {entry.path for entry in found if entry.kind.name == "value"} == set()


def test_every_number_has_a_bound_and_every_real_one_a_unit(found):
    numbers = [entry for entry in found if "number" in entry.kind.name]
    assert len(numbers) > 300
    assert [entry.path for entry in numbers if not entry.kind.interval] == []
    assert [entry.path for entry in numbers if not entry.kind.unit] == []
    integers = [entry for entry in found if "integer" in entry.kind.name]
    assert [entry.path for entry in integers if not entry.kind.interval] == []


def test_keys_are_chosen_by_their_group_or_by_a_pattern(found):
    gains = {entry.path for entry in matching(found, "robot.gains")}
    assert len(gains) == 8
    assert {entry.path for entry in matching(found, "*.gains.*")} == gains
    assert [entry.path for entry in matching(found, "gait.nodes")] == ["gait.nodes"]
    assert matching(found, "") == found
    with pytest.raises(UserError, match=r"expected a key, or a pattern .*, found gait\.nod$"):
        matching(found, "gait.nod")


def test_is_a_page_with_a_table_per_group(config):
    text = page(config, kinds(config))
    header = "| key | type | unit | bound | default | meaning |"
    assert text.count(header) == len(dataclasses.fields(Config))
    row = "| `gait.nodes` | integer |  | [5, 201], an odd number | `21` | collocation nodes per st"
    assert row in text
    assert "| `env.termination.terms.tilt` | number | rad | (0, 3.14" in text
    assert "| `train.walking.reward.terms.heading.params.width` | number | rad² | (0, 1" in text
    assert "| `finetuning.disturbance.push.interval` | number | s | (0, 100000] | `2.0` |" in text


def test_the_command_prints_keys_with_their_bounds(capsys):
    command = ["config", "train.walking.ppo.gamma=0.9", "--conf", str(CONF)]
    assert main([*command, "--keys", "train.walking.ppo"]) == 0
    header, *rows = capsys.readouterr().out.splitlines()
    assert header.split() == ["key", "type", "unit", "bound", "default", "meaning"]
    (gamma,) = (row for row in rows if row.startswith("train.walking.ppo.gamma "))
    assert gamma.split(maxsplit=6)[1:] == [
        "number",
        "-",
        "(0,",
        "1]",
        "0.9",
        "discount per control step",
    ]
    assert main([*command, "--keys", "nothing"]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_term_without_parameters_has_no_key_for_them(found):
    assert [entry.path for entry in found if entry.default == "{}"] == []
    paths = {entry.path for entry in found}
    assert "train.walking.reward.terms.effort.weight" in paths
    assert "train.walking.reward.terms.heading.params.width" in paths
