"""Rules of the trainings: batches, network, reward, checks and what they share."""

from slider.config.env import EnvConfig
from slider.config.schema import Config
from slider.config.train import NetworkConfig, SelectionConfig, TrainConfig
from slider.config.validation.checks import period, require
from slider.config.validation.env import check_disturbance


def check_trainings(config: Config) -> None:
    """All trainings and their disturbances."""
    walking, standing = config.train.walking, config.train.standing
    starts = standing.reset.reference_fraction
    expected = "0 (pre-training has no guide to start on)"
    require(starts == 0, "train.standing.reset.reference_fraction", expected, starts)
    for key, train in config.trainings.items():
        if train is not standing or config.train.pretraining:
            _same_network(walking.network, train.network, key)
        _train(train, config.env, key)
        _machine(train, config, key)
        check_disturbance(train.disturbance, config.env, f"{key}.disturbance")


def _machine(train: TrainConfig, config: Config, key: str) -> None:
    """Physics, device and precision that go together."""
    portable = config.numerics == "portable"
    precise = not portable or train.ppo.precision != "bfloat16"
    expected = "auto or float32 with numerics=portable"
    require(precise, f"{key}.ppo.precision", expected, train.ppo.precision)
    own = {
        "numerics=portable": portable,
        "disturbance.ground.amplitude > 0": train.disturbance.ground.amplitude > 0,
    }
    for setting, chosen in own.items():
        possible = train.simulator == "mujoco" or not chosen
        require(possible, f"{key}.simulator", f"mujoco with {setting}", train.simulator)
    possible = train.simulator == "mujoco_warp" or train.device == "cpu"
    require(possible, f"{key}.device", f"cpu with simulator={train.simulator}", train.device)
    possible = train.device == "cuda" or train.gpus == 1
    require(possible, f"{key}.gpus", f"1 with device={train.device}", train.gpus)


def _same_network(walking: NetworkConfig, other: NetworkConfig, key: str) -> None:
    """One training goes on with the weights of the other."""
    for name in ("hidden", "activation"):
        own, found = getattr(walking, name), getattr(other, name)
        expected = f"{own}, as train.walking.network has it"
        require(found == own, f"{key}.network.{name}", expected, found)


def _train(train: TrainConfig, env: EnvConfig, key: str) -> None:
    length, least = train.episode_length, env.control_period
    require(length >= least, f"{key}.episode_length", f"a value ≥ {least}", length)
    _symmetry(train, env, f"{key}.ppo.symmetry")
    _mini_batches(train, key)
    _network(train.network, f"{key}.network")
    _selection(train.selection, env, f"{key}.selection")


def _selection(selection: SelectionConfig, env: EnvConfig, key: str) -> None:
    most = selection.fall_weight / 2
    expected = f"0 to {most:g}, half of fall_weight: a robot that fell costs most"
    possible = selection.flight_weight <= most
    require(possible, f"{key}.flight_weight", expected, selection.flight_weight)
    period(f"{key}.warm_up", selection.warm_up, selection.duration, env.control_period)


def _network(network: NetworkConfig, key: str) -> None:
    expected = f"at least {network.std_min} (std_min)"
    for name in ("std_max", "std_final"):
        bound = getattr(network, name)
        require(bound >= network.std_min, f"{key}.{name}", expected, bound)


def _symmetry(train: TrainConfig, env: EnvConfig, key: str) -> None:
    possible = train.ppo.symmetry == "none" or not env.phase.mirror
    expected = "none where env.phase.mirror shows the network left stance only"
    require(possible, key, expected, train.ppo.symmetry)


def _mini_batches(train: TrainConfig, key: str) -> None:
    batch, found = train.robots * train.steps_per_iteration, train.ppo.mini_batches
    size = "at least 2 samples (robots × steps_per_iteration)"
    require(batch > 1, f"{key}.robots", size, batch)
    expected = f"1 to {batch} (robots × steps_per_iteration)"
    require(found <= batch, f"{key}.ppo.mini_batches", expected, found)
