"""What ``slider runs`` needs."""

import socket

import pytest

from slider.core import files
from slider.tracking import DATABASE, LATEST


@pytest.mark.parametrize("content", [None, b"", b"no database"])
def test_without_runs_it_is_one_line(tmp_path, refused, content):
    if content is not None:
        (tmp_path / "mlflow.db").write_bytes(content)
    assert refused("runs", "--artefacts", str(tmp_path)).startswith("slider: expected runs in ")
    assert not (tmp_path / "mlflow.db").exists() or (tmp_path / "mlflow.db").read_bytes() == content


def test_a_taken_port_is_one_line(tmp_path, refused):
    for name in (DATABASE, LATEST):
        files.write_atomic(tmp_path / name, "")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        line = refused("runs", "--artefacts", str(tmp_path), "--port", str(port))
    assert f"--port: expected a free port at 127.0.0.1, found {port}" in line
