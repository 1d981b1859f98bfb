"""Reference of the configuration: every key with type, default and the comment of ``conf/``."""

import dataclasses
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider.config.compose import compose
from slider.config.convert import to_dict
from slider.config.evaluation import EvaluationConfig
from slider.config.schema import Config

_BASES = ("base.yaml", "default.yaml")  # their comments are about the defaults, and win
OPTIONAL = ("finetuning=robust",)  # groups that the default configuration does not have
_LIKE = {  # keys that are explained once
    "train.standing.": "train.walking.",
    "finetuning.": "train.walking.",
    "control.observer.": "control.tuned.",
    "control.literal.": "control.",
    "control.tuned.": "control.",
}


@dataclass(frozen=True)
class Entry:
    """One key: dotted path, type, default as text, comment."""

    path: str
    kind: str
    default: str
    comment: str


def reference(conf: Path) -> str:
    """Markdown page with one table per group of the configuration."""
    config = compose(OPTIONAL, conf)
    comments = read_comments(conf)
    lines = [
        "# Configuration reference",
        "",
        "Generated from the typed schema and the comments of `conf/`. Defaults are those of "
        f"`experiment=default`, and of `{' '.join(OPTIONAL)}`; override any of them with "
        "`--config hydra='key=value key=value'`.",
        "",
    ]
    for item in dataclasses.fields(Config):
        value = getattr(config, item.name)
        kind = EvaluationConfig if item.name == "protocols" else type(value)
        lines += [f"## {item.name}", "", _first_line(kind), ""]
        lines += ["| key | type | default | meaning |", "|---|---|---|---|"]
        for entry in group_entries(value, item.name, comments):
            cells = (f"`{entry.path}`", entry.kind, f"`{entry.default}`", entry.comment)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def group_entries(group: Any, path: str, comments: Mapping[str, str]) -> Iterator[Entry]:
    """Keys of a group: a dataclass, or several of them by name."""
    if isinstance(group, dict):
        for name, node in group.items():
            yield from entries(node, f"{path}.{name}", comments)
    else:
        yield from entries(group, path, comments)


def entries(node: Any, path: str, comments: Mapping[str, str]) -> Iterator[Entry]:
    """Keys below a dataclass of the configuration; other values are one entry each."""
    hints = typing.get_type_hints(type(node))
    for item in dataclasses.fields(node):
        value, key = getattr(node, item.name), f"{path}.{item.name}"
        if dataclasses.is_dataclass(value):
            yield from entries(value, key, comments)
        else:
            yield Entry(key, _kind(hints[item.name]), _text(value), _comment(key, comments))


def read_comments(conf: Path) -> dict[str, str]:
    """Comment of each dotted path in the files of ``conf/`` but the experiments."""
    found: dict[str, str] = {}
    paths = [path for path in conf.rglob("*.yaml") if path.parent.name != "experiment"]
    for path in sorted(paths, key=lambda path: (path.name in _BASES, str(path))):
        prefix = "".join(f"{part}." for part in path.parent.relative_to(conf).parts)
        found |= {f"{prefix}{key}": text for key, text in _file_comments(path)}
    return found


def _file_comments(path: Path) -> Iterator[tuple[str, str]]:
    """(dotted key, comment) of the commented lines of a YAML file."""
    stack: list[tuple[int, str]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        body, hash_, comment = line.partition(" #")
        name, colon, _ = body.strip().partition(":")
        if not colon or name.startswith(("-", "#", "{")):
            continue
        indent = len(line) - len(line.lstrip())
        stack = [(depth, parent) for depth, parent in stack if depth < indent] + [(indent, name)]
        if hash_:
            yield ".".join(parent for _, parent in stack), comment.strip()


def _comment(key: str, comments: Mapping[str, str]) -> str:
    """Own comment, that of the same key elsewhere, or that of the nearest group with one."""
    for prefix, other in _LIKE.items():
        if key.startswith(prefix) and key not in comments:
            key = other + key.removeprefix(prefix)
    parts = key.split(".")
    if parts[0] == "protocols":  # protocols.NAME.key is explained as evaluation.key
        parts = ["evaluation", *parts[2:]]
    elif "disturbance" in parts and key not in comments:  # a training's are an evaluation's
        parts = ["evaluation", *parts[parts.index("disturbance") :]]
    for end in range(len(parts), 1, -1):
        text = comments.get(".".join(parts[:end]))
        if text:
            return text
    return ""


def _kind(hint: Any) -> str:
    return getattr(hint, "__name__", str(hint)) if not typing.get_args(hint) else _generic(hint)


def _generic(hint: Any) -> str:
    inner = ", ".join(_kind(item) for item in typing.get_args(hint) if item is not Ellipsis)
    return f"{getattr(typing.get_origin(hint), '__name__', hint)} of {inner}"


def _text(value: Any) -> str:
    plain = (
        {k: to_dict(v) if dataclasses.is_dataclass(v) else v for k, v in value.items()}
        if (isinstance(value, dict))
        else value
    )
    text = str(plain)
    return text if len(text) <= 90 else text[:87] + "…"


def _first_line(kind: type) -> str:
    return (kind.__doc__ or "").strip().splitlines()[0]
