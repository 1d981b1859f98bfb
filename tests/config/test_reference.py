"""Bounds, units and meanings are those of the schema's types; every key has them."""

import dataclasses
import json

import pytest
import yaml
from jsonschema import Draft202012Validator

from slider.cli import main
from slider.config.reference import OPTIONAL, Entry, editor_schema, entries, page
from slider.config.schema import Config
from slider.env.terms import parameter_types
from tests.config.composed import CONF, composed

PERIODS = "number | s | (0, 100000], a multiple of env.control_period"


@pytest.fixture(scope="module")
def config() -> Config:
    return composed(*OPTIONAL)


@pytest.fixture(scope="module")
def table(config) -> list[Entry]:
    return entries(config, parameter_types(config))


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("train.walking.ppo.gamma", "number | - | (0, 1]"),
        ("train.walking.reward.terms.heading.params.width", "number | rad² | (0, 10000]"),
        ("train.walking.velocities.yaw_rate.lower", "number | rad/s | [-10000, 10000]"),
        ("finetuning.disturbance.push.interval", PERIODS),
        ("evaluation.speeds", "list of numbers | m/s | [-100, 100], each once"),
        ("gait.nodes", "integer |  | [5, 201], an odd number"),
        ("robot.links.base.inertia", "3 numbers | kg m² | (0, 10000]"),
        ("gauge.scales.friction", "list of one or more numbers | - | (0, 1000], falling values"),
        ("control.hzd.whole_body.regularisation", "2 numbers | 1/(rad/s²)², 1/N² | (0, 1e+09]"),
        ("control.hzd.family", "one of hzd |  | "),
    ],
)
def test_type_unit_and_bound(path, text, table):
    (entry,) = (entry for entry in table if entry.key == path)
    assert " | ".join(entry[1:4]) == text


@pytest.mark.parametrize(
    ("group", "folder"),
    [
        *(("", "experiment"), ("gait", "gait"), ("gait.grid", "gait/grid"), ("robot", "robot")),
        *(("control.mine", "control"), ("env", "env"), ("train.walking", "train/walking")),
        *(("evaluation", "evaluation"), ("gauge", "gauge"), ("study.mine", "study")),
    ],
)
def test_editors_accept_the_files_of_conf_and_no_other_key(group, folder):
    validator = Draft202012Validator(editor_schema(group))
    for path in (CONF / folder).glob("*.yaml"):
        values = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
        assert [error.message for error in validator.iter_errors(values)] == [], path
    assert validator.is_valid({})
    assert not any(map(validator.is_valid, [{"nonsense": 1}, {"defaults": 1}]))


def test_the_command_prints_a_schema(capsys, refused):
    assert main(["config", "--schema", "gait.solver"]) == 0
    solver = json.loads(capsys.readouterr().out)["anyOf"][0]["properties"]
    tolerance = solver["tolerance"]["anyOf"][0]
    assert (tolerance["maximum"], tolerance["exclusiveMinimum"]) == (1, 0)
    assert not Draft202012Validator(solver["tolerance"]).is_valid(2.0)
    assert "expected a key with values below it" in refused("config", "--schema", "gait.nodes")


def test_every_value_has_an_entry_with_a_meaning_a_bound_and_a_unit(table):
    paths = {entry.key for entry in table}
    assert {"robot.joints.slide.upper", "protocols.heldout.profile.rows"} <= paths
    assert "train.walking.reward.terms.effort.weight" in paths
    assert len(paths) == len(table) > 500
    assert [entry.key for entry in table if not entry.meaning or entry.default == "{}"] == []
    numbers = [entry for entry in table if "number" in entry.type]
    assert len(numbers) > 300
    assert [entry.key for entry in numbers if not entry.unit] == []
    numbers += [entry for entry in table if "integer" in entry.type]
    assert [entry.key for entry in numbers if not entry.bound.startswith(("[", "("))] == []


def test_is_a_page_with_a_table_per_group(config):
    text = page(config, parameter_types(config))
    header = "| key | type | unit | bound | default | meaning |"
    assert text.count(header) == len(dataclasses.fields(Config))
    assert "| `finetuning.selection.duration` | number | s | (0, 100000] | `10.0` |" in text


@pytest.mark.parametrize("keys", ["train.walking.ppo", "train.walking.ppo.gamma", "*.ppo.gamma"])
def test_the_command_prints_keys_with_their_bounds(keys, refused, capsys):
    command = ["config", "train.walking.ppo.gamma=0.9", "--conf", str(CONF)]
    assert main([*command, "--keys", keys]) == 0
    header, *rows = capsys.readouterr().out.splitlines()
    assert header.split() == ["key", "type", "unit", "bound", "default", "meaning"]
    (gamma,) = (row.split() for row in rows if row.startswith("train.walking.ppo.gamma "))
    assert " ".join(gamma[1:]) == "number - (0, 1] 0.9 discount per control step"
    assert "expected a key" in refused(*command, "--keys", "train.walking.pp")
