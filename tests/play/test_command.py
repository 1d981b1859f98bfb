"""``slider play`` answers what it cannot do in one line, and leaves nothing behind."""

import socket
import subprocess
import sys
import time
from unittest.mock import Mock

import pytest

from slider.cli import main
from slider.play.window import NoWindow
from tests.config.composed import CONF

AGENTS = ["policy", *sorted(path.stem for path in (CONF / "control").glob("[!b]*.yaml")), "zero"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--gait 0.6", "--gait: expected VX VY [YAW_RATE], found 1 values"),
        ("--gait nan 0", "--gait: expected numbers, found [nan, 0.0]"),
        ("hzd --library a.zarr", "--library: expected --gait, found none"),
        ("zero --headless --film w.webp", "--headless: expected no --film, found one"),
        (
            "zero --film w.webp --set env.control_period=0.1 env.physics.substeps=20 "
            "report.video.frame_rate=10",
            "env.control_period: expected 0.04 s divided by a whole number, for a film, found 0.1",
        ),
        ("zero --velocity 9 0 0", "--velocity: expected VX between -1 and 3, found 9"),
        ("zero --web --port 99999", "--port: expected a free port at 127.0.0.1, found 99999"),
        ("zero --film w.mp4", "--film: expected a name that ends with .webp, found w.mp4"),
        ("walker", f"agent: expected one of {', '.join(AGENTS)}, random, found walker"),
        ("", "make it with `snakemake -j2 policy`"),
    ],
)
def test_each_refusal_is_one_line(arguments, message, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(["play", *arguments.split(), "--conf", str(CONF)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("slider: ")
    assert message in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("machine", "reason"),
    [
        (lambda patch: patch.setenv("DISPLAY", ":none"), "expected a display, found none"),
        (lambda patch: patch.setattr(sys, "platform", "darwin"), "mjpython"),
    ],
)
def test_without_a_window_it_is_in_the_browser(machine, reason, capsys, monkeypatch):
    served = []
    monkeypatch.setattr("slider.play.web.run", lambda *given: served.append(given[3:]))
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    machine(monkeypatch)
    assert main(["play", "zero", "--conf", str(CONF)]) == 0
    assert served == [("127.0.0.1", 0)]
    assert reason in capsys.readouterr().out
    assert capsys.readouterr().err == ""


def test_the_browser_gets_no_port_that_there_is_not(refused, monkeypatch):
    monkeypatch.setattr("slider.play.window.run", Mock(side_effect=NoWindow("no display")))
    line = "slider: --port: expected a free port at 127.0.0.1, found 99999"
    assert refused("play", "zero", "--port", "99999", "--conf", str(CONF)).startswith(line)


def test_a_fall_is_status_1_and_leaves_no_log(tmp_path, monkeypatch, capsys):
    """Uniform actions make MuJoCo warn about the accelerations of a fallen robot."""
    monkeypatch.chdir(tmp_path)
    options = ["--conf", str(CONF), "--headless", "--seconds", "3"]
    assert main(["play", "random", *options]) == 1
    assert "agent random: fell after" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_listens_at_one_address():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "slider.cli", "play", "random", "--web", "--port", str(port)]
    viewer = subprocess.Popen(command, cwd=CONF.parent, stdout=subprocess.PIPE, text=True)
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
