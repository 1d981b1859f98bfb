"""``slider results``: fill the result blocks of the documentation from ``reports/``."""

import argparse
import sys
from functools import cache, partial
from pathlib import Path

from slider.artefacts.current import add_store_argument
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError
from slider.reports.results import blocks
from slider.reports.results.blocks import Block
from slider.reports.results.origin import facts, line, made
from slider.reports.results.tables import TABLES, Unmade


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("pages", type=Path, nargs="*", help="default: README.md and docs/")
    parser.add_argument(
        "--reports", type=Path, default=Path("reports"), help="folder (default: reports)"
    )
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Fill each block whose report is there; say on stderr which reports are missing."""
    pages = arguments.pages or [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]
    for page in pages:
        if not page.is_file():
            raise UserError(f"expected a page at {page}, found none")
    texts = {page: page.read_text(encoding="utf-8") for page in pages}
    found = {page: _blocks(page, text) for page, text in texts.items()}
    make = cache(partial(_make, arguments.reports, Store(arguments.artefacts)))
    for page, text in texts.items():
        bodies = {block: _body(block, make(block.name)) for block in found[page]}
        known = {block: body for block, body in bodies.items() if body is not None}
        filled = blocks.fill(text, known)
        if filled != text:
            files.write_atomic(page, filled)
            print(f"{page} is filled")


def _blocks(page: Path, text: str) -> list[Block]:
    try:
        found = blocks.find(text)
    except UserError as error:
        raise UserError(f"{page}, {error}") from None
    for block in found:
        if block.name not in TABLES:
            known = ", ".join(TABLES)
            raise UserError(f"{page}: expected a result block of {known}, found '{block.name}'")
    return found


def _body(block: Block, made_now: tuple[str, str, bool] | None) -> str | None:
    """New body of a block, or nothing where it stays as it is."""
    if made_now is None:
        return None
    text, origin, stored = made_now
    same = not stored and block.body.startswith(f"{text}\n\n")
    return None if same and not block.edited else f"{text}\n\n{origin}"


def _make(reports: Path, store: Store, name: str) -> tuple[str, str, bool] | None:
    """Table, the line below it, and whether a job of the store made it."""
    table = TABLES[name]
    report = reports / table.report
    try:
        if not report.is_file():
            raise Unmade(f"{report} is missing")
        origin = made(report, store)
        text = table.make(report, store)
    except Unmade as error:
        print(f"slider results: {name} stays as it is, {error}: {table.command}", file=sys.stderr)
        return None
    except KeyError as error:
        raise UserError(
            f"expected a column {error} in {report}, found none: it is of another version"
        ) from None
    noted = None if origin is None else facts(origin, store)
    return text, line(report, table.command, noted), origin is not None
