"""Reference of the configuration: what the value of every key may be, its default and meaning.

All is read from the types of the schema, for error messages, ``slider config --keys`` and the page
of the documentation.
"""

import ast
import fnmatch
import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import lru_cache
from itertools import pairwise
from textwrap import dedent
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic.fields import FieldInfo

from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.config.types import Rule, Unit
from slider.core.errors import UserError

OPTIONAL = ("finetuning=robust",)  # groups that the default configuration does not have
HEADER = ("key", "type", "unit", "bound", "default", "meaning")
BY_NAME = "values by name"  # which the configuration chooses
_NAMES = {float: "number", int: "integer", bool: "true or false", str: "text", NoneType: "null"}
_ARTICLES = {"number": "a ", "integer": "an ", "list": "a "}
_LINEAR = "slide"  # the joint that moves along a line: its unit comes after a bar


@dataclass(frozen=True)
class Kind:
    """What a value may be.

    Attributes:
        name: such as ``number`` or ``list of integers``.
        interval: of its numbers; empty for any.
        rules: what else holds, such as ``each once``.
        unit: of its numbers; ``-`` for shares and factors, empty where there is none.
    """

    name: str
    interval: str = ""
    rules: tuple[str, ...] = ()
    unit: str = ""

    @property
    def bound(self) -> str:
        """Interval and rules."""
        return ", ".join(filter(None, (self.interval, *self.rules)))

    def __str__(self) -> str:
        name = _ARTICLES.get(self.name.partition(" ")[0], "") + self.name
        unit = "" if self.unit in ("", "-") else f" {self.unit}"
        within = f" in {self.interval}{unit}" if self.interval else ""
        return ", ".join((f"{name}{within}", *self.rules))


def kind_at(hint: Any, place: Sequence[str | int]) -> Kind:
    """Kind of the value at a place below a value of type ``hint``."""
    for part in place:
        hint = child(hint, part)
    result = kind(hint)
    turning, _, linear = result.unit.partition("|")
    return replace(result, unit=(linear or turning if _LINEAR in place else turning).strip())


def child(hint: Any, part: str | int) -> Any:
    """Type of an item of a value of type ``hint``; Any where it has no such item."""
    for option in _options(hint):
        origin, arguments = get_origin(option) or option, get_args(option)
        if is_dataclass(origin) and part in {item.name for item in fields(origin)}:
            return _fields(option)[part]
        if origin is dict:
            return arguments[1]
        if origin is list and isinstance(part, int):
            return arguments[0]
        if origin is tuple and isinstance(part, int):
            return arguments[part]
    return Any


def meaning(cls: Any, name: str) -> str:
    """Text under a field in the schema, in its class or in the one that it inherits from."""
    texts = (_meanings(base).get(name) for base in cls.__mro__ if is_dataclass(base))
    return next(filter(None, texts), "")


