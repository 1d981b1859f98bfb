"""``slider library`` and ``slider gait``: the gait library, and one gait of it."""

import argparse
from pathlib import Path

from slider.artefacts.current import add_store_argument, current_folder
from slider.artefacts.store import Store
from slider.core.errors import require
from slider.library.export import gait_lines, library_lines, write_csv
from slider.library.reader import MAKE_LIBRARY, STORE, GaitLibrary


def library_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``library``."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="grid, holes and their violated constraints, ranges")
    _add_library_arguments(show)


def library(arguments: argparse.Namespace) -> None:
    """Print the overview."""
    path = library_path(arguments)
    print("\n".join([str(path), *library_lines(GaitLibrary.load(path))]))


def gait_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of ``gait``."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="print a summary")
    export = actions.add_parser("export", help="write the gait as CSV for other programs")
    for action in (show, export):
        action.add_argument("--vx", type=float, required=True, help="forward velocity [m/s]")
        action.add_argument("--vy", type=float, default=0.0, help="leftward [m/s] (default: 0)")
        action.add_argument("--yaw-rate", type=float, default=0.0, help="[rad/s] (default: 0)")
        _add_library_arguments(action)
    export.add_argument("--out", type=Path, required=True, help="file to write")


def gait(arguments: argparse.Namespace) -> None:
    """Show or export one gait."""
    library = GaitLibrary.load(library_path(arguments))
    gait = library.find(arguments.vx, arguments.vy, arguments.yaw_rate)
    if arguments.action == "show":
        print("\n".join(gait_lines(library, gait)))
        return
    out: Path = arguments.out
    require(not out.is_dir(), "--out", "the name of a file", f"the folder {out}")
    out.parent.mkdir(parents=True, exist_ok=True)
    write_csv(library, gait, out)
    print(f"{out} is ready")


def _add_library_arguments(parser: argparse.ArgumentParser) -> None:
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
