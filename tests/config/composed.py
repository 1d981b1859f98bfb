"""Compositions of the repository's configuration."""

from collections.abc import Iterable
from pathlib import Path

import pytest

from slider.composition.compose import compose
from slider.config.schema import Config
from slider.core.errors import UserError

CONF = Path(__file__).parents[2] / "conf"


def composed(*overrides: str) -> Config:
    return compose(overrides, CONF)


def refusal(overrides: Iterable[str], conf: Path = CONF) -> str:
    """The one line that a composition ends with."""
    with pytest.raises(UserError) as error:
        compose([*overrides], conf)
    assert "\n" not in str(error.value)
    return str(error.value)
