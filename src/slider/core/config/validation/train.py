"""Checks of the trainings: length, commands, learning and reward."""

from slider.core.config.env import EnvConfig
from slider.core.config.train import (
    CommandConfig,
    CurriculumConfig,
    NetworkConfig,
    TrainConfig,
    TrainingsConfig,
)
from slider.core.config.validation.checks import (
    all_at_least,
    at_least,
    interval,
    one_of,
    positive,
    require,
    share,
    some,
)
from slider.core.config.validation.disturbance import check_disturbance


def check_trainings(
    trainings: TrainingsConfig, finetuning: TrainConfig | None, env: EnvConfig
) -> None:
    """All trainings and their disturbances."""
    keyed = {"train.standing": trainings.standing, "train.walking": trainings.walking}
    if finetuning is not None:
        keyed["finetuning"] = finetuning
        for name in ("hidden", "activation"):
            own = getattr(trainings.walking.network, name)
            found = getattr(finetuning.network, name)
            expected = f"{own}, as train.walking.network has it"
            require(found == own, f"finetuning.network.{name}", expected, found)
    for key, train in keyed.items():
        _train(train, env, key)
        check_disturbance(train.disturbance, env, f"{key}.disturbance")


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    at_least(f"{key}.iterations", train.iterations, 0)
    all_at_least(key, train, ("num_envs", "steps_per_iteration"), 1)
    positive(f"{key}.episode_length", train.episode_length)
    _commands(train.commands, f"{key}.commands")
    one_of(f"{key}.guide.gait", train.guide.gait, ("interpolated", "nearest"))
    _symmetry(train, env, f"{key}.ppo")
    one_of(f"{key}.ppo.precision", train.ppo.precision, ("auto", "float32", "bfloat16"))
    one_of(f"{key}.ppo.schedule", train.ppo.schedule, ("adaptive", "fixed"))
    averaging = train.ppo.averaging
    require(0 <= averaging < 1, f"{key}.ppo.averaging", "a share in [0, 1)", averaging)
    _mini_batches(train, f"{key}.ppo.mini_batches")
    fraction = train.reset.reference_fraction
    expected = "a share in [0, 1]"
    require(0 <= fraction <= 1, f"{key}.reset.reference_fraction", expected, fraction)
    _network(train.network, f"{key}.network")
    some(f"{key}.reward.terms", train.reward.terms, "term")
    all_at_least(key, train, ("selection.robots", "selection.interval"), 1)


def _network(network: NetworkConfig, key: str) -> None:
    some(f"{key}.hidden", network.hidden, "layer")
    positive(f"{key}.std_min", network.std_min)
    expected = f"at least {network.std_min} (std_min)"
    for name in ("std_max", "std_max_final"):
        bound = getattr(network, name)
        require(bound >= network.std_min, f"{key}.{name}", expected, bound)
    share(f"{key}.calm_from", network.calm_from)


def _commands(commands: CommandConfig, key: str) -> None:
    for name in ("vx", "vy", "yaw_rate"):
        interval(f"{key}.{name}", getattr(commands, name))
    _curriculum(commands.curriculum, f"{key}.curriculum")


def _curriculum(curriculum: CurriculumConfig, key: str) -> None:
    share(f"{key}.start", curriculum.start)
    share(f"{key}.success", curriculum.success)
    positive(f"{key}.growth", curriculum.growth)


def _symmetry(train: TrainConfig, env: EnvConfig, key: str) -> None:
    symmetry = train.ppo.symmetry
    one_of(f"{key}.symmetry", symmetry, ("none", "augmentation", "loss"))
    at_least(f"{key}.symmetry_weight", train.ppo.symmetry_weight, 0.0)
    possible = symmetry == "none" or not env.phase.mirror
    expected = "none where env.phase.mirror shows the network left stance only"
    require(possible, f"{key}.symmetry", expected, symmetry)


def _mini_batches(train: TrainConfig, key: str) -> None:
    batch, found = train.num_envs * train.steps_per_iteration, train.ppo.mini_batches
    expected = f"1 to {batch} (num_envs × steps_per_iteration)"
    require(1 <= found <= batch, key, expected, found)
