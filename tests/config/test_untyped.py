"""Values merged after the options are what Hydra makes of all overrides at once."""

from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from omegaconf import OmegaConf

from slider.config.compose import compose_untyped

CONF = Path(__file__).parents[2] / "conf"


def by_hydra(overrides: list[str]) -> object:
    compose_untyped([], CONF)  # stores what is no file
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return OmegaConf.to_container(compose("config", overrides=overrides), resolve=True)


@pytest.mark.parametrize(
    "overrides",
    [
        ["train.walking.seed=3", "experiment=test", "train.walking.iterations=7"],
        ["experiment=robust", "train.walking.seed=3", "train.walking.seed=4"],
        ["+train.walking.reward.terms.alive={weight: 1.0, params: {}}", "train/walking=paper"],
        ["~train.walking.reward.terms.heading", "++gait.nodes=31", "finetuning=robust"],
        ["speeds.top=2.0", "evaluation/disturbance=robust", "control.hzd.label='a, b'"],
        ["train.walking.velocities={period: 3.0, vx: {upper: 1.0}}"],
        ["train/walking/reward=unguided", "robot.joints.slide.upper=0.3"],
    ],
)
def test_values_come_last(overrides):
    assert repr(compose_untyped(overrides, CONF)) == repr(by_hydra(overrides))


def test_a_changed_file_is_read_again(tmp_path):
    (tmp_path / "config.yaml").write_text("value: 1\n")
    (tmp_path / ".#config.yaml").symlink_to("an unsaved file of Emacs")
    assert compose_untyped([], tmp_path) == {"value": 1}
    (tmp_path / "config.yaml").write_text("value: 2\n")
    assert compose_untyped([], tmp_path) == {"value": 2}
