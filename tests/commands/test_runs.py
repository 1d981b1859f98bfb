"""What ``slider runs`` needs."""

import socket
import sqlite3
from contextlib import closing

import pytest


@pytest.mark.parametrize("content", [None, b"", b"no database"])
def test_without_runs_it_is_one_line(tmp_path, refused, content):
    if content is not None:
        (tmp_path / "mlflow.db").write_bytes(content)
    assert refused("runs", "--artefacts", str(tmp_path)).startswith("slider: expected runs in ")
    assert not (tmp_path / "mlflow.db").exists() or (tmp_path / "mlflow.db").read_bytes() == content


def test_a_taken_port_is_one_line(tmp_path, refused):
    with closing(sqlite3.connect(tmp_path / "mlflow.db")) as database, database:
        database.execute("CREATE TABLE runs (run_uuid, experiment_id, start_time)")
        database.execute("CREATE TABLE tags (run_uuid, key)")
        database.execute("INSERT INTO runs VALUES ('a', 1, 0)")
        database.execute("INSERT INTO tags VALUES ('a', 'plan')")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        line = refused("runs", "--artefacts", str(tmp_path), "--port", str(port))
    assert f"--port: expected a free port at 127.0.0.1, found {port}" in line
