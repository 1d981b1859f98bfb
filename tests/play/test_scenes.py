"""What is played follows from the arguments and from the policy's own file."""

import argparse

import numpy as np
import pytest

from slider.core.errors import UserError
from slider.play.command import add_arguments
from slider.play.scenes import build
from tests.control.export.policies import write_policy
from tests.env.synthetic import CONF


def scene(*arguments: str):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return build(parser.parse_args([*arguments, "--conf", str(CONF)]))


@pytest.mark.parametrize("override", ["env=paper", "robot.gains.slide.kp=9000"])
def test_a_policy_walks_where_it_was_trained(tmp_path, override):
    policy = write_policy(tmp_path / "policy.pt", override)
    played = scene("--policy", str(tmp_path / "policy.pt"), "--set", "evaluation=robust")
    assert played.robot == policy.robot
    frame = played.motion.start(np.zeros(3))
    assert not frame.failed


def test_overrides_of_the_environment_are_obeyed(tmp_path):
    write_policy(tmp_path / "policy.pt")
    with pytest.raises(UserError, match="policy: expected"):
        scene("--policy", str(tmp_path / "policy.pt"), "--set", "env=paper")
