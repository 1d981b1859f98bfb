"""A term is one function and one line of the configuration, and says itself what it needs."""

import re
from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from pathlib import Path
from textwrap import dedent
from unittest.mock import patch

import numpy as np
import pytest
import torch
import yaml
from pydantic import TypeAdapter

from slider.control.layout import describe
from slider.core.errors import UserError
from slider.env import observations, rewards, terminations
from slider.env.declaration import Needs
from slider.env.rewards import RewardView
from slider.env.terms import check_clock, checked, uses_library
from tests.config.composed import CONF
from tests.control.policies import make_policy
from tests.env.synthetic import config, make_guide, make_state, make_view, random_view
from tests.env.test_vec_env import actions, build

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "extend.md"


@cache
def params() -> dict[str, dict[str, float]]:
    """Parameters of each reward term, those of the configuration with most terms if it has it."""
    found = {name: dict.fromkeys(term.parameters, 1.0) for name, term in rewards.TERMS.items()}
    terms = config("train/walking/reward=clf").train.walking.reward.terms
    return found | {name: term.params for name, term in terms.items()}


@pytest.fixture
def documented():
    """The two terms of the page about adding one, declared in their modules, and their lines.

    They take the place of terms that were added under the same names.
    """
    lines = {}
    with patch.dict(rewards.TERMS), patch.dict(observations.TERMS):
        for module, title in ((rewards, "A reward term"), (observations, "An observation")):
            section = PAGE.read_text().partition(f"## {title}\n")[2].partition("\n## ")[0]
            code = re.search(r"```python\n(.*?)```", section, re.S)[1]
            lines[module] = yaml.safe_load(re.search(r"2\. Add .*`(\w+: .*)`\.", section)[1])
            for name in lines[module]:
                module.TERMS.pop(name, None)
            exec(dedent(code), {**vars(module)})
        yield lines


def test_a_function_and_a_line_are_seen_in_the_rollout_the_layout_and_the_log(documented):
    ((name, term),) = documented[rewards].items()
    ((seen, scale),) = documented[observations].items()
    text = str(term).replace("'", "")
    overrides = (
        f"++train.walking.reward.terms.{name}={text}",
        f"++env.observation.terms.{seen}={scale}",
    )
    whole = checked(config("experiment=test", "env.phase.mirror=true", *overrides))
    env, generator = build(whole), torch.Generator().manual_seed(0)
    logged, loaded = [], 0
    rows = describe(make_policy(*overrides), {}, {})["observation"]
    row = rows[-1]
    assert (row["name"], row["width"], row["scale"]) == ("foot_forces", 2, 0.005)
    assert (row["units"], row["components"]) == (["N", "N"], ["left", "right"])
    for _ in range(40):
        found, _, _, extras = env.step(actions(True, generator))
        logged.append(extras["log"]["/reward/knock"])
        forces = np.clip(0.005 * env.physics.read().foot_forces, 0.0, whole.env.observation.clip)
        seen = found["policy"][:, row["start"] :][:, :2].numpy()  # right stance is reflected
        np.testing.assert_allclose(np.sort(seen), np.sort(forces), rtol=1e-6)
        loaded += (seen > 0).sum()
    assert -0.1 <= min(logged) < max(logged) == 0.0
    assert loaded > 0


def test_every_parameter_of_a_term_has_its_unit():
    for terms in (rewards.TERMS, terminations.TERMS):
        for name, term in terms.items():
            for parameter, hint in term.parameters.items():
                found = TypeAdapter(hint).json_schema()
                assert found["unit"], f"{name}.{parameter}"
                assert {"minimum", "exclusiveMinimum"} & found.keys(), f"{name}.{parameter}"


@pytest.mark.parametrize("name", rewards.TERMS)
def test_a_reward_needs_the_clock_and_the_library_exactly_if_it_reads_them(name):
    term, view = rewards.TERMS[name], random_view(40)
    later = replace(view, phase=(view.phase + 0.37) % 1.0)
    before = RewardView(view, make_guide()).outputs
    values = [
        term.function(RewardView(seen, make_guide(), before), **params()[name])
        for seen in (view, later)
    ]
    assert (values[0] != values[1]).any() == (Needs.CLOCK in term.needs)
    refused = pytest.raises(UserError, match="expected a gait library")
    with refused if Needs.LIBRARY in term.needs else nullcontext():
        term.function(RewardView(view, None), **params()[name])


@pytest.mark.parametrize("name", observations.TERMS)
def test_an_observation_needs_the_clock_exactly_if_it_reads_it(name):
    term = observations.TERMS[name]
    seen = [term.function(make_view(make_state(1), phase=[phase])) for phase in (0.1, 0.3)]
    assert (seen[0] != seen[1]).any() == (Needs.CLOCK in term.needs)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("+train.walking.reward.terms.effort.params.x=1", "effort.params: expected none, found x"),
        ("~train.walking.reward.terms.heading.params.width", "params: expected width, found none"),
    ],
)
def test_every_mistake_is_one_line(override, message, refused):
    assert message in refused("config", override, "--conf", str(CONF))


def test_a_term_that_counts_needs_its_clock_and_its_library():
    whole = config("env/phase=none", "env.action.offset=nominal", "~env.observation.terms.phase")
    walking = whole.train.walking
    bare = replace(walking, reset=replace(walking.reset, reference_fraction=0.0))
    for name, term in walking.reward.terms.items():
        needs = rewards.TERMS[name].needs
        for weight in (0.0, 1.0):
            terms = {name: replace(term, weight=weight)}
            train = replace(bare, reward=replace(walking.reward, terms=terms))
            counts, message = weight > 0, f"me: reward.terms: .* for {name}, found no"
            assert uses_library(whole.env, train) == (counts and Needs.LIBRARY in needs), name
            refused = pytest.raises(UserError, match=message)
            with refused if counts and Needs.CLOCK in needs else nullcontext():
                check_clock(whole.env, train, "me")
