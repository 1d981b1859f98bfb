"""Observation layouts, and reflection of every term against a robot that is really mirrored."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from slider.config.env import HeightScan, ObservationConfig
from slider.env.observations import TERMS, Observer
from tests.env.synthetic import GEOMETRY, config, make_state, make_view, random_view

COUNT = 5
NOBODY = torch.zeros(COUNT, dtype=torch.bool)


def observer(*names: str, scale: float = 1.0, clip: float = 1e6) -> Observer:
    return Observer(
        ObservationConfig(dict.fromkeys(names, scale), clip, HeightScan(15, 12, 0.1), 0.3), GEOMETRY
    )


def test_the_paper_has_235_observations():
    assert Observer(config("experiment=paper").env.observation, GEOMETRY).size == 235


@pytest.mark.parametrize("name", TERMS)
def test_a_reflected_term_is_that_of_the_mirrored_robot(name):
    see, view = observer(name), random_view(COUNT)
    reflected, plain = see(view, ~NOBODY), see(view, NOBODY)
    expected = see(random_view(COUNT, mirrored=True), NOBODY)
    assert reflected.shape == (COUNT, see.layout[name])
    np.testing.assert_allclose(reflected, expected, atol=1e-6)
    turned = (see.permutation != np.arange(see.size)).any() or (see.sign < 0.0).any()
    if turned and name != "height_scan":  # of flat ground
        assert (reflected - plain).abs().max() > 1e-2


def test_values_by_hand():
    state = make_state(1, joint_positions=np.arange(12) / 10, base_position=[[1.0, 2.0, 0.7]])
    view = make_view(
        state,
        command=[[0.5, -0.1, 0.2, 0.3]],
        action=np.full((1, 12), 2.0),
        reference_velocity=[[0.3, -0.2]],
        expected_velocity=[[0.4, -0.1]],
        phase=[0.25],
    )
    view = replace(view, nominal=torch.full((12,), 0.1, dtype=torch.float64))
    expected = {
        "target_linear_velocity": [0.5, -0.1, 0.0],
        "target_angular_velocity": [0.0, 0.0, 0.2],
        "reference_velocity": [0.3, -0.2],
        "command": [0.5, -0.1, 0.2, 0.3],
        "joint_positions": np.arange(12) / 10 - 0.1,
        "previous_action": [2.0] * 12,
        "base_height": [0.7 - 0.685],
        "height_scan": [0.7] * 180,
        "phase": [1.0, 0.0],
        "velocity_error": np.tanh([-2.0, 0.5]),  # at rest
        "projected_gravity": [0.0, 0.0, -1.0],
    }
    for name, values in expected.items():
        np.testing.assert_allclose(
            observer(name)(view, NOBODY[:1])[0], values, atol=1e-7, err_msg=name
        )
    halted = replace(view, halted=torch.ones(1, dtype=torch.bool))
    np.testing.assert_array_equal(observer("phase")(halted, NOBODY[:1]), [[0.0, 0.0]])


def test_scale_then_clip():
    view = make_view(make_state(1, joint_velocities=np.linspace(-30, 30, 12)))
    see = observer("joint_velocities", scale=0.5, clip=10.0)
    expected = np.clip(0.5 * np.linspace(-30, 30, 12), -10, 10)
    np.testing.assert_allclose(see(view, NOBODY[:1])[0], expected, rtol=1e-6)
