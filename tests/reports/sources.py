"""Sources of a section, made by hand."""

from pathlib import Path
from typing import Any, TypeVar

from slider.config.evaluation import ReportConfig, VideoConfig
from slider.reports.contents import Sources
from slider.reports.page import Content, render

Block = TypeVar("Block")
VIDEO = VideoConfig("none", "both", 1.0, 64, 64, 25, 27, 0)


def sources(inputs: dict[str, list[Path]], **others: Any) -> Sources:
    """Sources with these inputs; the rest is empty unless given."""
    empty = ("configuration", "labels", "origins", "times", "page")
    values: dict[str, Any] = {name: {} for name in empty}
    values |= {"report": ReportConfig(["table1"], [], VIDEO), "out": Path()}
    return Sources(inputs=inputs, **{**values, **others})


def pick(content: Content, kind: type[Block]) -> list[Block]:
    """Blocks of a section of one kind."""
    return [block for block in content.blocks if isinstance(block, kind)]


def html(**sections: Content) -> str:
    """A page of sections."""
    return render("title", {}, sections)
