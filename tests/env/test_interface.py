"""Actions to targets and back in the mirror; clock, heading target and velocity filter."""

import numpy as np
import pytest
import torch

from slider.core.errors import UserError
from slider.env.interface import FLOAT64, AgentInterface
from slider.robot.names import GAIT_JOINTS, NUM_JOINTS
from tests.env.synthetic import (
    JOINTS,
    PERMUTATION,
    SIGN,
    config,
    gait_table,
    make_agent,
    make_physics,
    make_state,
    mirror_pose,
    robot_config,
)

ALL, tensor = slice(None), FLOAT64.new_tensor
UPPER_FEET = [i for i, name in enumerate(JOINTS) if name.endswith("upper_foot")]
CLIP = config("experiment=test").env.action.clip


def test_a_mirrored_robot_is_driven_to_a_mirrored_place():
    """A policy that sees a mirrored robot half a walk later does the mirrored thing."""
    rng = np.random.default_rng(2)
    physics = make_physics(2)
    qpos, qvel = physics.nominal[None].copy(), 0.2 * rng.standard_normal((1, 18))
    qpos[:, 7:] += 0.05 * rng.standard_normal((1, NUM_JOINTS))
    qpos[:, 2] += 0.02
    other = mirror_pose(qpos, qvel)
    physics.reset(np.arange(2), np.concatenate([qpos, other[0]]), np.concatenate([qvel, other[1]]))
    agent = make_agent(2)
    agent.set_velocity_command(ALL, tensor([[0.3, 0.05, 0.1], [0.3, -0.05, -0.1]]))
    state = physics.read().tensors(FLOAT64)
    agent.reset(ALL, state, phase=tensor([0.2, 0.7]))
    agent.refresh_heading(state)
    matrix = 0.3 * rng.standard_normal((agent.observer.size, NUM_JOINTS)) / 5
    for _ in range(10):
        seen = agent.observe(state)
        np.testing.assert_allclose(seen[0], seen[1], atol=1e-4)
        physics.step(agent.act(tensor(seen[:1].numpy().repeat(2, axis=0) @ matrix)))
        state = physics.read().tensors(FLOAT64)
        agent.advance(state)
    assert agent.action.abs().max() > 0.05
    mirrored = mirror_pose(physics.qpos[1:], physics.qvel[1:])
    np.testing.assert_allclose(physics.qpos[:1], mirrored[0], atol=1e-6)


def test_actions_and_targets_are_clipped():
    agent, action = make_agent(3, "env.action.offset=nominal"), torch.full((3, NUM_JOINTS), 1e6)
    agent.reset(ALL, make_state(3), phase=0.1)
    targets = agent.act(action).numpy()
    np.testing.assert_array_equal(agent.action[:, GAIT_JOINTS], CLIP)
    np.testing.assert_array_equal(agent.action[:, UPPER_FEET], 0.0)
    np.testing.assert_array_equal(
        targets[:, UPPER_FEET], np.tile(agent.nominal[UPPER_FEET], (3, 1))
    )
    lower, upper = robot_config().joint_ranges
    assert ((targets >= lower) & (targets <= upper)).all()
    assert (action == 1e6).all(), "the caller's action was changed"


def test_the_heading_error_integrates_the_yaw_rate_and_wraps():
    agent = make_agent(2)
    still = make_state(2, yaw=[3.0, -3.0])
    agent.set_velocity_command(ALL, tensor([[0, 0, 0.5], [0, 0, -0.5]]))
    agent.reset(ALL, still)
    agent.refresh_heading(still)
    np.testing.assert_allclose(agent.command[:, 3], 0.0, atol=1e-12)
    for _ in range(50):
        agent.advance(still)
    np.testing.assert_allclose(agent.command[:, 3], [0.5, -0.5], atol=1e-9)
    beyond = make_state(2, yaw=[-3.0, 3.0])  # the same way round, across ±π
    agent.refresh_heading(beyond)
    turned = 2 * np.pi - 6.0
    np.testing.assert_allclose(agent.command[:, 3], [0.5 - turned, turned - 0.5], atol=1e-9)
    for _ in range(700):
        agent.advance(still)
        assert np.abs(agent.command[:, 3]).max() <= np.pi + 1e-12


