"""Reference of the configuration: every key with what its value may be, default and meaning."""

import fnmatch
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from slider.config.constraint_text import Kind, child, kind_at, meaning
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.errors import UserError

OPTIONAL = ("finetuning=robust",)  # groups that the default configuration does not have
HEADER = ("key", "type", "unit", "bound", "default", "meaning")


@dataclass(frozen=True)
class Entry:
    """One key: dotted path, what its value may be, default as text, meaning."""

    path: str
    kind: Kind
    default: str
    meaning: str

    @property
    def cells(self) -> tuple[str, ...]:
        """Under ``HEADER``."""
        kind = self.kind
        return (self.path, kind.name, kind.unit, kind.bound, self.default, self.meaning)


def entries(config: Config, kinds: Mapping[str, Kind]) -> list[Entry]:
    """Every key of a configuration, in its order; ``kinds`` of keys about which terms say more.

    The parameters of a term without any are no key.
    """
    found = (entry for entry in _entries(Config, config, (), "") if entry.default != "{}")
    return [replace(entry, kind=kinds.get(entry.path, entry.kind)) for entry in found]


def matching(found: list[Entry], pattern: str) -> list[Entry]:
    """Entries at or below a key, or whose key matches a pattern such as ``*.ppo.*``.

    Raises:
        UserError: there is none.
    """
    chosen = [
        item
        for item in found
        if f"{item.path}.".startswith(f"{pattern}.") or fnmatch.fnmatch(item.path, pattern)
    ]
    if not chosen and pattern:
        raise UserError(f"expected a key, or a pattern such as *.ppo.*, found {pattern}")
    return chosen or found


def page(config: Config, kinds: Mapping[str, Kind]) -> str:
    """Markdown page with one table per group of a configuration."""
    lines = [
        "# Configuration reference",
        "",
        "Generated from the types of the schema. Defaults are those of `experiment=default`, and "
        f"of `{' '.join(OPTIONAL)}`; override any of them with `--config hydra='key=value "
        "key=value'`. `slider config --keys train.walking.ppo` prints a part of it.",
        "",
    ]
    known = entries(config, kinds)
    for item in fields(Config):
        value = getattr(config, item.name)
        about = _first_line(value) if _is_group(value) or isinstance(value, dict) else ""
        lines += [f"## {item.name}", "", *([about, ""] if about else [])]
        lines += [f"| {' | '.join(HEADER)} |", "|---" * len(HEADER) + "|"]
        for entry in matching(known, item.name):
            path, *middle, default, text = entry.cells
            cells = (f"`{path}`", *middle, f"`{default}`", text)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def _entries(hint: Any, value: Any, place: tuple[str, ...], text: str) -> Iterator[Entry]:
    """Keys at or below a place; what has no meaning of its own has that of the group around it."""
    if _is_group(value):
        for name in (item.name for item in fields(value)):
            item = getattr(value, name)
            below = meaning(type(value), name) or text
            if not below and not isinstance(item, dict) and not _is_group(item):
                below = _first_line(value)
            yield from _entries(child(hint, name), item, (*place, name), below)
    elif isinstance(value, dict) and value:
        for name, item in value.items():
            yield from _entries(child(hint, name), item, (*place, name), text)
    else:
        yield Entry(".".join(place), kind_at(Config, place), _text(value), text)


def _is_group(value: Any) -> bool:
    return is_dataclass(value) and not isinstance(value, type)


def _text(value: Any) -> str:
    items = [to_dict(i) if is_dataclass(i) else i for i in value] if isinstance(value, list) else []
    text = str(items or value)
    return text if len(text) <= 90 else text[:87] + "…"


def _first_line(group: Any) -> str:
    """Of the text about a group, or about the first of several by name."""
    some = next(iter(group.values())) if isinstance(group, dict) else group
    return (type(some).__doc__ or "").strip().splitlines()[0]
