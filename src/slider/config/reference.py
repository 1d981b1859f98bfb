"""Reference of the configuration: type, unit, bound, default and meaning of every key.

Generated from the types of the schema, for ``slider config``, the documentation and editors.
"""

import ast
import fnmatch
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from functools import lru_cache
from itertools import pairwise
from textwrap import dedent
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.errors import UserError

OPTIONAL = ("finetuning=robust",)  # groups that the default configuration does not have
_NAMES = {
    **{"number": "number", "integer": "integer", "boolean": "true or false"},
    **{"string": "text", "null": "null", "object": "values by name"},
}
_LOWER, _UPPER = ("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")
_OTHERS = "additionalProperties"
_LINEAR = "slide"  # the prismatic joint, which has the unit after the bar
_INTRODUCTION = f"""\
# Configuration reference

Generated from the types of the schema. Defaults are those of `experiment=default`, and of \
`{" ".join(OPTIONAL)}`; override any of them with `--config hydra='key=value key=value'`. \
`slider config --keys train.walking.ppo` prints a part of it.
"""


class Kind(NamedTuple):
    """Type, unit and bound of a value, such as ``number``, ``rad`` and ``(0, 1], each once``."""

    name: str
    unit: str
    bound: str


class Entry(NamedTuple):
    """One key: dotted path; type, unit and bound of its value; default as text; meaning."""

    key: str
    type: str
    unit: str
    bound: str
    default: str
    meaning: str


def entries(config: Config, parameters: Mapping[str, Any]) -> list[Entry]:
    """Entries of all keys, in their order; ``parameters`` holds types of the terms' parameters."""
    nodes = {path: _schema(hint) for path, hint in parameters.items()}
    return list(_entries(config, _schema(Config), "", "", nodes))


def matching(items: list[Entry], pattern: str) -> list[Entry]:
    """Entries at or below a key, or whose key matches a pattern such as ``*.ppo.*``.

    Raises:
        UserError: no key matches.
    """
    chosen = [
        item
        for item in items
        if f"{item.key}.".startswith(f"{pattern}.") or fnmatch.fnmatch(item.key, pattern)
    ]
    if not chosen and pattern:
        raise UserError(f"expected a key, or a pattern such as *.ppo.*, found {pattern}")
    return chosen or items


def page(config: Config, parameters: Mapping[str, Any]) -> str:
    """Markdown page with one table per group of a configuration."""
    lines, items = [_INTRODUCTION], entries(config, parameters)
    for name, value in vars(config).items():
        lines += [f"## {name}", ""]
        if is_dataclass(value) or isinstance(value, dict):
            lines += [_first_line(value), ""]
        lines += [f"| {' | '.join(Entry._fields)} |", "|---" * len(Entry._fields) + "|"]
        for key, *middle, default, text in matching(items, name):
            cells = (f"`{key}`", *middle, f"`{default}`", text)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def editor_schema(key: str) -> dict[str, Any]:
    """JSON schema of the YAML files of a group, such as ``gait``, or of the root for an empty key.

    A file may omit values, refer to others by ``${...}`` and have a defaults list.

    Raises:
        UserError: there is no such group.
    """
    node = _schema(Config)
    for name in filter(None, key.split(".")):
        found = (o.get("properties", {}).get(name) or o.get(_OTHERS) for o in _options(node))
        node = next(filter(None, found), {})
    if not any("properties" in option for option in _options(node)):
        raise UserError(f"expected a key with values below it, such as gait, found {key}")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_partial(node)}


def _partial(node: Any) -> Any:
    if isinstance(node, list):
        return [_partial(item) for item in node]
    if not isinstance(node, dict):
        return node
    node = {name: _partial(value) for name, value in node.items() if name != "required"}
    node |= {"anyOf": node.pop("oneOf")} if "oneOf" in node else {}  # no discriminator
    if node.get("type") == "object" and "properties" in node:
        node["properties"] = {"defaults": {"type": "array"}} | node["properties"]
    simple = isinstance(node.get("type"), str) and node["type"] not in ("string", "null")
    expression = {"type": "string", "pattern": r"\$\{"}
    return {"anyOf": [node, expression]} if simple or "enum" in node else node


def meaning(cls: Any, name: str) -> str:
    """Docstring of a field, from its class or from a base class."""
    texts = (_meanings(base).get(name) for base in cls.__mro__ if is_dataclass(base))
    return next(filter(None, texts), "")


