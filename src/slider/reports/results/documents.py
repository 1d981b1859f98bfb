"""Parts of reports that are Markdown already: ablation and sensitivity."""

from pathlib import Path

from slider.artefacts.store import Store
from slider.reports.results.unmade import Unmade

_VERDICT, _STRONGEST = "Which guesses carry the result", "The strongest"


def ablation(report: Path, store: Store) -> str:
    """All of the page without title and figure; its headings become bold lines."""
    _title, *rest = report.read_text(encoding="utf-8").splitlines()
    lines = [_bold(line) for line in rest if not line.startswith("![")]
    return _squeezed("\n".join(lines))


def sensitivity(report: Path, store: Store) -> str:
    """The paragraph of the guesses that carry the result, and the strongest parameters."""
    sections = _sections(report.read_text(encoding="utf-8"))
    strongest = next((title for title in sections if title.startswith(_STRONGEST)), None)
    if _VERDICT not in sections or strongest is None:
        raise Unmade(f"{report} has other sections")
    return f"{sections[_VERDICT]}\n\n**{strongest}**\n\n{sections[strongest]}"


def _sections(text: str) -> dict[str, str]:
    """Text below each heading, without pictures."""
    found: dict[str, list[str]] = {"": []}
    for line in text.splitlines():
        if line.startswith("#"):
            found[line.lstrip("# ")] = []
        elif not line.startswith("!["):
            list(found.values())[-1].append(line)
    return {title: _squeezed("\n".join(lines)) for title, lines in found.items()}


def _bold(line: str) -> str:
    return f"**{line.lstrip('# ')}**" if line.startswith("#") else line


def _squeezed(text: str) -> str:
    """Without blank lines around it and with one at a time in it."""
    blocks = (block.strip("\n") for block in text.split("\n\n"))
    return "\n\n".join(block for block in blocks if block)
