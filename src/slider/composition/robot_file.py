"""``robot=PATH``: a robot from a YAML file, or a folder, outside ``conf/``, as a Hydra option.

An installed package may name a path by an entry point of ``slider.robots``: ``robot=NAME``. Names
in ``conf/robot`` take precedence. ``robot=menagerie:NAME`` uses predefined roles for a model of
MuJoCo Menagerie, by its name in the package ``robot_descriptions``.
The file may extend one of ``conf/robot`` by ``defaults: [slider, _self_]``. With ``model`` and
``roles``, links, axes and joints come from a model file, unless the robot file has them. Provenance
tags are optional. Values of the two files have only tags that the robot file assigns.
"""

import json
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from hydra.core.config_store import ConfigStore
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import MarkedYAMLError, YAMLError

from slider.config.parameters import tag
from slider.core.errors import UserError, require
from slider.core.files import flatten

if TYPE_CHECKING:  # planning needs MuJoCo only for robots with a model file
    from slider.robot.model_file import ModelFile

_PATH = re.compile(r"robot=(.*/.*|.*\.ya?ml)")
ENTRY_POINTS = "slider.robots"
"""Group of entry points; each loads the path of a robot's file or folder."""
_OPTION = "outside"
_MENAGERIE = Path(__file__).parent / "menagerie"


def store_robot(overrides: Sequence[str], conf: Path) -> list[str]:
    """The overrides, with the path of a robot replaced by an option that holds the file's values.

    Each value has the tag that the file assigns, else null. The file may override the robot of
    ``conf/robot`` that it extends, not the reverse.

    Raises:
        UserError: the file does not exist, cannot be read or does not describe a robot.
    """
    names = sorted(file.stem for file in (conf / "robot").glob("*.yaml"))
    own = {f"robot={name}" for name in names}
    paths = {text: path for text in overrides if text not in own and (path := _path(text))}
    for text, path in paths.items():
        node, model = read(path)
        require("name" in node, text, "the robot's name as `name`", "none")
        defaults = node.get("defaults", [])
        possible = isinstance(defaults, list) and all(name in names for name in defaults[:-1])
        possible = possible and all(name in (*names, "_self_") for name in defaults[-1:])
        require(possible, f"{text}: defaults", f"[{', '.join(names)}, _self_]", defaults)
        if model:
            node = cast(dict[str, Any], OmegaConf.to_container(OmegaConf.merge(model.values, node)))
        tags = node.get("provenance") or {}
        require(isinstance(tags, dict), "robot.provenance", "a tag per dotted key", tags)
        apart = ("defaults", "name", "provenance")
        typed = flatten({k: v for k, v in node.items() if k not in apart})
        tags |= {key: tag(tags, key) or None for key, value in typed.items() if value is not None}
        ConfigStore.instance().store(_OPTION, node | {"provenance": tags}, group="robot")
    return [f"robot={_OPTION}" if text in paths else text for text in overrides]


def without_absent(robot: Any) -> None:
    """Drop joints that are null, and drives, gains and tags of null parts, such as a capstan.

    They are inherited from the robot that a file extends, since a file cannot delete keys.
    """
    if not isinstance(robot, dict):
        return
    joints = robot.get("joints")
    parts = robot | (joints if isinstance(joints, dict) else {})
    absent = {name for name, value in parts.items() if value is None}
    for name in ("joints", "drives", "gains", "provenance"):
        if isinstance(values := robot.get(name), dict):
            kept = {k: v for k, v in values.items() if absent.isdisjoint(str(k).split("."))}
            robot[name] = kept


def read_option(option: str) -> "tuple[ModelFile | None, set[str] | None]":
    """Content of the model file that a robot file names, if any, and the dotted keys of both files.

    For an option of ``conf/robot``, both are None.
    """
    if (path := _path(f"robot={option}")) is None:
        return None, None
    node, model = read(path)
    given = flatten(model.values) if model else {}
    return model, given.keys() | flatten(node).keys()


def _path(text: str) -> Path | None:
    """Robot file that an override names; for a folder its ``robot.yaml``; None if no path."""
    if text.startswith("robot=menagerie:"):
        names = sorted(file.stem for file in _MENAGERIE.glob("*.yaml"))
        require((name := text.partition(":")[2]) in names, text, " or ".join(names), name)
        return _MENAGERIE / f"{name}.yaml"
    if match := _PATH.fullmatch(text):
        path = Path(match[1]).expanduser()
    elif packaged := [*entry_points(group=ENTRY_POINTS, name=text.removeprefix("robot="))]:
        expected = f"one package with a path of that name in {ENTRY_POINTS}"
        require(len(packaged) == 1, text, expected, ", ".join(one.value for one in packaged))
        try:
            path = Path(packaged[0].load())
        except (ImportError, AttributeError, TypeError) as error:
            raise UserError(f"{text}: expected {expected}, found: {error}") from None
    else:
        return None
    return path / "robot.yaml" if path.is_dir() else path


def _described(name: str) -> Path:
    """Model file of ``robot_descriptions``, which clones MuJoCo Menagerie by git at first use."""
    try:
        with redirect_stdout(sys.stderr):
            return Path(import_module(f"robot_descriptions.{name}_mj_description").MJCF_PATH)
    except Exception as error:  # of git, network or disk, or the package is not installed
        found = " ".join(str(error).split())
        expected = "a model that robot_descriptions (pip install -e '.[menagerie]') can clone"
        raise UserError(f"menagerie:{name}: expected {expected}, found: {found}") from None


def read(path: Path) -> "tuple[dict[str, Any], ModelFile | None]":
    """Values of a robot file other than ``model`` and ``roles``, and content of its model file.

    Raises:
        UserError: a file cannot be read, or does not describe a robot.
    """
    try:
        node = OmegaConf.to_container(OmegaConf.load(path))
        json.dumps(node)
    except (OSError, ValueError, TypeError, AttributeError) as error:
        found = getattr(error, "strerror", None) or error
        raise UserError(f"robot={path}: expected a YAML file, found: {found}") from None
    except (YAMLError, OmegaConfBaseException) as error:
        raise UserError(malformed(error)) from None
    require(isinstance(node, dict), f"robot={path}", "keys and values", type(node).__name__)
    node = cast(dict[str, Any], node)
    file, roles = node.pop("model", None), node.pop("roles", None)
    if file is None and roles is None:
        return node, None
    if path.parent == _MENAGERIE:
        described = _described(path.stem)
    elif isinstance(file, str) and not {"..", "/"} & set(Path(file).parts):
        described = path.parent / file
    else:
        raise UserError(f"robot.model: expected a file beside this one, or below, found {file}")
    from slider.robot.model_file import read_model

    return node, read_model(described, roles, flatten(node))


def malformed(error: Exception) -> str:
    """Message with file, line and error, if the parser reports them."""
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        return f"configuration: expected YAML, found {' '.join(str(error).split())}"
    where = f"{error.problem_mark.name}, line {error.problem_mark.line + 1}"
    return f"{where}: expected YAML, found an error: {error.problem}"
