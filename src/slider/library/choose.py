"""Arguments that select a gait library, and its path."""

import argparse
from pathlib import Path

from slider.artefacts.current import add_store_argument, current_folder
from slider.artefacts.store import Store
from slider.library.reader import STORE

MAKE_LIBRARY = "snakemake -j2 gait_library"


def add_library_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that select a library."""
    parser.add_argument(
        "--library", type=Path, help="a library.zarr (default: that of the current configuration)"
    )
    add_store_argument(parser)


def library_path(arguments: argparse.Namespace) -> Path:
    """Path of the selected library.

    Raises:
        UserError: there is none yet.
    """
    if arguments.library is not None:
        return arguments.library
    return current_folder(Store(arguments.artefacts), "library", MAKE_LIBRARY) / STORE


def current_gaits(artefacts: Path) -> tuple[Path, Path]:
    """Folders of the current library and its foot placement, which ``hzd`` walks by.

    Raises:
        UserError: there are none yet.
    """
    store, target = Store(artefacts), "snakemake -j2 reports/gait_walks.csv"
    library, placement = (current_folder(store, s, target) for s in ("library", "foot_placement"))
    return library, placement
