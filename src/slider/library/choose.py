"""Which library and which gait a command means: arguments, and reading them."""

import argparse
from pathlib import Path

from slider.artefacts.current import current_folder
from slider.artefacts.store import ARTEFACTS, Store
from slider.library.reader import STORE, GaitLibrary

MAKE_LIBRARY = "snakemake -j2 gait_library"


def add_library_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that say which library is meant."""
    parser.add_argument(
        "--library", type=Path, help="a library.zarr (default: that of the current configuration)"
    )
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def add_command_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command of a gait."""
    parser.add_argument("--vx", type=float, required=True, help="forward velocity [m/s]")
    parser.add_argument("--vy", type=float, default=0.0, help="leftward [m/s] (default: 0)")
    parser.add_argument("--yaw-rate", type=float, default=0.0, help="[rad/s] (default: 0)")


def read_library(arguments: argparse.Namespace) -> GaitLibrary:
    """Read the library that the arguments mean.

    Raises:
        UserError: there is none yet, or the path holds none.
    """
    return GaitLibrary.load(library_path(arguments))


def library_path(arguments: argparse.Namespace) -> Path:
    """The library that the arguments mean.

    Raises:
        UserError: there is none yet.
    """
    if arguments.library is not None:
        return arguments.library
    store = Store(arguments.artefacts)
    return current_folder(store, "library", MAKE_LIBRARY) / STORE
