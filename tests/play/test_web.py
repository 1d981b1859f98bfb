"""The web viewer is for this machine alone."""

import socket
import subprocess
import sys
import time
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]


def test_listens_at_one_address():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "slider.cli", "play", "random", "--web", "--port", str(port)]
    viewer = subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 60
        while not answers("127.0.0.1", port):
            assert viewer.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.2)
        assert not answers("127.0.0.2", port)  # also this machine, as is every address 127.…
    finally:
        viewer.kill()
        viewer.communicate()


def answers(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), 1).close()
    except OSError:
        return False
    return True
