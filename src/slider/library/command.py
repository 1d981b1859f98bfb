"""``slider library``: what is in the gait library."""

import argparse

from slider.library.choose import add_library_arguments, read_library
from slider.library.overview import library_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="grid, holes and their violated constraints, ranges")
    add_library_arguments(show)


def run(arguments: argparse.Namespace) -> None:
    """Print the overview."""
    print("\n".join(library_lines(read_library(arguments))))