@lru_cache
def _meanings(cls: type) -> dict[str, str]:
    """Docstrings of the fields that a class adds; pydantic would read them in every job."""
    (tree,) = ast.parse(dedent(inspect.getsource(cls))).body
    assert isinstance(tree, ast.ClassDef)
    return {
        field.target.id: " ".join(text.value.value.split())
        for field, text in pairwise(tree.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }


def kind(hint: Any) -> Kind:
    """What values of a type may be; of a union, the last one, and the others as rules."""
    if get_origin(hint) in (Union, UnionType):
        *others, main = sorted(get_args(hint), key=lambda option: option is not NoneType)
        result = kind(main)
        return replace(result, rules=(*result.rules, *(f"or {kind(item).name}" for item in others)))
    if get_origin(hint) is not Annotated:
        return _plain(hint)
    inner, *metadata = get_args(hint)
    plain, facts = _plain(inner), list(_facts(metadata))
    rules = [fact.text for fact in facts if isinstance(fact, Rule)]
    name = plain.name
    if any(getattr(fact, "min_length", 0) for fact in facts) and inner is not str:
        start = "list of " if name.startswith("list of ") else ""
        name = f"{start}one or more {name.removeprefix(start)}"
    units = [plain.unit, *(fact for fact in facts if isinstance(fact, Unit))]
    interval = _interval(facts) or plain.interval
    return Kind(name, interval, (*plain.rules, *rules), units[-1])


def _plain(hint: Any) -> Kind:
    """Kind of a type without metadata of its own."""
    origin, arguments = get_origin(hint) or hint, get_args(hint)
    if origin is Literal:
        return Kind(f"one of {', '.join(map(str, arguments))}")
    if origin is list:
        item = kind(arguments[0])
        plural = f"{item.name}s" if item.name in _NAMES.values() else item.name
        return replace(item, name=f"list of {plural.removeprefix('one of ')}")
    if origin is tuple:
        items = [kind(argument) for argument in arguments]
        units = ", ".join(dict.fromkeys(item.unit for item in items))
        return replace(items[0], name=f"{len(items)} {items[0].name}s", unit=units)
    if origin is dict:
        return Kind(BY_NAME)
    if is_dataclass(origin):
        return Kind(f"values of {', '.join(item.name for item in fields(origin))}")
    return Kind(_NAMES.get(origin, "value"))


def _interval(facts: Sequence[Any]) -> str:
    """Such as ``(0, 1]``; the tightest bounds count."""
    lower = [(fact.ge, False) for fact in facts if hasattr(fact, "ge")]
    lower += [(fact.gt, True) for fact in facts if hasattr(fact, "gt")]
    upper = [(fact.le, True) for fact in facts if hasattr(fact, "le")]
    upper += [(fact.lt, False) for fact in facts if hasattr(fact, "lt")]
    if not lower or not upper:
        return ""
    (least, above), (most, below) = max(lower), min(upper)
    return f"{'(' if above else '['}{_digits(least)}, {_digits(most)}{']' if below else ')'}"


def _digits(value: float) -> str:
    short = f"{value:g}".replace("e+0", "e").replace("e+", "e")
    return short if float(short) == value else str(value)


def _facts(metadata: Sequence[Any]) -> Iterator[Any]:
    for item in metadata:
        yield from item.metadata if isinstance(item, FieldInfo) else [item]


def _options(hint: Any) -> Iterator[Any]:
    """A type without its metadata; of a union each of its types."""
    if get_origin(hint) is Annotated:
        yield from _options(get_args(hint)[0])
    elif get_origin(hint) in (Union, UnionType):
        for option in get_args(hint):
            yield from _options(option)
    else:
        yield hint


def _fields(hint: Any) -> dict[str, Any]:
    """Types of a dataclass's fields, with the parameters of a generic one put in."""
    origin = get_origin(hint) or hint
    parameters = getattr(origin, "__parameters__", ())
    chosen: dict[Any, Any] = dict(zip(parameters, get_args(hint), strict=True))
    hints = _hints(origin).items()
    return {name: chosen[t] if isinstance(t, TypeVar) else t for name, t in hints}


@lru_cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)


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
    keys = (entry for entry in _entries(Config, config, (), "") if entry.default != "{}")
    return [replace(entry, kind=kinds.get(entry.path, entry.kind)) for entry in keys]


def matching(items: list[Entry], pattern: str) -> list[Entry]:
    """Entries at or below a key, or whose key matches a pattern such as ``*.ppo.*``.

    Raises:
        UserError: there is none.
    """
    chosen = [
        item
        for item in items
        if f"{item.path}.".startswith(f"{pattern}.") or fnmatch.fnmatch(item.path, pattern)
    ]
    if not chosen and pattern:
        raise UserError(f"expected a key, or a pattern such as *.ppo.*, found {pattern}")
    return chosen or items


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
    items = entries(config, kinds)
    for item in fields(Config):
        value = getattr(config, item.name)
        about = _first_line(value) if _is_group(value) or isinstance(value, dict) else ""
        lines += [f"## {item.name}", "", *([about, ""] if about else [])]
        lines += [f"| {' | '.join(HEADER)} |", "|---" * len(HEADER) + "|"]
        for entry in matching(items, item.name):
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
