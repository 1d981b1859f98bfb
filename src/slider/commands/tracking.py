"""``slider tracking``: the process that brings journals to MLflow. The pipeline starts it."""

import argparse
import logging

from slider.artefacts.current import add_store_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    follow = actions.add_parser("follow", help="write one session until it ends")
    follow.add_argument("session", help="name of a folder below artefacts/tracking")
    add_store_argument(follow)


def run(arguments: argparse.Namespace) -> None:
    """Follow a session."""
    from slider.tracking.mlflow_writer import follow

    logging.basicConfig(level=logging.WARNING)
    follow(arguments.artefacts, arguments.session)
