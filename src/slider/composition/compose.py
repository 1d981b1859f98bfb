"""Compose ``conf/`` with Hydra overrides into a typed, validated :class:`Config`.

Defaults may scale with the robot: ``${by_leg:0.4}`` is 0.4 for SLIDER and proportional to leg
length for others. Times and speeds scale with the square root of leg length, since walks of equal
Froude number v²/(g l) are similar. A plain number instead of the expression is not scaled.
"""

import difflib
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any, cast

from hydra import compose as hydra_compose
from hydra import initialize_config_dir
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import HydraException, MissingConfigException
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from slider.composition.robot_file import malformed, store_robot, without_absent
from slider.config.convert import from_dict, to_dict
from slider.config.robot import leg_scale
from slider.config.schema import Config
from slider.config.validation import validate
from slider.core.errors import UserError, require
from slider.core.files import flatten

_MOST_STEPS = 1000  # maximum length of a list from start to stop
_HALF_WIDTH, _MASS = 0.1, 12.5248  # half the distance of SLIDER's pitch axes [m]; its mass [kg]
_FOLDERS = {"control": "control", "protocols": "evaluation", "study": "study"}
"""Group that contains all files of a folder → that folder."""
_CHOICES = ("base", "default", "development")
"""Files that are not members of such a group: a base, and choices for Table 1's protocol."""
_ALL = re.compile(rf"\W*({'|'.join(_FOLDERS)})(=|$)(?!all$)")
_HYDRA = re.compile(r"\W*hydra(\W|$)")
_LIST_FOR_AXIS = re.compile(r"(gait\.grid\.v[xy])=\[")


def compose(overrides: Sequence[str], conf: Path) -> Config:
    """Resolve ``conf/config.yaml`` with Hydra overrides such as ``gait.grid.vx.stop=0.6``.

    Raises:
        UserError: an unknown key or group, a wrong type or an impossible value.
    """
    config = from_dict(Config, compose_untyped(overrides, conf))
    validate(config)
    return config


@contextmanager
def _hydra_of(conf: Path) -> Iterator[None]:
    """Hydra initialised with a folder; afterwards the caller's instance is active again."""
    caller = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        with initialize_config_dir(str(conf.resolve()), version_base="1.3"):
            yield
    finally:
        GlobalHydra.instance().hydra = caller


def compose_untyped(overrides: Sequence[str], conf: Path) -> dict[str, Any]:
    """Resolve ``conf/config.yaml`` without validation; takes half a second.

    Raises:
        UserError: an unknown key or group, or files or overrides that cannot be read.
    """
    if not (conf / "config.yaml").is_file():
        raise UserError(f"expected the configuration folder with config.yaml, found none at {conf}")
    _check_groups(overrides)
    for group, folder in _FOLDERS.items():
        _store_all(conf, group, folder)
    with _hydra_of(conf):
        try:
            options = []
            for text in store_robot(overrides, conf):
                # Hydra cannot replace start, stop and step by a list: delete them first.
                axis = _LIST_FOR_AXIS.match(text)
                options += [f"~{axis[1]}", f"+{text}"] if axis else [text]
            config = hydra_compose("config", overrides=options)
            values = cast(dict[str, Any], OmegaConf.to_container(config, resolve=True))
            without_absent(values.get("robot"))
            if isinstance(spaces := (values.get("tuning") or {}).get("spaces"), dict):
                spaces |= {name: _dotted(space) for name, space in spaces.items()}
            return values
        except HydraException as error:
            raise UserError(_explain(error, overrides, conf)) from None
        except OmegaConfBaseException as error:
            raise UserError(_first_line(error)) from None
        except (YAMLError, UnicodeDecodeError) as error:
            raise UserError(malformed(error)) from None
        except (TypeError, ValueError, AttributeError):  # of Hydra, for overrides like group=[1]
            raise UserError(f"cannot read the overrides: {' '.join(overrides)}") from None


def _dotted(space: Any) -> Any:
    """Search ranges by dotted names of settings; overrides define them as nested values."""
    if not isinstance(space, dict):
        return space
    ranges: dict[str, Any] = {}
    for name, item in space.items():
        nested = isinstance(item, dict) and item and all(isinstance(x, dict) for x in item.values())
        for below, bounds in (_dotted(item) if nested else {"": item}).items():
            key = f"{name}.{below}".rstrip(".")
            both = isinstance(bounds, dict) and isinstance(ranges.get(key), dict)
            ranges[key] = ranges[key] | bounds if both else bounds
    return ranges


# Values of other types are returned unchanged: the schema reports the key and the expected type.
def _steps(start: float, stop: Any, step: float) -> list[Any]:
    """Numbers from start to stop, including ``stop`` if a step reaches it."""
    if not isinstance(stop, int | float) or not start <= stop <= start + _MOST_STEPS * step:
        return [stop]
    count = int((stop - start) / step + 1e-9) + 1
    return [round(start + index * step, 9) for index in range(count)]


def _joined(*lists: Any) -> list[Any]:
    listed = [values if isinstance(values, list | ListConfig) else [values] for values in lists]
    return [value for values in listed for value in values]


