"""What is played follows from the arguments and from the policy's own file."""

import argparse
import re
from dataclasses import replace

import numpy as np
import pytest

from slider.commands.play import add_arguments, choose
from slider.config.env import TerminationConfig
from slider.core.errors import UserError
from slider.play import scenes
from tests.control.policies import write_policy
from tests.env.synthetic import CONF


def scene(*arguments: str):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return choose(parser.parse_args([*arguments, "--conf", str(CONF)]))


@pytest.mark.parametrize("override", ["env=paper", "robot.gains.capstan.kp=2.8"])
def test_a_policy_walks_where_it_was_trained(tmp_path, override):
    policy = write_policy(tmp_path / "policy.pt", override)
    played = scene("--policy", str(tmp_path / "policy.pt"), "--set", "evaluation=robust")
    assert played.robot == policy.robot
    frame = played.motion.start(np.zeros(3))
    assert not frame.failed


def test_overrides_of_the_environment_are_obeyed(tmp_path):
    write_policy(tmp_path / "policy.pt")
    with pytest.raises(UserError, match=r"^policy: expected env\.\w.*, as in its training, found "):
        scene("--policy", str(tmp_path / "policy.pt"), "--set", "env=paper")


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            "env.reference.acceleration=9",
            "env.reference.acceleration=2.5, as in its training, found 9.0",
        ),
        ("env.phase.mirror=false", "env.phase.mirror=True, as in its training, found False"),
        ("env.observation.velocity_filter=0", "env.observation.velocity_filter=0.3"),
        ("env.action.scale.slide=0.5", "env.action.scale.slide=0.06"),
    ],
)
def test_a_policy_keeps_what_it_sees_and_does(tmp_path, override, message):
    write_policy(tmp_path / "policy.pt")
    with pytest.raises(UserError, match=re.escape(message)):
        scene("--policy", str(tmp_path / "policy.pt"), "--set", override)


def test_an_override_of_the_plant_leaves_the_policys_interface(tmp_path, monkeypatch):
    policy = write_policy(tmp_path / "policy.pt", "env.reference.acceleration=1.0")
    environments = []
    monkeypatch.setattr(scenes, "simulate_policy", lambda *given: environments.append(given[2]))
    override = "env.termination.terms.base_height=0.3"
    scene("--policy", str(tmp_path / "policy.pt"), "--set", override)
    terms = {**policy.env.termination.terms, "base_height": 0.3}
    assert environments == [replace(policy.env, termination=TerminationConfig(terms))]
