"""Sources of a section, made by hand."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from slider.config.convert import to_dict
from slider.config.evaluation import ReportConfig, VideoConfig
from slider.core.job import Job
from slider.reports.contents import Sources
from slider.reports.page import render

Block = TypeVar("Block")
VIDEO = VideoConfig("none", "both", 1.0, 64, 64, 25, 27, 0)


def report(*sections: str) -> dict[str, Any]:
    """Settings of a page."""
    return to_dict(ReportConfig([*sections], [], VIDEO))


def sources(inputs: dict[str, list[Path]], job: Job | None = None, **section: Any) -> Sources:
    """Sources with these inputs; the rest is empty unless given."""
    empty = {"configuration": {}, "labels": {}, "origins": {}, "report": report("table1")}
    return Sources(empty | section, inputs, Path(), job or Job(Path()))


def pick(blocks: Iterable[Any], kind: type[Block]) -> list[Block]:
    """Blocks of a section of one kind."""
    return [block for block in blocks if isinstance(block, kind)]


def html(**blocks: Sequence[Any]) -> str:
    """A page of sections."""
    return render("title", {}, blocks)
