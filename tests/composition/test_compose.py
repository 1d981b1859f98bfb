"""Every file of ``conf/`` composes, every mistake is one line, every robot value has a source."""

import shutil
from itertools import zip_longest
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir

from pipeline.stages.gaits import velocities
from tests.config.composed import CONF, composed, refusal


def options() -> list[tuple[str, ...]]:
    """Each ``group=name`` once; those of different groups together, experiments alone.

    Without bases, controllers and studies, all of which are in, and without profiles.
    """
    groups: dict[str, list[str]] = {}
    for path in sorted(CONF.rglob("*/*.yaml")):
        group = str(path.parent.relative_to(CONF))
        apart = group in ("control", "study") or path.stem in ("base", "joystick", "heldout")
        if not apart:
            groups.setdefault(group, []).append(f"{group}={path.stem}")
    experiments = [(option,) for option in groups.pop("experiment")]
    return experiments + [tuple(filter(None, row)) for row in zip_longest(*groups.values())]


@pytest.mark.parametrize("together", options())
def test_every_option_composes(together):
    composed(*together)


def test_hydra_of_the_caller_stays_as_it_was(tmp_path):
    (tmp_path / "mine.yaml").write_text("a: 1\n")
    with initialize_config_dir(str(tmp_path), version_base="1.3"):
        composed("robot=slider")
        assert compose("mine") == {"a": 1}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("hydra.run.dir=x", "hydra: expected keys of conf/, found hydra.run.dir=x, which has no"),
        ("+protocols.Mine=${protocols.sweep}", "protocols: expected names of small letters"),
        ("gait.nods=3", "unknown configuration key 'gait.nods', did you mean 'gait.nodes'?"),
        ("control.mpc_wbc_literal.step.time_per_speed=0", "expected +control.mpc_wbc_literal.step"),
        ("train.walking.reward.terms.heding.weight=1", "heading.weight'? A new name needs a + in"),
        ("gait.bounds={a: {lower: 0, upper: 1}}", "key 'gait.bounds.a'. A new name needs a + in"),
        ("finetuning.iterations=3", "expected finetuning=outdoor or finetuning=robust beside it"),
        ("experiment=nope", "unknown option experiment=nope, expected one of: default"),
        ("~robot.drives.capstan", "robot.drives: expected hip_yaw, hip_roll, hip_pitch, capstan"),
        ("~control.hzd.family", "control.hzd.family: expected a value, found none"),
        ("control=mpc_wbc_tuned", "control: expected all; evaluation.controllers chooses contro"),
        (
            "++train.walking={simulator:mujoco_warp,disturbance:{terrain:{kinds:[tiles]}}}",
            "simulator: expected mujoco with disturbance.terrain or ",
        ),
        ("evaluation=joystick", "evaluation.profile: expected none (the velocities of Table 1"),
    ],
)
def test_every_mistake_is_one_line(override, message, refused):
    assert message in refused("config", override, "--conf", str(CONF))


def test_a_fine_tuning_has_the_values_of_the_walking_training():
    overrides = ["train.walking.seed=4", "finetuning.reward.terms.heading.weight=0.7"]
    config = composed("experiment=turning", "finetuning=robust", *overrides)
    walking, tuning = config.train.walking, config.finetuning
    assert (tuning.seed, tuning.velocities) == (4, walking.velocities)
    assert tuning.selection.speeds == walking.selection.speeds
    assert tuning.reward.terms.pop("heading").weight == 0.7
    walking.reward.terms.pop("heading")
    assert tuning.reward == walking.reward


def test_a_list_of_speeds_takes_the_place_of_an_axis():
    one = composed("gait.grid.vx=[0.33]").gait.grid
    assert one.vx == [0.33]
    assert one.vy == composed().gait.grid.vy
    overrides = ["gait.grid.vx.stop=0.5", "gait.grid.vx=[0.2]", "gait.grid.vx=[0.4,0.33]"]
    last = composed("experiment=test", *overrides, "gait.grid.vy=[0.0]").gait.grid
    assert (last.vx, last.vy) == ([0.4, 0.33], [0.0])
    assert velocities(last) == [(0.33, 0.0, 0.0), (0.4, 0.0, 0.0)]


@pytest.mark.parametrize(
    ("path", "text", "line"),
    [("config.yaml", "a: 1\n\tb: 2\n", 2), ("experiment/bad.yaml", "a: 1\nb: 'open\n", 3)],
)
def test_malformed_yaml_is_one_line(path, text, line, tmp_path):
    conf = Path(shutil.copytree(CONF, tmp_path / "conf"))
    (conf / path).write_text(text)
    overrides = ["experiment=bad"] if path.startswith("experiment") else []
    assert refusal(overrides, conf).startswith(f"{conf / path}, line {line}: expected YAML, found ")


def test_one_override_of_the_network_is_for_all_trainings():
    sizes = ("train.walking.network.hidden=[64,32]", "train.walking.network.activation=tanh")
    whole = composed("finetuning=robust", *sizes)
    for train in (whole.train.standing, whole.train.walking, whole.finetuning):
        assert (train.network.hidden, train.network.activation) == ([64, 32], "tanh")
    scratch = ["train.pretraining=false", "train.standing.network.hidden=[8]"]
    assert composed(*scratch).train.standing.network.hidden == [8]


@pytest.mark.parametrize(("top", "count"), [("2.0", 21), ("2.47", 25), ("1.3", 14)])
def test_the_sweep_ends_at_or_below_the_top_speed(top, count):
    commands = composed(f"speeds.top={top}").protocols["sweep"].speeds
    assert commands == [round(0.1 * index, 9) for index in range(count)]
