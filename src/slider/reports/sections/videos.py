"""Videos: a row per command, a column per controller."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from slider.reports.controllers import speed
from slider.reports.sections.sources import Sources
from slider.reports.table import Text
from slider.reports.video import ABOUT, FILM, POSTER

_NO_RENDERER = (
    "No videos: this machine renders neither with EGL nor with OSMesa. Install one of them (on "
    "Debian `libegl1 libegl-mesa0` or `libosmesa6`) and build the page again."
)


@dataclass(frozen=True)
class Film:
    """A video, the picture in its place on paper, and how the robot did."""

    path: Path
    poster: Path
    caption: str


@dataclass(frozen=True)
class Films:
    """Films below headings."""

    kind: ClassVar = "films"
    rows: Mapping[str, Sequence[Film]]


def blocks(sources: Sources) -> Iterator[Text | Films]:
    """All videos, in the page itself."""
    video, rows = sources.report.video, {}
    if video.renderer == "none":
        yield Text("No videos: `report.video.renderer` is `none`.", "note")
        return
    folders = sources.inputs.get("videos", ())
    if not folders:
        yield Text(_NO_RENDERER, "note")
        return
    found = [(json.loads((folder / ABOUT).read_text()), folder) for folder in folders]
    for about, folder in sorted(found, key=lambda item: item[0]["command"]):
        film = Film(folder / FILM, folder / POSTER, f"{about['label']}: {_fate(about)}")
        rows.setdefault(f"{speed(about['command'])} m/s", []).append(film)
    seen = " and ".join(video.cameras)
    yield Text(f"One robot per film, all from the same start at rest, seen from the {seen}.")
    yield Films(rows)


def _fate(about: Mapping[str, float | None]) -> str:
    if about["fell_at"] is None:
        return f"walks at {about['mean_velocity']:.2f} m/s"
    return f"falls after {about['fell_at']:.1f} s"
