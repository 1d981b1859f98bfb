"""Bounds, units and meanings are read from the types of the schema."""

import pytest

from slider.config.gait import GaitConfig
from slider.config.reference import kind_at, meaning
from slider.config.schema import Config
from slider.config.verification import VerificationConfig


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
