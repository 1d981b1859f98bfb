"""Videos: a row per command, a column per controller."""

import json
from dataclasses import dataclass
from pathlib import Path

from slider.reports.controllers import label, speed
from slider.reports.page import Section, data_address
from slider.reports.sections.sources import Sources
from slider.reports.video import ABOUT, FILM, POSTER


@dataclass(frozen=True)
class _Video:
    controller: str
    command: float
    fate: str
    film: str
    poster: str


def section(sources: Sources) -> Section:
    """All videos, in the page itself."""
    videos = [_read(folder) for folder in sources.inputs.get("videos", ())]
    commands = sorted({video.command for video in videos})
    rows = [(speed(command), [v for v in videos if v.command == command]) for command in commands]
    video = sources.report.video
    values = {"rows": rows, "renderer": video.renderer, "cameras": " and ".join(video.cameras)}
    return Section("Videos", "videos.html", values)


def _read(folder: Path) -> _Video:
    about = json.loads((folder / ABOUT).read_text())
    fell = about["fell_at"]
    fate = (
        f"walks at {about['mean_velocity']:.2f} m/s"
        if fell is None
        else f"falls after {fell:.1f} s"
    )
    return _Video(
        controller=label(about["controller"]),
        command=about["command"],
        fate=fate,
        film=data_address(folder / FILM, "video/mp4"),
        poster=data_address(folder / POSTER, "image/jpeg"),
    )
