"""Marked blocks of a Markdown page, as ``<!-- results: NAME -->`` … ``<!-- /results DIGEST -->``.

The digest is that of what stands between the marks, so that an edit by hand shows. A block that
was never filled has none. Marks in fenced code are text.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from slider.core.errors import UserError

_BEGIN = re.compile(r"<!-- results: *(?P<name>\S*) *-->")
_END = re.compile(r"<!-- /results(?: (?P<digest>[0-9a-f]+))?\b.*-->")
_FENCE = re.compile(r" *(```|~~~)")
_DIGITS = 12


@dataclass(frozen=True)
class Block:
    """One marked block of a page.

    Attributes:
        name: which table belongs there.
        body: what stands between the marks, without blank lines around it.
        digest: of the body when it was written; empty where it never was.
        first, last: lines of the two marks, from 0.
    """

    name: str
    body: str
    digest: str
    first: int
    last: int

    @property
    def edited(self) -> bool:
        """Whether the body is another one than the command wrote."""
        return bool(self.digest) and self.digest != digest(self.body)


def digest(body: str) -> str:
    """First digits of the SHA-256 of a block's body."""
    return hashlib.sha256(body.encode()).hexdigest()[:_DIGITS]


def find(text: str) -> list[Block]:
    """Blocks of a page, in order.

    Raises:
        UserError: a mark without its partner.
    """
    lines, found = text.splitlines(), []
    begin: tuple[int, str] | None = None
    for index, line in _outside_code(lines):
        first, last = _BEGIN.fullmatch(line), _END.fullmatch(line)
        if first and begin is None:
            begin = index, first["name"]
        elif last and begin is not None:
            body = "\n".join(lines[begin[0] + 1 : index]).strip("\n")
            found.append(Block(begin[1], body, last["digest"] or "", begin[0], index))
            begin = None
        elif first or last:
            raise UserError(f"line {index + 1}: expected the other mark of a block, found {line}")
    if begin is not None:
        raise UserError(f"line {begin[0] + 1}: expected the end of block {begin[1]}, found none")
    return found


def _outside_code(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Numbered lines, without trailing blanks, that are in no fenced code."""
    fence = ""
    for index, line in enumerate(lines):
        found = _FENCE.match(line)
        if found and fence in ("", found[1]):
            fence = "" if fence else found[1]
        elif not fence:
            yield index, line.rstrip()


def fill(text: str, bodies: Mapping[Block, str]) -> str:
    """The page with new bodies in some of its blocks; the rest stays, byte by byte."""
    lines = text.splitlines(keepends=True)
    for block in sorted(bodies, key=lambda block: block.first, reverse=True):
        body = bodies[block].strip("\n")
        end = f"<!-- /results {digest(body)}: written by make results, not by hand -->\n"
        lines[block.first + 1 : block.last + 1] = ["\n", body + "\n", "\n", end]
    return "".join(lines)
