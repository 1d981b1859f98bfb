"""``slider runs``: MLflow's pages, opened on the runs of the latest pipeline."""

import argparse
import os
import socket
import sys

from slider.artefacts.current import add_store_argument
from slider.core.errors import UserError, require
from slider.tracking import DATABASE, LATEST

HOST = "127.0.0.1"
# Without workers for jobs that nothing here uses: each is one more import of MLflow.
_SETTINGS = {"MLFLOW_DISABLE_TELEMETRY": "true", "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--port", type=int, default=5000, help="of this machine (default: 5000)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Say which address shows the runs, and become MLflow's server."""
    database, latest = ((arguments.artefacts / name).resolve() for name in (DATABASE, LATEST))
    if not (database.is_file() and latest.is_file()):
        expected = f"expected runs in {database}, found none"
        raise UserError(f"{expected}: run a pipeline with tracking.enabled=true")
    check_port(arguments.port, HOST)
    print(f"open http://{HOST}:{arguments.port}/#{latest.read_text('utf-8')}", flush=True)
    command = [sys.executable, "-m", "mlflow", "ui", "--workers", "1", "--host", HOST]
    command += ["--port", str(arguments.port), "--backend-store-uri", f"sqlite:///{database}"]
    os.execve(sys.executable, command, os.environ | _SETTINGS)


def check_port(port: int, host: str) -> None:
    """Refuse a port that does not exist or is taken, and a host that is not this machine."""
    require(0 <= port < 1 << 16, "--port", "a number from 0 to 65535", port)
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except socket.gaierror as error:
        raise UserError(f"--host: expected an address, found {host}: {error.strerror}") from None
    except OSError as error:
        raise UserError(
            f"--port: expected a free port at {host}, found {port}: {error.strerror}"
        ) from None
