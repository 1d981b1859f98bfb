"""``slider runs``: serve MLflow's user interface, at the runs of the latest pipeline."""

import argparse
import os
import socket
import sys

from slider.artefacts.current import add_store_argument
from slider.core.errors import UserError
from slider.tracking import DATABASE, LATEST

HOST = "127.0.0.1"
# Disable job workers, which are not used here: each would import MLflow once more.
_SETTINGS = {"MLFLOW_DISABLE_TELEMETRY": "true", "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--port", type=int, default=5000, help="of this machine (default: 5000)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the address of the runs and replace this process by MLflow's server."""
    database, latest = ((arguments.artefacts / name).resolve() for name in (DATABASE, LATEST))
    if not (database.is_file() and latest.is_file()):
        expected = f"expected runs in {database}, found none"
        raise UserError(f"{expected}: run a pipeline with tracking.enabled=true")
    check_port(arguments.port, HOST)
    print(f"open http://{HOST}:{arguments.port}/#{latest.read_text('utf-8')}", flush=True)
    command = [sys.executable, "-I", "-m", "mlflow", "ui", "--workers", "1", "--host", HOST]
    command += ["--port", str(arguments.port), "--backend-store-uri", f"sqlite:///{database}"]
    os.execve(sys.executable, command, os.environ | _SETTINGS)


def check_port(port: int, host: str) -> None:
    """Reject a port that is invalid or in use, and a host that is not this machine."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        socket.create_server((host, port), family=family).close()
    except (OSError, OverflowError) as error:
        raise UserError(f"--port: expected a free port at {host}, found {port}: {error}") from None
