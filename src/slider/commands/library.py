"""``slider library``: overview of the gait library."""

import argparse
from pathlib import Path

from slider.artefacts.current import add_store_argument, current_folder
from slider.artefacts.store import Store
from slider.library.export import library_lines
from slider.library.reader import MAKE_LIBRARY, STORE, GaitLibrary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="grid, holes and their violated constraints, ranges")
    show.add_argument("--library", type=Path, help="library.zarr (default: of the current plan)")
    add_store_argument(show)


def run(arguments: argparse.Namespace) -> None:
    """Print the overview."""
    path = library_path(arguments)
    print("\n".join([str(path), *library_lines(GaitLibrary.load(path))]))


def library_path(arguments: argparse.Namespace) -> Path:
    """Path of the selected library.

    Raises:
        UserError: there is no library yet.
    """
    if arguments.library is not None:
        return arguments.library
    return current_folder(Store(arguments.artefacts), "library", MAKE_LIBRARY) / STORE


def current_gaits(artefacts: Path) -> tuple[Path, Path]:
    """Folders of the current gait library and its foot placement, for the controller ``hzd``.

    Raises:
        UserError: they have not been computed yet.
    """
    store, target = Store(artefacts), "snakemake -j2 reports/gait_walks.csv"
    library, placement = (current_folder(store, s, target) for s in ("library", "foot_placement"))
    return library, placement