def _register_scale(name: str, scale: Callable[[Any], float]) -> None:
    """Resolve ``${name:value}`` to the value times a scale of the robot."""

    def resolve(value: float, *, _root_: DictConfig) -> float:
        try:
            factor = round(scale(_root_.robot), 12)  # removes rounding errors of a sum of masses
            return value * factor if factor > 0.0 else value
        except (OmegaConfBaseException, TypeError, AttributeError, ZeroDivisionError):
            return value  # the schema reports the error in the robot's value first

    OmegaConf.register_new_resolver(name, resolve, replace=True)


def _mass(robot: Any) -> float:
    """Mass of the base and of two legs [kg]."""
    links = {name: link.mass for name, link in robot.links.items() if link is not None}
    return sum(mass * (1 if name == "base" else 2) for name, mass in links.items())


def _slide_or_knee(slide: float, knee: float, *, _root_: DictConfig) -> float:
    """The first value for a sliding leg, the second for a leg with a knee."""
    try:
        return slide if _root_.robot.geometry.get("knee") is None else knee
    except (OmegaConfBaseException, AttributeError):
        return slide  # as in _register_scale


OmegaConf.register_new_resolver("slide_or_knee", _slide_or_knee, replace=True)
OmegaConf.register_new_resolver("steps", _steps, replace=True)
OmegaConf.register_new_resolver("joined", _joined, replace=True)
_register_scale("by_leg", lambda robot: leg_scale(robot.geometry.leg_length))
_register_scale("by_area", lambda robot: leg_scale(robot.geometry.leg_length) ** 2)
_register_scale("by_time", lambda robot: leg_scale(robot.geometry.leg_length) ** 0.5)
_register_scale("by_speed", lambda robot: leg_scale(robot.geometry.leg_length) ** 0.5)
_register_scale("by_rate", lambda robot: leg_scale(robot.geometry.leg_length) ** -0.5)
_register_scale(
    "by_hip", lambda robot: sum(place[1] for place in robot.geometry.axes.values()) / _HALF_WIDTH
)
_register_scale("by_weight", lambda robot: _mass(robot) / _MASS)


def _check_groups(overrides: Sequence[str]) -> None:
    """Reject keys of Hydra itself, and selections of controllers, protocols and studies.

    The configuration always has all of these; protocols and targets select among them.
    """
    for text in overrides:
        if _HYDRA.match(text):
            raise UserError(f"hydra: expected keys of conf/, found {text}, which has no effect")
        if group := _ALL.match(text):
            chooses = "; evaluation.controllers chooses controllers" * (group[1] == "control")
            choice = text.partition("=")[2] or text
            raise UserError(f"{group[1]}: expected all{chooses}, found {choice}")


def _store_all(conf: Path, group: str, folder: str) -> None:
    """Define the option ``GROUP=all``, with each file of ``conf/FOLDER`` under its own name."""
    names = [name for name in _stems(conf / folder) if name not in _CHOICES]
    for name in names:
        key, fits = f"{conf / folder}/{name}.yaml", name != "all" and "." not in name
        require(fits, key, "small letters, digits and _ after a letter, and not all", name)
    defaults = [{f"/{folder}@{name}": name} for name in names]
    ConfigStore.instance().store("all", {"defaults": defaults}, group=group)


def _first_line(error: BaseException) -> str:
    return str(error).strip().splitlines()[0].strip()


def _explain(error: HydraException, overrides: Sequence[str], conf: Path) -> str:
    """One line for a Hydra error, with the nearest known key."""
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        group, _, name = error.missing_cfg_file.rpartition("/")
        options = ", ".join(error.options or ()) or "none"
        return f"unknown option {group}={name}, expected one of: {options}"
    if match := re.search(r"Could not override '([^']+)'", str(error)):
        return _unknown(max(match[1], getattr(error.__cause__, "full_key", ""), key=len), conf)
    if match := re.search(r"Error merging override ([^=]+)=(.*)", str(error)):
        return f"{match[1]}: expected keys and values, found {match[2]}"
    broken = [text for text in overrides if text in str(error)]
    where = f" in override '{broken[0]}'" if broken else ""
    return f"{_first_line(error)}{where} (expected key=value, lists without spaces)"


def _unknown(key: str, conf: Path) -> str:
    """Message about a key that the configuration lacks, with the nearest known key."""
    group, leaf = key.partition(".")[0], key.rpartition(".")[2]
    node: Any = compose([], conf)
    keys, place = [*flatten(to_dict(node))], ""
    if getattr(node, group, node) is None:
        choices = " or ".join(f"{group}={name}" for name in _stems(conf / group))
        return f"{key}: expected {choices} beside it, found none"
    for part in key.split("."):
        items = node if isinstance(node, dict) else vars(node) if is_dataclass(node) else {}
        if part not in items:
            break
        node, place = items[part], f"{place}{part}."
    if key in keys:
        return f"expected +{key}, found {key}: its default is not in a file of {conf.name}/"
    new = isinstance(node, dict)
    keys = [name for name in keys if name.startswith(place)] if new else keys
    same_leaf = [name for name in keys if name.rpartition(".")[2] == leaf]
    nearest = difflib.get_close_matches(key, keys, n=1, cutoff=0.6) or same_leaf[:1]
    hint = f", did you mean '{nearest[0]}'?" if nearest else "." * new
    return f"unknown configuration key '{key}'{hint}" + " A new name needs a + in front." * new


def _stems(folder: Path) -> list[str]:
    return sorted(path.stem for path in folder.glob("*.yaml"))
