"""``slider library`` and ``slider gait``: the gait library, and one gait of it."""

import argparse
from pathlib import Path

import numpy as np

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.store import Store
from slider.core.errors import UserError
from slider.library.choose import MAKE_LIBRARY, add_library_arguments, library_path
from slider.library.export import FORMATS, gait_lines, library_lines
from slider.library.reader import STORE, GaitLibrary

_PICTURES = (".svg", ".png")


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
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
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
    known: dict[tuple[float, ...], float] = {}
    for gait in job.inputs["gaits"]:
        facts = store.facts(gait.stage, gait.recipe)
        known[tuple(gait.section["velocity"])] = facts.get("solve_cpu", np.nan)
    times = np.array([known[tuple(velocity)] for velocity in library.velocities.tolist()])
    if not np.isfinite(times).any():
        raise UserError(f"expected solve times beside the gaits in {store.root}, found none")
    return library, times


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
    _check(arguments)
    library = GaitLibrary.load(library_path(arguments))
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
