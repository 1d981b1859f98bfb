"""Units of the configuration's numbers, as the comments of ``conf/`` write them."""

import re
from collections.abc import Mapping, Sequence

_PART = re.compile(r"([^\[\],;]*)\[([^\]]+)\]")  # what is measured, then its unit in brackets
_LINEAR = "slide"  # the joint that moves along a line: its units come after a bar


def unit(path: str, siblings: Sequence[str], comments: Mapping[str, str]) -> str:
    """Unit of a number; empty where no comment tells.

    Its own comment says it, or that of the nearest group around it: ``mass [kg], com [m]``. There
    a unit belongs to the number that is named before it; those not named get the rest in order.
    ``[N m | N]`` is for joints that turn, and for the slide.

    Args:
        path: dotted, such as ``robot.links.base.mass``.
        siblings: names in the number's own group, in order, the number's among them.
        comments: by dotted path.
    """
    parts = path.split(".")
    for end in range(len(parts), 0, -1):
        found = _PART.findall(comments.get(".".join(parts[:end]), ""))
        if found:
            text = found[0][1] if end == len(parts) else _of_group(parts[-1], siblings, found)
            turning, _, linear = text.partition("|")
            return (linear or turning if _LINEAR in parts else turning).strip()
    return ""


def _of_group(name: str, siblings: Sequence[str], parts: Sequence[tuple[str, str]]) -> str:
    named = {item: _naming(item, parts) for item in siblings}
    if named[name] is not None:
        return parts[named[name] or 0][1]
    rest = [unit for index, (_, unit) in enumerate(parts) if index not in named.values()]
    if len(rest) == 1:
        return rest[0]
    unnamed = [item for item in siblings if named[item] is None]
    return rest[unnamed.index(name)] if len(rest) == len(unnamed) else ""


def _naming(name: str, parts: Sequence[tuple[str, str]]) -> int | None:
    """Place of the first part whose words have the name."""
    return next((i for i, (text, _) in enumerate(parts) if name in text.split()), None)
