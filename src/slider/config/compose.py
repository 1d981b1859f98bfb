"""Compose ``conf/`` with overrides into a typed, checked :class:`Config`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slider.config.control import FAMILIES
from slider.config.convert import from_dict
from slider.config.schema import Config
from slider.config.untyped import compose_untyped
from slider.config.validation import validate
from slider.core.errors import UserError


def compose(overrides: Sequence[str], conf: Path) -> Config:
    """Resolve ``conf/config.yaml`` with Hydra overrides such as ``gait.grid.vx.stop=0.6``.

    Raises:
        UserError: an unknown key or group, a wrong type or an impossible value.
    """
    values = compose_untyped(overrides, conf)
    _check_families(values["control"])
    config = from_dict(Config, values)
    validate(config)
    return config


def _check_families(controllers: Any) -> None:
    """The family tells which settings a controller has, so that it comes first."""
    for name, control in controllers.items() if isinstance(controllers, dict) else ():
        if not isinstance(control, dict):
            found = json.dumps(control, ensure_ascii=False)
            raise UserError(f"control.{name}: expected the settings of a controller, found {found}")
        family = control.get("family")
        if family not in (*FAMILIES,):
            found = "none" if family is None else json.dumps(family, ensure_ascii=False)
            expected = f"one of {', '.join(FAMILIES)}"
            raise UserError(f"control.{name}.family: expected {expected}, found {found}")
