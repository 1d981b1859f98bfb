"""A term is one function and one line of the configuration, and says itself what it needs."""

import importlib.util
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from pipeline.entry import open_pipeline
from slider.cli import main
from slider.config.reference import kind
from slider.control.layout import describe
from slider.core.errors import UserError
from slider.env import observations, rewards, terminations
from slider.env.declaration import Needs
from slider.env.rewards import RewardView
from slider.env.terms import check_clock, checked, uses_library
from tests.control.policies import make_policy
from tests.env.synthetic import CONF, config, make_guide, make_state, make_view
from tests.env.test_rewards import moving_view
from tests.env.test_vec_env import NUM_ENVS, actions, build

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "extend.md"
REWARDS = sorted(path.stem for path in (CONF / "train" / "walking" / "reward").glob("*.yaml"))


@cache
def params() -> dict[str, dict[str, float]]:
    """Parameters of each reward term, those of a configuration that has it."""
    found = {name: dict.fromkeys(term.parameters, 1.0) for name, term in rewards.TERMS.items()}
    for reward in REWARDS:
        terms = config(f"train/walking/reward={reward}").train.walking.reward.terms
        found |= {name: term.params for name, term in terms.items()}
    return found


@pytest.fixture
def documented(tmp_path):
    """The two terms of the page about adding one, in a module, and their lines of YAML.

    They take the place of terms that were added under the same names.
    """
    before = {module: dict(module.TERMS) for module in (rewards, observations)}
    lines = {}
    for module, title in ((rewards, "A reward term"), (observations, "An observation")):
        section = PAGE.read_text().partition(f"## {title}\n")[2].partition("\n## ")[0]
        code = re.search(r"```python\n(.*?)```", section, re.S)[1]
        line = yaml.safe_load(re.search(r"2\. Its line.*`(\w+: .*)`\.", section)[1])
        for name in line:
            module.TERMS.pop(name, None)
        path = tmp_path / f"more_{title.split()[-1]}.py"
        indented = code.replace("\n    ", "\n").strip()
        path.write_text(f"from {module.__name__} import *\n\n{indented}\n")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        spec.loader.exec_module(importlib.util.module_from_spec(spec))
        lines[module] = line
    yield lines
    for module, terms in before.items():
        module.TERMS.clear()
        module.TERMS.update(terms)


def overridden(lines) -> list[str]:
    ((name, term),) = lines[rewards].items()
    ((seen, scale),) = lines[observations].items()
    text = f"{{weight: {term['weight']}, params: {{limit: {term['params']['limit']}}}}}"
    return [
        f"++train.walking.reward.terms.{name}={text}",
        f"++env.observation.terms.{seen}={scale}",
    ]


def test_a_function_and_a_line_are_seen_in_the_rollout_the_layout_and_the_log(documented):
    overrides = overridden(documented)
    whole = config("experiment=test", "env.phase.mirror=true", *overrides)
    checked(whole)
    env = build(whole)
    generator = torch.Generator().manual_seed(0)
    logged, loaded = [], 0
    layout = env.agent.observer.layout
    names = list(layout)
    start = sum(layout[name] for name in names[: names.index("foot_forces")])
    for _ in range(40):
        found, _, _, extras = env.step(actions("random", generator))
        logged.append(extras["log"]["/reward/knock"])
        forces = np.clip(0.005 * env.physics.read().foot_forces, 0.0, whole.env.observation.clip)
        seen = found["policy"][:, start : start + 2].numpy()  # right stance is reflected
        np.testing.assert_allclose(np.sort(seen), np.sort(forces), rtol=1e-6)
        loaded += (seen > 0).sum()
    assert layout["foot_forces"] == 2
    robots = np.array(logged) / (-0.1 / NUM_ENVS)  # that knock
    np.testing.assert_allclose(robots, np.round(robots), atol=1e-9)
    assert 0 <= robots.min() < robots.max() <= NUM_ENVS
    assert loaded > 0
    policy = make_policy(*overrides)
    (row,) = [
        term
        for term in describe(policy, {})["observation"]["terms"]
        if term["name"] == "foot_forces"
    ]
    assert row == {
        "name": "foot_forces",
        "start": start,
        "width": 2,
        "scale": 0.005,
        "units": ["N", "N"],
        "frame": "world",
        "components": ["left", "right"],
        "meaning": "Vertical ground reaction of each foot.",
    }


