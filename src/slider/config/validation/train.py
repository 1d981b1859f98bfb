"""Checks of the trainings: length, commands, learning and reward."""

from slider.config.env import EnvConfig
from slider.config.train import (
    CommandConfig,
    CurriculumConfig,
    NetworkConfig,
    PpoConfig,
    SelectionConfig,
    TrainConfig,
    TrainingsConfig,
)
from slider.config.validation.checks import (
    all_at_least,
    all_positive,
    at_least,
    fraction,
    interval,
    one_of,
    period,
    positive,
    require,
    share,
    some,
)
from slider.config.validation.disturbance import check_disturbance


def check_trainings(
    trainings: TrainingsConfig, finetuning: TrainConfig | None, env: EnvConfig
) -> None:
    """All trainings and their disturbances."""
    keyed = {"train.standing": trainings.standing, "train.walking": trainings.walking}
    starts = trainings.standing.reset.reference_fraction
    expected = "0 (pre-training has no guide to start on)"
    require(starts == 0, "train.standing.reset.reference_fraction", expected, starts)
    if trainings.pretraining:
        _same_network(trainings.walking.network, trainings.standing.network, "train.standing")
    if finetuning is not None:
        keyed["finetuning"] = finetuning
        _same_network(trainings.walking.network, finetuning.network, "finetuning")
    for key, train in keyed.items():
        _train(train, env, key)
        check_disturbance(train.disturbance, env, f"{key}.disturbance")


def _same_network(walking: NetworkConfig, other: NetworkConfig, key: str) -> None:
    """One training goes on with the weights of the other."""
    for name in ("hidden", "activation"):
        own, found = getattr(walking, name), getattr(other, name)
        expected = f"{own}, as train.walking.network has it"
        require(found == own, f"{key}.network.{name}", expected, found)


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    at_least(f"{key}.iterations", train.iterations, 0)
    require(0 <= train.seed < 2**63, f"{key}.seed", "an integer in [0, 2⁶³)", train.seed)
    all_at_least(key, train, ("robots", "steps_per_iteration"), 1)
    at_least(f"{key}.episode_length", train.episode_length, env.control_period)
    _commands(train.commands, f"{key}.commands")
    one_of(f"{key}.guide.gait", train.guide.gait, ("interpolated", "nearest"))
    _ppo(train.ppo, f"{key}.ppo")
    _symmetry(train, env, f"{key}.ppo")
    _mini_batches(train, f"{key}.ppo.mini_batches")
    fraction(f"{key}.reset.reference_fraction", train.reset.reference_fraction)
    _network(train.network, f"{key}.network")
    some(f"{key}.reward.terms", train.reward.terms, "term")
    _selection(train.selection, env, f"{key}.selection")


def _ppo(ppo: PpoConfig, key: str) -> None:
    one_of(f"{key}.precision", ppo.precision, ("auto", "float32", "bfloat16"))
    one_of(f"{key}.schedule", ppo.schedule, ("adaptive", "fixed"))
    at_least(f"{key}.epochs", ppo.epochs, 1)
    all_positive(key, ppo, ("learning_rate", "desired_kl", "clip", "max_grad_norm"))
    all_at_least(key, ppo, ("value_coefficient", "entropy_coefficient"), 0)
    share(f"{key}.gamma", ppo.gamma)
    fraction(f"{key}.lam", ppo.lam)
    require(0 <= ppo.actor_ema < 1, f"{key}.actor_ema", "a share in [0, 1)", ppo.actor_ema)


def _selection(selection: SelectionConfig, env: EnvConfig, key: str) -> None:
    some(f"{key}.commands", selection.commands, "command")
    all_at_least(key, selection, ("robots", "interval"), 1)
    positive(f"{key}.fall_weight", selection.fall_weight)
    most = selection.fall_weight / 2
    expected = f"0 to {most:g}, half of fall_weight: a robot that fell costs most"
    require(
        0 <= selection.flight_weight <= most,
        f"{key}.flight_weight",
        expected,
        selection.flight_weight,
    )
    period(f"{key}.warm_up", selection.warm_up, selection.duration, env.control_period)


def _network(network: NetworkConfig, key: str) -> None:
    some(f"{key}.hidden", network.hidden, "layer")
    for index, width in enumerate(network.hidden):
        at_least(f"{key}.hidden[{index}]", width, 1)
    one_of(f"{key}.activation", network.activation, ("elu", "relu", "tanh"))
    all_positive(key, network, ("initial_std", "std_min", "output_scale"))
    expected = f"at least {network.std_min} (std_min)"
    for name in ("std_max", "std_final"):
        bound = getattr(network, name)
        require(bound >= network.std_min, f"{key}.{name}", expected, bound)
    share(f"{key}.anneal_from", network.anneal_from)


def _commands(commands: CommandConfig, key: str) -> None:
    for name in ("vx", "vy", "yaw_rate"):
        interval(f"{key}.{name}", getattr(commands, name))
    at_least(f"{key}.period", commands.period, 0)
    fraction(f"{key}.standing_fraction", commands.standing_fraction)
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
    batch, found = train.robots * train.steps_per_iteration, train.ppo.mini_batches
    size = f"{key.partition('.ppo')[0]}.robots"
    require(batch > 1, size, "at least 2 samples (robots × steps_per_iteration)", batch)
    expected = f"1 to {batch} (robots × steps_per_iteration)"
    require(1 <= found <= batch, key, expected, found)
