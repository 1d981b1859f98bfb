"""Controllers of ``conf/control`` are built from their settings and what these need."""

import pytest

from slider.config.control import MpcConfig
from slider.control.model_based import build_controller
from slider.control.whole_body.observer import ObservingController
from slider.core.errors import UserError
from tests.env.synthetic import config, robot_config


def test_one_that_walks_by_gaits_needs_them():
    control, physics = config().control["hzd"], config().env.physics
    with pytest.raises(UserError, match=r"^controller: expected gaits to walk by, found none$"):
        build_controller(robot_config(), control, physics, 1)


@pytest.mark.parametrize("name", ["mpc_wbc_literal", "mpc_wbc_tuned", "mpc_wbc_observer"])
def test_an_observer_stands_before_the_controller_where_there_is_one(name):
    control = config().control[name]
    assert isinstance(control, MpcConfig)
    built = build_controller(robot_config(), control, config().env.physics, 1)
    assert isinstance(built, ObservingController) == (control.observer is not None)