def test_the_reference_has_a_constant_acceleration_and_filters_their_step_response():
    agent = make_agent(2, "env.reference.acceleration=2.0", "env.observation.velocity_filter=0.5")
    agent.reset(ALL, make_state(2), velocity=tensor([[0.0, 0.0], [1.0, 0.1]]))
    agent.set_velocity_command(ALL, tensor([[1.0, 0.1, 0.0], [0.0, 0.1, 0.0]]))
    expected, moving = np.array([0.0, 0.0]), make_state(2, heading_velocity=[[1.0, -0.5]])
    for k in range(1, 41):
        agent.advance(moving)
        share = 1 - (1 - 0.02 / 0.5) ** k
        np.testing.assert_allclose(agent.filtered_velocity[0], [share, -0.5 * share], atol=1e-12)
        risen = min(1.0, 2.0 * 0.02 * k)
        np.testing.assert_allclose(agent.reference_velocity[0], [risen, min(0.1, 0.04 * k)])
        np.testing.assert_allclose(agent.reference_velocity[1], [1.0 - risen, 0.1], atol=1e-12)
        expected = expected + 0.02 / 0.5 * (agent.reference_velocity[0].numpy() - expected)
        np.testing.assert_allclose(agent.expected_velocity[0], expected, atol=1e-12)


def test_resetting_one_robot_leaves_the_others():
    agent, one = make_agent(2), torch.tensor([1])
    moving = make_state(2, heading_velocity=[1.0, 0.0], yaw=0.7)
    agent.reset(ALL, moving, phase=0.1)
    agent.act(torch.ones(2, NUM_JOINTS))
    agent.advance(moving)
    kept = [agent.action, agent.filtered_velocity, agent.clock.phase]
    before = [values[0].clone() for values in kept]
    agent.reset(one, moving, phase=0.4, velocity=tensor([[0.3, 0.1]]))
    for values, value in zip(kept, before, strict=True):
        np.testing.assert_array_equal(values[0], value)
    assert agent.clock.phase[1] == 0.4
    assert not agent.action[1].any()
    for values in (agent.filtered_velocity, agent.expected_velocity):
        np.testing.assert_array_equal(values[1], [0.3, 0.1])
    assert agent.heading_target[1] == pytest.approx(0.7)
    agent.reset(one, moving, heading=tensor([0.1]))
    np.testing.assert_allclose(agent.heading_target, [0.7, 0.1])


def test_clock_and_gaits_are_demanded():
    settings = config("experiment=test")
    for times, message in (
        (None, r"^env\.phase\.enabled: expected the step times of a gait library$"),
        (gait_table().times, r"^env\.action\.offset=gait: expected the gaits of a library, found"),
    ):
        with pytest.raises(UserError, match=message):
            AgentInterface(settings.robot, settings.env, 2, times)


@pytest.mark.parametrize("phase", [0.1, 0.6])
def test_a_residual_action_is_about_the_gait(phase):
    """No action is the gait at command and phase; any other moves it as it moves the nominal."""
    agents = [make_agent(3, f"env.action.offset={origin}") for origin in ("gait", "nominal")]
    command = np.array([[0.2, 0.0, 0.0], [0.5, 0.05, 0.0], [1.7, 0.0, 0.0]])
    for agent in agents:
        agent.set_velocity_command(ALL, tensor(command))
        agent.reset(ALL, make_state(3), phase=phase, velocity=tensor(command[:, :2]))
    residual, nominal = agents
    expected = gait_table().at(command, np.full(3, phase))[:, :NUM_JOINTS]
    assert np.abs(expected - nominal.nominal.numpy()).max() > 0.05
    np.testing.assert_allclose(residual.act(torch.zeros(3, NUM_JOINTS)), expected, atol=1e-12)
    action = np.random.default_rng(0).uniform(-0.2, 0.2, (3, NUM_JOINTS))
    moved = residual.act(tensor(action)).numpy() - expected
    np.testing.assert_allclose(moved, nominal.act(tensor(action)) - nominal.nominal, atol=1e-12)


def test_a_halted_robot_acts_about_standing_on_both_feet():
    """Between the two changes of feet: its own mirror image, wherever the clock has halted."""
    agent = make_agent(3, "env.phase.halt={below: 0.2, above: 0.4}", "env.action.offset=gait")
    agent.reset(ALL, make_state(3), phase=tensor([0.0, 0.5, 0.3]))
    targets = agent.act(torch.zeros(3, NUM_JOINTS))
    np.testing.assert_array_equal(agent.view(make_state(3)).halted, [True, True, False])
    np.testing.assert_array_equal(targets[0], targets[1])
    np.testing.assert_allclose(targets[0], targets[0].numpy()[PERMUTATION] * SIGN, atol=1e-12)
    gait = gait_table().at(np.zeros((3, 3)), np.array([0.0, 0.5, 0.3]))[:, :NUM_JOINTS]
    np.testing.assert_allclose(targets[0], (gait[0] + gait[1]) / 2, atol=1e-12)
    np.testing.assert_allclose(targets[2], gait[2], atol=1e-12)
    agent.set_velocity_command(ALL, tensor([[0.1, 0.0, 0.0]] * 3))
    agent.advance(make_state(3))
    assert not agent.view(make_state(3)).halted.any()