@lru_cache
def _meanings(cls: type) -> dict[str, str]:
    """Docstrings of the fields that a class adds; reading by pydantic would slow every job."""
    (tree,) = ast.parse(dedent(inspect.getsource(cls))).body
    assert isinstance(tree, ast.ClassDef)
    texts = {}
    for statements in pairwise(tree.body):
        match statements:
            case ast.AnnAssign(ast.Name(name)), ast.Expr(ast.Constant(str(text))):
                texts[name] = " ".join(text.split())
    return texts


@lru_cache
def _schema(hint: Any) -> dict[str, Any]:
    """JSON schema of a type, with references replaced by their definitions."""
    schema = TypeAdapter(hint).json_schema()
    definitions = schema.pop("$defs", {})

    def expand(node: Any) -> Any:
        if isinstance(node, list):
            return [expand(item) for item in node]
        if not isinstance(node, dict):
            return node
        if "$ref" in node:
            node = definitions[node["$ref"].rpartition("/")[2]] | node
        return {name: expand(value) for name, value in node.items() if name != "$ref"}

    return expand(schema)


def _options(node: dict[str, Any]) -> list[dict[str, Any]]:
    """Types of a union, null first; else the node alone."""
    options = node.get("anyOf") or node.get("oneOf") or [node]
    return sorted(options, key=lambda option: option.get("type") != "null")


def _kind(node: dict[str, Any]) -> Kind:
    """Kind of a node; for a union that of its last type, with the others as rules."""
    *others, main = _options(node)
    rules = list(dict.fromkeys(part["rule"] for part in (main, node) if "rule" in part))
    rules += [f"or {_kind(other).name}" for other in others]
    unit = main.get("unit", "")
    if "prefixItems" in main:
        items = [_kind(item) for item in main["prefixItems"]]
        name, interval = f"{len(items)} {items[0].name}s", items[0].bound
        unit = ", ".join(dict.fromkeys(item.unit for item in items))
    elif "items" in main:
        item, unit, interval = _kind(main["items"])
        plural = item.removeprefix("one of ") + "s" * (item in _NAMES.values())
        name = "list of " + "one or more " * ("minItems" in main) + plural
    else:
        name, interval = _name(main), _interval(main)
    return Kind(name, unit, ", ".join(filter(None, (interval, *rules))))


def _name(node: dict[str, Any]) -> str:
    if "enum" in node or "const" in node:
        return f"one of {', '.join(map(str, node.get('enum') or [node['const']]))}"
    if "properties" in node:
        return f"values of {', '.join(node['properties'])}"
    return _NAMES.get(node.get("type", ""), "value")


def _interval(node: dict[str, Any]) -> str:
    """Interval such as ``(0, 1]``, from the tightest bounds."""
    lower = [(node[name], name != "minimum") for name in _LOWER if name in node]
    upper = [(node[name], name == "maximum") for name in _UPPER if name in node]
    if not lower or not upper:
        return ""
    (least, open_below), (most, closed) = max(lower), min(upper)
    left, right = "(" if open_below else "[", "]" if closed else ")"
    return f"{left}{least:g}, {most:g}{right}"


def _entries(
    value: Any, node: dict[str, Any], path: str, text: str, parameters: Mapping[str, Any]
) -> Iterator[Entry]:
    """Entries of all keys at or below a path.

    A key without a docstring inherits the meaning of its group. The empty parameters of a term have
    no entry.
    """
    group = is_dataclass(value)
    if not group and not (isinstance(value, dict) and value):
        if value != {}:
            name, unit, bound = _kind(parameters.get(path, node))
            turning, _, linear = unit.partition("|")
            unit = (linear or turning if _LINEAR in path.split(".") else turning).strip()
            items = value if isinstance(value, list) else []
            default = str([to_dict(x) if is_dataclass(x) else x for x in items] or value)
            default = default if len(default) <= 90 else default[:87] + "…"
            yield Entry(path, name, unit, bound, default, text)
        return
    own = type(value).__name__  # in a union, the type that the value has
    for name, item in (vars(value) if group else value).items():
        below = (meaning(type(value), name) if group else "") or text
        if group and not below and not isinstance(item, dict) and not is_dataclass(item):
            below = _first_line(value)
        child = next(
            found
            for option in sorted(_options(node), key=lambda o: o.get("title") != own)
            if (found := option.get("properties", {}).get(name) or option.get(_OTHERS))
        )
        yield from _entries(item, child, f"{path}.{name}".lstrip("."), below, parameters)


def _first_line(group: Any) -> str:
    """First line of the docstring of a group, or of the first group in a dictionary."""
    some = next(iter(group.values())) if isinstance(group, dict) else group
    return (type(some).__doc__ or "").strip().splitlines()[0]
