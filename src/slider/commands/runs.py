"""``slider runs``: MLflow's pages, opened on the runs of the latest pipeline."""

import argparse
import os
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

from slider.artefacts.current import add_store_argument
from slider.core.errors import UserError
from slider.tracking.mlflow_writer import DATABASE, page

# Without workers for jobs that nothing here uses: each is one more import of MLflow.
_SETTINGS = {"MLFLOW_DISABLE_TELEMETRY": "true", "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"}
_LATEST = """SELECT experiment_id FROM runs JOIN tags USING (run_uuid) WHERE key = 'plan'
ORDER BY start_time DESC"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--port", type=int, default=5000, help="of this machine (default: 5000)")
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Say which address shows the runs, and become MLflow's server."""
    database = (arguments.artefacts / DATABASE).resolve()
    experiment = _experiment(database)
    print(f"open http://127.0.0.1:{arguments.port}/#{page(experiment)}", flush=True)
    command = [sys.executable, "-m", "mlflow", "ui", "--workers", "1", "--host", "127.0.0.1"]
    command += ["--port", str(arguments.port), "--backend-store-uri", f"sqlite:///{database}"]
    os.execve(sys.executable, command, os.environ | _SETTINGS)


def _experiment(database: Path) -> str:
    try:
        with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
            row = connection.execute(_LATEST).fetchone()
    except sqlite3.Error:
        row = None
    if row is None:
        raise UserError(
            f"expected runs in {database}, found none: run a pipeline with tracking.enabled=true"
        )
    return str(row[0])
