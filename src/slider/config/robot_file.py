"""``robot=PATH``: a robot from a YAML file outside ``conf/``, as an option of Hydra's.

The file may build on one of ``conf/robot`` by ``defaults: [slider, _self_]``. Tags are optional. A
value that the file types has no other tag than the file's.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from hydra.core.config_store import ConfigStore
from omegaconf import OmegaConf

from slider.config.parameters import tag
from slider.core.errors import UserError, require
from slider.core.files import flatten

_PATH = re.compile(r"robot=(.*/.*|.*\.ya?ml)")
_OPTION = "outside"


def store_robot(overrides: Sequence[str], conf: Path) -> list[str]:
    """The overrides with an option in the place of a path; its values are those of the file.

    Raises:
        UserError: there is no such file, it cannot be read or it is no robot's.
    """
    result = []
    for text in overrides:
        if path := _PATH.fullmatch(text):
            node = _read(Path(path.group(1)).expanduser())
            _check_defaults(text, node.get("defaults", []), conf)
            ConfigStore.instance().store(_OPTION, node, group="robot")
            text = f"robot={_OPTION}"
        result.append(text)
    return result


def _read(path: Path) -> dict[str, Any]:
    """Content of the file, with a tag for each of its values; null where the file gives none."""
    try:
        content = OmegaConf.to_container(OmegaConf.load(path))
    except (OSError, UnicodeDecodeError) as error:
        found = getattr(error, "strerror", None) or error
        raise UserError(f"robot={path}: expected a YAML file, found: {found}") from None
    require(isinstance(content, dict), f"robot={path}", "keys and values", type(content).__name__)
    node = cast(dict[str, Any], content)
    require("name" in node, f"robot={path}", "the robot's name as `name`", "none")
    tags = node.get("provenance") or {}
    require(isinstance(tags, dict), "robot.provenance", "a tag per dotted key", tags)
    typed = flatten({k: v for k, v in node.items() if k not in ("defaults", "name", "provenance")})
    return node | {"provenance": tags | {key: tag(tags, key) or None for key in typed}}


def _check_defaults(option: str, defaults: Any, conf: Path) -> None:
    """The file may change robots of ``conf/robot``, and they not the file."""
    names = sorted(path.stem for path in (conf / "robot").glob("*.yaml"))
    possible = isinstance(defaults, list) and all(
        name in names or (name == "_self_" and place == len(defaults) - 1)
        for place, name in enumerate(defaults)
    )
    require(possible, f"{option}: defaults", f"[{', '.join(names)}, _self_]", defaults)
