"""``slider library``: what is in the gait library, and how long its gaits took to solve."""

import argparse
from pathlib import Path

import numpy as np

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.store import Store
from slider.core.errors import UserError
from slider.library.choose import MAKE_LIBRARY, add_library_arguments, library_path
from slider.library.overview import library_lines
from slider.library.reader import STORE, GaitLibrary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
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


def run(arguments: argparse.Namespace) -> None:
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