def test_every_parameter_of_a_term_has_its_unit():
    for terms in (rewards.TERMS, terminations.TERMS):
        for name, term in terms.items():
            for parameter, hint in term.parameters.items():
                found = kind(hint)
                assert found.unit, f"{name}.{parameter}"
                assert found.bound, f"{name}.{parameter}"


@pytest.mark.parametrize("name", rewards.TERMS)
def test_a_reward_needs_the_clock_and_the_library_exactly_if_it_reads_them(name):
    term, view = rewards.TERMS[name], moving_view()
    later = replace(view, phase=(view.phase + 0.37) % 1.0)
    before = RewardView(view, make_guide()).outputs
    values = [
        term.function(RewardView(seen, make_guide(), before), **params()[name])
        for seen in (view, later)
    ]
    assert (values[0] != values[1]).any() == (Needs.CLOCK in term.needs)
    if Needs.LIBRARY in term.needs:
        with pytest.raises(UserError, match="expected a gait library"):
            term.function(RewardView(view, None), **params()[name])
    else:
        term.function(RewardView(view, None), **params()[name])


@pytest.mark.parametrize("name", observations.TERMS)
def test_an_observation_needs_the_clock_exactly_if_it_reads_it(name):
    term = observations.TERMS[name]
    seen = [term.function(make_view(make_state(1), phase=[phase])) for phase in (0.1, 0.3)]
    assert (seen[0] != seen[1]).any() == (Needs.CLOCK in term.needs)


MISTAKES = [
    ("+train.walking.reward.terms.effort.params.x=1", "effort.params: expected none, found x"),
    ("~train.walking.reward.terms.heading.params.width", "params: expected width, found none"),
    ("+env.observation.terms.nose=1.0", "env.observation.terms: expected some of"),
]


@pytest.mark.parametrize(("override", "message"), MISTAKES)
def test_every_mistake_is_one_line(override, message, capsys):
    assert main(["config", override, "--conf", str(CONF)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


def test_no_plan_is_laid_out_with_a_mistake_in_a_variant(capsys, tmp_path, monkeypatch):
    variant = """'study.ablation.variants.default.overrides=["+env.observation.terms.nose=1.0"]'"""
    overrides = f"report.sections=[ablation] study.ablation.run=[default] {variant}"
    expected = "slider: study.ablation.variants.default: env.observation.terms: expected some of"
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        open_pipeline({"hydra": overrides}, CONF)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(expected)
    assert not list(tmp_path.iterdir())


def test_a_term_that_counts_needs_its_clock_and_its_library():
    whole = config("env/phase=none", "env.action.offset=nominal", "~env.observation.terms.phase")
    walking = whole.train.walking
    bare = replace(walking, reset=replace(walking.reset, reference_fraction=0.0))
    for name, term in walking.reward.terms.items():
        needs = rewards.TERMS[name].needs
        for weight in (0.0, 1.0):
            terms = {name: replace(term, weight=weight)}
            train = replace(bare, reward=replace(walking.reward, terms=terms))
            counts = weight > 0
            assert uses_library(whole.env, train) == (counts and Needs.LIBRARY in needs), name
            if counts and Needs.CLOCK in needs:
                with pytest.raises(UserError, match=f"me: reward.terms: .* for {name}, found no"):
                    check_clock(whole.env, train, "me")
            else:
                check_clock(whole.env, train, "me")
