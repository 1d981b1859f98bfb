"""The policy file and its network, which must be that of training."""

from dataclasses import asdict

import numpy as np
import pytest
import torch
from rsl_rl.models import MLPModel
from tensordict import TensorDict

from slider.control.policy import PolicyController, from_actor, load_policy, save_policy
from slider.core.errors import UserError
from slider.training.ppo import NORMALISER_EPSILON
from tests.control.policies import make_policy
from tests.env.synthetic import make_agent, make_state

SIZE = 16  # observations of the actors


WITHOUT_GAITS = ("env/phase=none", "env.action.offset=nominal", "~env.observation.terms.phase")


@pytest.mark.parametrize("gaits", [True, False])
def test_comes_back_as_it_was_saved(tmp_path, gaits):
    """Step times of the clock and gaits under the actions included."""
    policy = make_policy(*(() if gaits else WITHOUT_GAITS))
    save_policy(policy, tmp_path / "policy.pt")
    back = load_policy(tmp_path / "policy.pt")
    observations = torch.randn(50, sum(policy.observations.values()))
    with torch.inference_mode():
        assert torch.equal(policy.network(observations), back.network(observations))
    assert (back.hidden, back.activation) == (policy.hidden, policy.activation)
    assert [*back.observations.items()] == [*policy.observations.items()], "their order matters"
    assert not back.network.training
    assert (back.robot, back.env, back.training) == (policy.robot, policy.env, policy.training)
    for found, saved in ((back.times, policy.times), (back.reference, policy.reference)):
        assert (found is not None) == gaits
        np.testing.assert_equal(gaits and asdict(found), gaits and asdict(saved))


def foreign(path, content) -> None:
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        save_policy(make_policy(), path)
        own = torch.load(path, weights_only=True)
        torch.save(own | content if isinstance(content, dict) else content, path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "expected a policy file at {path}, found none"),
        (b"not a policy", "{path}: expected a policy file of this project"),
        (torch.zeros(3), "{path}: expected format slider-policy, found Tensor"),
        ({"format": None}, "{path}: expected format slider-policy, found None"),
        ({"version": 99}, "{path}: expected version 10, found 99"),
    ],
)
def test_foreign_file_is_one_line(tmp_path, content, message):
    path = tmp_path / "policy.pt"
    foreign(path, content)
    with pytest.raises(UserError) as error:
        load_policy(path)
    assert str(error.value) == message.format(path=path)


def make_actor(hidden: list[int], activation: str, statistics: list[torch.Tensor]) -> MLPModel:
    """An rsl-rl actor as in training, with a normaliser that has seen something."""
    torch.manual_seed(0)
    distribution = {"class_name": "GaussianDistribution", "init_std": 0.5, "std_type": "log"}
    actor = MLPModel(
        TensorDict({"policy": torch.zeros(1, SIZE)}, batch_size=[1]),
        {"actor": ["policy"]},
        "actor",
        12,
        hidden,
        activation,
        obs_normalization=True,
        distribution_cfg=distribution,
    )
    for observations in statistics:
        actor.update_normalization(seen(observations))
    return actor


def seen(observations: torch.Tensor) -> TensorDict:
    return TensorDict({"policy": observations}, batch_size=[len(observations)])


@pytest.mark.parametrize(
    ("activation", "hidden"), [("elu", [16]), ("relu", [32, 16]), ("tanh", [8] * 6)]
)
def test_equals_the_actor_of_training(activation, hidden):
    statistics = [3.0 + 2.0 * torch.randn(200, SIZE) for _ in range(5)]
    actor = make_actor(hidden, activation, statistics)
    for _ in range(2):
        network = from_actor(actor.state_dict(), hidden, activation, NORMALISER_EPSILON)
        observations = 3.0 + 4.0 * torch.randn(300, SIZE)
        with torch.inference_mode():
            expected = actor.eval()(seen(observations))
            assert expected.std() > 0.01
            torch.testing.assert_close(network(observations), expected, rtol=0, atol=1e-6)
        actor.train()
        actor.update_normalization(seen(torch.randn(500, SIZE)))


def test_an_observation_that_never_varied_is_not_scaled():
    observations = torch.randn(100, SIZE)
    observations[:, 2] = 0.25
    actor = make_actor([16], "elu", [observations])
    network = from_actor(actor.state_dict(), [16], "elu", NORMALISER_EPSILON)
    expected = actor.obs_normalizer.std
    expected[2] = 1.0
    torch.testing.assert_close(network.std, expected + NORMALISER_EPSILON)


def test_the_controller_starts_its_clock_at_zero_and_moves_it_between_calls():
    agent = make_agent(2, "env.reference.acceleration=2.0")  # 0.04 m/s in a period
    seen, state = [], make_state(2, yaw=[0.4, -0.4])

    def network(observations: torch.Tensor) -> torch.Tensor:
        seen.append(agent.clock.phase.clone())
        return torch.zeros(len(observations), 12)

    controller = PolicyController(network, agent)
    for _ in range(2):  # a second rollout starts anew
        controller.reset(state, np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]]))
        np.testing.assert_allclose(agent.command[:, 3], 0.0, atol=1e-12)
        for _ in range(4):
            controller.control(state)
    phases = np.array(seen)
    # The first period is of standing, then the reference velocity goes to the command.
    reference = np.minimum(0.4, 0.04 * np.arange(3))[:, None] * [0.0, 1.0]
    steps = 0.02 / (2 * (0.4 - 0.1 * reference))
    expected = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    np.testing.assert_allclose(phases[:4], expected, atol=1e-9)
    np.testing.assert_array_equal(phases[4:], phases[:4])
