"""``slider results``: fill the result blocks of the documentation from ``reports/``."""

import argparse
import sys
from pathlib import Path

from slider.artefacts.store import ARTEFACTS, Store
from slider.core import files
from slider.core.errors import UserError
from slider.reports.results import blocks
from slider.reports.results.blocks import Block
from slider.reports.results.origin import line, made
from slider.reports.results.tables import TABLES, Unmade

REPORTS = "reports"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("pages", type=Path, nargs="*", help="default: README.md and docs/")
    for name, default in (("reports", REPORTS), ("artefacts", ARTEFACTS)):
        parser.add_argument(
            f"--{name}", type=Path, default=Path(default), help=f"folder (default: {default})"
        )


def run(arguments: argparse.Namespace) -> None:
    """Fill each block whose report is there; say on stderr which reports are missing."""
    pages = arguments.pages or [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]
    texts = {page: page.read_text(encoding="utf-8") for page in pages}
    found = {page: _blocks(page, text) for page, text in texts.items()}
    _check(found)
    filling = _Filling(arguments.reports, Store(arguments.artefacts))
    for page, text in texts.items():
        bodies = {block: filling.body(block) for block in found[page]}
        known = {block: body for block, body in bodies.items() if body is not None}
        filled = blocks.fill(text, known)
        if filled != text:
            files.write_atomic(page, filled)
            print(f"{page} is filled")


def _blocks(page: Path, text: str) -> list[Block]:
    try:
        return blocks.find(text)
    except UserError as error:
        raise UserError(f"{page}, {error}") from None


def _check(found: dict[Path, list[Block]]) -> None:
    """Refuse unknown names before anything is written."""
    for page, name in ((page, block.name) for page, of_it in found.items() for block in of_it):
        if name not in TABLES:
            known = ", ".join(TABLES)
            raise UserError(f"{page}: expected a result block of {known}, found '{name}'")


class _Filling:
    """Bodies of blocks; each is made once, however many pages have it."""

    def __init__(self, reports: Path, store: Store) -> None:
        self._reports, self._store = reports, store
        self._made: dict[str, tuple[str, str, bool] | None] = {}

    def body(self, block: Block) -> str | None:
        """New body of a block, or nothing where it stays as it is."""
        if block.name not in self._made:
            self._made[block.name] = self._make(block.name)
        made_now = self._made[block.name]
        if made_now is None:
            return None
        text, origin, stored = made_now
        same = not stored and block.body.startswith(f"{text}\n\n")
        return None if same and not block.edited else f"{text}\n\n{origin}"

    def _make(self, name: str) -> tuple[str, str, bool] | None:
        table = TABLES[name]
        report = self._reports / table.report
        try:
            if not report.is_file():
                raise Unmade(f"{report} is missing")
            origin = made(report, self._store)
            text = table.make(report, self._store)
        except Unmade as error:
            print(
                f"slider results: {name} stays as it is, {error}: {table.command}",
                file=sys.stderr,
            )
            return None
        except KeyError as error:
            raise UserError(
                f"expected a column {error} in {report}, found none: it is of another version"
            ) from None
        return text, line(report, table.command, origin), origin is not None
