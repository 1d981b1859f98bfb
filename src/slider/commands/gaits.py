"""``slider library`` and ``slider gait``: the gait library, and one gait of it."""

import argparse
from pathlib import Path

from slider.commands import make_folder
from slider.core.errors import require
from slider.library.choose import add_library_arguments, library_path
from slider.library.export import FORMATS, gait_lines, library_lines
from slider.library.reader import GaitLibrary


def library_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``library``."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="grid, holes and their violated constraints, ranges")
    add_library_arguments(show)


def library(arguments: argparse.Namespace) -> None:
    """Print the overview."""
    path = library_path(arguments)
    print("\n".join([str(path), *library_lines(GaitLibrary.load(path))]))


def gait_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``gait``."""
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


def gait(arguments: argparse.Namespace) -> None:
    """Show or export one gait."""
    show = arguments.action == "show"
    out: Path | None = arguments.out
    is_file = out is None or not out.is_dir()
    require(is_file, "--out", "the name of a file", f"the folder {out}")
    drawn = not show or out is None or out.suffix in (".svg", ".png")
    require(drawn, "--out", "a name that ends in .svg or .png", out)
    library = GaitLibrary.load(library_path(arguments))
    gait = library.find(arguments.vx, arguments.vy, arguments.yaw_rate)
    if show:
        print("\n".join(gait_lines(library, gait)))
    if out is None:
        vx, vy, yaw_rate = library.velocities[gait]
        turn = f"_{yaw_rate:+.2f}" if yaw_rate else ""
        out = Path("reports") / "gaits" / f"{vx:.2f}_{vy:+.2f}{turn}.png"
    make_folder(out.parent)
    if show:
        from slider.reports.figures import gaits
        from slider.reports.figures.style import save, style

        with style():
            save(gaits.draw_sheet(library, gait), out)
    else:
        FORMATS[arguments.format](library, gait, out)
    print(f"{out} is ready")
