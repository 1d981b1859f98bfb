"""Compose ``conf/`` with Hydra overrides into a typed, checked :class:`Config`."""

import difflib
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from hydra import compose as hydra_compose
from hydra import initialize_config_dir
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import HydraException
from omegaconf import ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import MarkedYAMLError, YAMLError

from slider.config import scaling as scaling  # registers resolvers
from slider.config.control import FAMILIES
from slider.config.convert import from_dict
from slider.config.reference import BY_NAME, kind_at
from slider.config.robot_file import store_robot, without_capstan
from slider.config.schema import Config
from slider.config.validation import NAME, validate
from slider.core.errors import UserError, require

_MOST_STEPS = 1000  # of a list from start to stop
_ALL = re.compile(r"\W*(control|study)(=|$)(?!all$)")
_HYDRA = re.compile(r"\W*hydra(\W|$)")
_LIST_FOR_AXIS = re.compile(r"(gait\.grid\.v[xy])=\[")


def compose(overrides: Sequence[str], conf: Path) -> Config:
    """Resolve ``conf/config.yaml`` with Hydra overrides such as ``gait.grid.vx.stop=0.6``.

    Raises:
        UserError: an unknown key or group, a wrong type or an impossible value.
    """
    values = compose_untyped(overrides, conf)
    _check_families(values["control"])
    config = from_dict(Config, values, describe=kind_at)
    validate(config)
    return config


def _check_families(controllers: Any) -> None:
    """The family tells which settings a controller has, so that it comes first."""
    for name, control in controllers.items() if isinstance(controllers, dict) else ():
        settings = isinstance(control, dict)
        require(settings, f"control.{name}", "the settings of a controller", json.dumps(control))
        family = control.get("family")
        value = "none" if family is None else json.dumps(family, ensure_ascii=False)
        require(
            family in (*FAMILIES,), f"control.{name}.family", f"one of {', '.join(FAMILIES)}", value
        )


def compose_untyped(overrides: Sequence[str], conf: Path) -> dict[str, Any]:
    """Resolve ``conf/config.yaml``; half a second.

    Raises:
        UserError: an unknown key or group, or files or overrides that cannot be read.
    """
    if not (conf / "config.yaml").is_file():
        raise UserError(f"expected the configuration folder with config.yaml, found none at {conf}")
    _check_groups(overrides)
    _store_all(conf, "control")
    _store_all(conf, "study")
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(conf.resolve()), version_base="1.3"):
        try:
            options = store_robot(_as_hydra_wants(overrides), conf)
            config = hydra_compose("config", overrides=options)
            values = cast(dict[str, Any], OmegaConf.to_container(config, resolve=True))
            without_capstan(values.get("robot"))
            return values
        except HydraException as error:
            raise UserError(_explain(error, overrides, conf)) from None
        except OmegaConfBaseException as error:
            raise UserError(_first_line(error)) from None
        except (YAMLError, UnicodeDecodeError) as error:
            raise UserError(_malformed(error)) from None
        except (TypeError, ValueError, AttributeError):  # Hydra's own, for overrides like group=[1]
            raise UserError(f"cannot read the overrides: {' '.join(overrides)}") from None


# What is no number or no list passes: the schema says where it stands and what is expected.
def _steps(start: float, stop: Any, step: float) -> list[Any]:
    """Numbers from start up to stop, itself included where a step meets it."""
    if not isinstance(stop, int | float) or not start <= stop <= start + _MOST_STEPS * step:
        return [stop]
    count = int((stop - start) / step + 1e-9) + 1
    return [round(start + index * step, 9) for index in range(count)]


def _joined(*lists: Any) -> list[Any]:
    return [
        v
        for values in lists
        for v in (values if isinstance(values, list | ListConfig) else [values])
    ]


OmegaConf.register_new_resolver("steps", _steps, replace=True)
OmegaConf.register_new_resolver("joined", _joined, replace=True)


def _check_groups(overrides: Sequence[str]) -> None:
    """Refuse keys that start programs of Hydra, and choices of controllers and studies.

    All of these are there; protocols and targets choose among them.
    """
    for text in overrides:
        if _HYDRA.match(text):
            raise UserError(f"hydra: expected keys of conf/, found {text}, which has no effect")
        if group := _ALL.match(text):
            choice, name = text.partition("=")[2] or text, group.group(1)
            chooses = "; evaluation.controllers chooses controllers" if name == "control" else ""
            raise UserError(f"{name}: expected all{chooses}, found {choice}")


