"""``slider library`` and ``slider gait``: the gait library, and one gait of it."""

import argparse
from math import nan
from pathlib import Path

import numpy as np

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.store import Store
from slider.commands import make_folder
from slider.core.errors import UserError, require
from slider.library.choose import MAKE_LIBRARY, add_library_arguments, library_path
from slider.library.export import FORMATS, gait_lines, library_lines
from slider.library.reader import STORE, GaitLibrary


def library_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``library``."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="grid, holes and their violated constraints, ranges")
    add_library_arguments(show)
    times = actions.add_parser("times", help="draw how long the current library's gaits took")
    add_store_argument(times)
    times.add_argument(
        "--out",
        type=Path,
        default=Path("reports/figures/solve_times"),
        help="name without ending of .svg and .md (default: reports/figures/solve_times)",
    )


def library(arguments: argparse.Namespace) -> None:
    """Print the overview, or draw the solve times."""
    if arguments.action == "show":
        path = library_path(arguments)
        print("\n".join([str(path), *library_lines(GaitLibrary.load(path))]))
        return
    from slider.reports.figures import maps
    from slider.reports.figures.style import write_figure

    library, times = _solve_times(Store(arguments.artefacts))
    make_folder(arguments.out.parent)
    text = maps.times_caption(times)
    write_figure(arguments.out, "Solve times", lambda: maps.draw_times(library, times), text)
    print(f"{arguments.out}.svg is ready")


def _solve_times(store: Store) -> tuple[GaitLibrary, np.ndarray]:
    """The current library and the processor time (G,) [s] of each gait; NaN where none is known.

    Times differ from run to run, so they stand beside the store's manifests and not in a stage's
    result.
    """
    job, _ = current_result(store, "library", MAKE_LIBRARY)
    library = GaitLibrary.load(current_folder(store, "library", MAKE_LIBRARY) / STORE)
    times = {
        tuple(gait.section["velocity"]): store.metadata(gait.stage, gait.recipe).get(
            "solve_cpu", nan
        )
        for gait in job.inputs["gaits"]
    }
    known = np.array([times[tuple(velocity)] for velocity in library.velocities.tolist()])
    if not np.isfinite(known).any():
        raise UserError(f"expected solve times beside the gaits in {store.root}, found none")
    return library, known


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
