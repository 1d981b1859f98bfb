"""The documentation's own result blocks, and what stands beside them."""

from pathlib import Path

import pytest

from slider.reports.results.blocks import Block, find
from slider.reports.results.tables import TABLES

ROOT = Path(__file__).parents[3]
DOCS = sorted((ROOT / "docs").rglob("*.md"))
GUIDES = [ROOT / "README.md", *(page for page in DOCS if page.parent.name != "notebook")]
NOTEBOOK = sorted((ROOT / "docs" / "notebook").glob("2*.md"))


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def outside(page: Path) -> str:
    """Text of a page without its result blocks."""
    text = page.read_text()
    lines = text.splitlines()
    for block in reversed(find(text)):
        del lines[block.first : block.last + 1]
    return "\n".join(lines)


def blocks(page: Path) -> list[Block]:
    return find(page.read_text())


@pytest.mark.parametrize("page", GUIDES, ids=name)
def test_blocks_are_as_the_command_wrote_them(page):
    for block in blocks(page):
        assert block.name in TABLES
        assert not block.edited, f"{block.name}: edited by hand, `make results` writes it"
        assert block.digest or "|" not in block.body, f"{block.name}: a table without a digest"


def test_every_table_is_shown_somewhere():
    assert {block.name for page in GUIDES for block in blocks(page)} == set(TABLES)


def test_the_readme_is_short():
    """Its prose, without the table of results."""
    assert len(outside(ROOT / "README.md").split()) <= 700


@pytest.mark.parametrize("page", GUIDES[1:], ids=name)
def test_measurements_of_a_machine_stand_in_blocks_or_in_the_notebook(page):
    assert "AMD EPYC" not in outside(page)


@pytest.mark.parametrize("page", GUIDES[1:], ids=name)
def test_a_page_opens_with_what_its_reader_can_do(page):
    title, empty, first = page.read_text().splitlines()[:3]
    assert title.startswith("# ")
    assert not empty
    assert first.startswith(("After this page you ", "From here you "))


@pytest.mark.parametrize("page", NOTEBOOK, ids=name)
def test_a_page_of_the_notebook_says_of_which_commits_it_is(page):
    assert "up to commit `" in "\n".join(page.read_text().splitlines()[:6])