def _store_all(conf: Path, group: str) -> None:
    """Write the option ``GROUP=all``: each file of ``conf/GROUP`` under its own name."""
    names = sorted(path.stem for path in (conf / group).glob("*.yaml"))
    for name in names:
        if not NAME.fullmatch(name) or name == "all":
            expected = "small letters, digits and _ after a letter, and not all"
            raise UserError(f"{conf / group}/{name}.yaml: expected {expected}, found {name}")
    defaults = [f"{name}@{name}" for name in names if name != "base"]
    ConfigStore.instance().store("all", {"defaults": defaults}, group=group)


def _as_hydra_wants(overrides: Sequence[str]) -> list[str]:
    """Hydra lets no list take the place of start, stop and step: delete them first."""
    result = []
    for text in overrides:
        axis = _LIST_FOR_AXIS.match(text)
        result += [f"~{axis.group(1)}", f"+{text}"] if axis else [text]
    return result


def _first_line(error: BaseException) -> str:
    return str(error).strip().splitlines()[0].strip()


def _malformed(error: YAMLError | UnicodeDecodeError) -> str:
    """File, line and what is wrong there, as far as the parser says."""
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        return f"configuration: expected YAML, found {' '.join(str(error).split())}"
    where = f"{error.problem_mark.name}, line {error.problem_mark.line + 1}"
    return f"{where}: expected YAML, found an error: {error.problem}"


def _explain(error: HydraException, overrides: Sequence[str], conf: Path) -> str:
    """One line for a Hydra error, with the nearest known key."""
    if unknown_key := re.search(r"Could not override '([^']+)'", str(error)):
        return _unknown(unknown_key.group(1), getattr(error.__cause__, "full_key", ""), conf)
    unknown_option = re.search(r"Could not find '([^']+)'", str(error))
    if unknown_option:
        group, _, name = unknown_option.group(1).rpartition("/")
        options = sorted(path.stem for path in (conf / group).glob("*.yaml"))
        return f"unknown option {group}={name}, expected one of: {', '.join(options) or 'none'}"
    merged = re.search(r"Error merging override ([^=]+)=(.*)", str(error))
    if merged:
        key, found = merged.groups()
        below = [
            name for name in _keys(compose_untyped([], conf)) if name.rpartition(".")[0] == key
        ]
        return f"{key}: expected values of {', '.join(below)}, found {found}"
    broken = [text for text in overrides if text in str(error)]
    where = f" in override '{broken[0]}'" if broken else ""
    return f"{_first_line(error)}{where} (expected key=value, lists without spaces)"


def _unknown(key: str, below: str, conf: Path) -> str:
    """Line about a key that the configuration lacks, with the nearest one.

    Where there is the key, as that of ``key={…}``, it lacks the one ``below``.
    """
    group, keys = key.partition(".")[0], _keys(compose_untyped([], conf))
    defaults = (conf / "config.yaml").read_text(encoding="utf-8")
    if re.search(rf"^\s*- {re.escape(group)}: null\b", defaults, re.MULTILINE):
        choices = [f"{group}={path.stem}" for path in sorted((conf / group).glob("*.yaml"))]
        return f"{key}: expected {' or '.join(choices)} beside it, found none"
    key = below if key in keys else key
    parent, new = key, ""
    while parent and parent not in keys:
        parent = parent.rpartition(".")[0]
    if parent and kind_at(Config, parent.split(".")).name.endswith(BY_NAME):
        keys = [name for name in keys if name.startswith(f"{parent}.")]
        new = " A new name needs a + in front."
    same_leaf = [name for name in keys if name.rpartition(".")[2] == key.rpartition(".")[2]]
    nearest = difflib.get_close_matches(key, keys, n=1, cutoff=0.6) or same_leaf[:1]
    hint = f", did you mean '{nearest[0]}'?" if nearest else "." if new else ""
    return f"unknown configuration key '{key}'{hint}{new}"


def _keys(node: Any, prefix: str = "") -> list[str]:
    """Dotted names of all groups and values."""
    keys = []
    for name, value in node.items():
        keys.append(f"{prefix}{name}")
        if isinstance(value, dict):
            keys += _keys(value, f"{prefix}{name}.")
    return keys
