"""Observation layouts, and reflection of every term against a robot that is really mirrored."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from slider.config.env import HeightScan, ObservationConfig
from slider.env.observations import TERMS, Observer
from slider.env.state import View
from slider.robot.names import MOTORS
from tests.env.synthetic import (
    PERMUTATION,
    SIGN,
    config,
    make_physics,
    make_state,
    make_view,
    mirror_pose,
    random_pose,
)

COUNT = 5
NOBODY = torch.zeros(COUNT, dtype=torch.bool)
# Design, section 3: the paper's 235 observations.
PAPER = {
    "base_linear_velocity": 3,
    "target_linear_velocity": 3,
    "base_angular_velocity": 3,
    "target_angular_velocity": 3,
    "projected_gravity": 3,
    "command": 4,
    "joint_positions": 12,
    "joint_velocities": 12,
    "previous_action": 12,
    "height_scan": 180,
}


def observer(*names: str, scale: float = 1.0, clip: float = 1e6) -> Observer:
    return Observer(
        ObservationConfig(dict.fromkeys(names, scale), clip, HeightScan(15, 12, 0.1), 0.3)
    )


def physical_view(mirrored: bool) -> View:
    """A view of robots in random motion, or of the same robots in a mirror.

    Quantities of sensors, which are 0 before the first step, are random, too.
    """
    rng = np.random.default_rng(7)
    pose = random_pose(rng, COUNT)
    command = rng.standard_normal((COUNT, 4))
    actions = rng.standard_normal((2, COUNT, 12))
    filtered, expected = rng.standard_normal((2, COUNT, 2))
    phase = rng.uniform(size=COUNT)
    torques = rng.standard_normal((COUNT, 2, len(MOTORS) // 2))
    positions, velocities = rng.standard_normal((2, COUNT, 2, 3))
    forces, contacts = rng.uniform(10.0, 200.0, (COUNT, 2)), rng.uniform(0.0, 3.0, COUNT)
    if mirrored:
        pose = mirror_pose(*pose)
        command = command * [1.0, -1.0, -1.0, -1.0]
        actions = actions[..., PERMUTATION] * SIGN
        filtered, expected = filtered * [1.0, -1.0], expected * [1.0, -1.0]
        phase = (phase + 0.5) % 1.0
        torques = torques[:, ::-1] * [-1.0, -1.0, 1.0, 1.0, 1.0]  # yaw and roll flip
        positions, velocities = (v[:, ::-1] * [1.0, -1.0, 1.0] for v in (positions, velocities))
        forces = forces[:, ::-1].copy()
    physics = make_physics(COUNT)
    physics.reset(np.arange(COUNT), *pose)
    state = replace(
        physics.read(),
        motor_torques=torques.reshape(COUNT, -1),
        foot_positions=positions,
        foot_velocities=velocities,
        foot_forces=forces,
        body_contacts=contacts,
    )
    return make_view(
        state,
        command=command,
        action=actions[0],
        previous_action=actions[1],
        filtered_velocity=filtered,
        reference_velocity=expected,
        expected_velocity=expected,
        phase=phase,
    )


def test_the_papers_layout():
    layout = Observer(config("experiment=paper").env.observation).layout
    assert layout == PAPER
    assert sum(layout.values()) == 235


@pytest.mark.parametrize("name", TERMS)
def test_a_reflected_term_is_that_of_the_mirrored_robot(name):
    see, view = observer(name), physical_view(False)
    reflected, plain = see(view, ~NOBODY), see(view, NOBODY)
    expected = see(physical_view(True), NOBODY)
    assert reflected.shape == (COUNT, see.layout[name])
    np.testing.assert_allclose(reflected, expected, atol=1e-6)
    turned = (see.permutation != np.arange(see.size)).any() or (see.sign < 0.0).any()
    if turned and name != "height_scan":  # of flat ground
        assert (reflected - plain).abs().max() > 1e-2


def test_only_the_asked_robots_are_reflected():
    see, some = observer(*TERMS), torch.arange(COUNT) % 2 == 0
    mixed, plain, full = (see(physical_view(False), which) for which in (some, NOBODY, ~NOBODY))
    np.testing.assert_array_equal(mixed[some], full[some])
    np.testing.assert_array_equal(mixed[~some], plain[~some])


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
