"""``slider gait``: look at one gait of the library, or take it out."""

import argparse
from pathlib import Path

from slider.core.errors import UserError
from slider.library.choose import add_library_arguments, read_library
from slider.library.export import FORMATS
from slider.library.overview import gait_lines
from slider.library.reader import GaitLibrary

_PICTURES = (".svg", ".png")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="print a summary and draw the gait")
    export = actions.add_parser("export", help="write the gait for other programs")
    for action in (show, export):
        action.add_argument("--vx", type=float, required=True, help="forward velocity [m/s]")
        action.add_argument("--vy", type=float, default=0.0, help="leftward [m/s] (default: 0)")
        action.add_argument("--yaw-rate", type=float, default=0.0, help="[rad/s] (default: 0)")
        add_library_arguments(action)
    show.add_argument(
        "--out", type=Path, help="picture, .svg or .png (default: reports/gaits/<vx>_<vy>.png)"
    )
    export.add_argument("--format", choices=FORMATS, required=True)
    export.add_argument("--out", type=Path, required=True, help="file to write")


def run(arguments: argparse.Namespace) -> None:
    """Show or export one gait."""
    _check(arguments)
    library = read_library(arguments)
    gait = library.find(arguments.vx, arguments.vy, arguments.yaw_rate)
    if arguments.action == "show":
        print("\n".join(gait_lines(library, gait)))
        out = arguments.out or _default_picture(library, gait)
        _draw(library, gait, out)
    else:
        out = arguments.out
        _make_folder(out)
        FORMATS[arguments.format](library, gait, out)
    print(f"{out} is ready")


def _check(arguments: argparse.Namespace) -> None:
    """Refuse a name for the output before anything is read."""
    out = arguments.out
    if out is not None and out.is_dir():
        raise UserError(f"--out: expected the name of a file, found the folder {out}")
    if arguments.action == "show" and out is not None and out.suffix not in _PICTURES:
        raise UserError(f"--out: expected a name that ends in .svg or .png, found {out}")


def _default_picture(library: GaitLibrary, gait: int) -> Path:
    vx, vy, yaw_rate = library.velocities[gait]
    turn = f"_{yaw_rate:+.2f}" if yaw_rate else ""
    return Path("reports") / "gaits" / f"{vx:.2f}_{vy:+.2f}{turn}.png"


def _draw(library: GaitLibrary, gait: int, out: Path) -> None:
    from slider.reports.figures import gaits
    from slider.reports.figures.style import save, style

    _make_folder(out)
    with style():
        save(gaits.draw_sheet(library, gait), out)


def _make_folder(out: Path) -> None:
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out: {out}: {error.strerror}") from None
