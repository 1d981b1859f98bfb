"""The readings on the page and those in the documentation are the same."""

from pathlib import Path

from slider.reports.sections.readings import in_effect, read

METHOD = Path(__file__).parents[2] / "docs" / "explanation" / "method.md"


def cells(line: str) -> list[str]:
    # In a table a bar of the text is written with a backslash.
    text = line.strip().strip("|").replace("\\|", "\0").replace("`", "")
    return [cell.strip().replace("\0", "|") for cell in text.split("|")]


def test_page_and_documentation_agree():
    _, _, after = METHOD.read_text().partition("| the paper says |")
    lines = after.splitlines()[2:]
    table = [cells(line) for line in lines if line.startswith("|")]
    assert table
    assert [list(reading.values()) for reading in read()] == table


def test_shows_single_values_only():
    configuration = {"gait": {"cost": "paper", "grid": {"vx": 1}}}
    assert in_effect(configuration, "gait.cost") == "paper"
    assert in_effect(configuration, "gait.grid") == ""
    assert in_effect(configuration, "gait/grid") == ""
