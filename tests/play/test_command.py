"""``slider play`` answers what it cannot do in one line, and leaves nothing behind."""

import sys

import pytest

from slider.cli import main
from tests.env.synthetic import CONF


def no_display(monkeypatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def macos_without_mjpython(monkeypatch) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")


def nothing(monkeypatch) -> None:
    pass


AGENTS = ["policy", *sorted(path.stem for path in (CONF / "control").glob("[!b]*.yaml")), "zero"]


@pytest.mark.parametrize(
    ("arguments", "machine", "message"),
    [
        ("--gait 0.6", nothing, "--gait: expected VX VY [YAW_RATE], found 1 values"),
        ("zero --velocity inf 0 0", nothing, "--velocity: expected a finite number, found inf"),
        ("zero --velocity 9 0 0", nothing, "--velocity: expected VX between -1 and 3, found 9"),
        ("zero --seconds 0", nothing, "--seconds: expected a positive number, found 0"),
        ("zero --seed -1", nothing, "--seed: expected no negative number, found -1"),
        ("zero --web --port 99999", nothing, "--port: expected a number from 0 to 65535, found"),
        ("zero --web --host 256.1.1.1", nothing, "--host: expected an address of this machine"),
        ("zero --film w.mp4", nothing, "--film: expected a name that ends with .webp, found w.mp4"),
        ("zero --film w.webp --seconds 0.1", nothing, "--film: expected --seconds of at least 1"),
        ("random --film w.webp", nothing, "expected agent random to stay up, it fell after"),
        ("walker", nothing, f"agent: expected one of {', '.join(AGENTS)}, random, found walker"),
        ("zero", no_display, "expected a display, found none: use --web or --headless"),
        ("zero", macos_without_mjpython, "mjpython"),
        ("", nothing, "make it with `snakemake -j2 policy`"),
    ],
)
def test_each_refusal_is_one_line(arguments, machine, message, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    machine(monkeypatch)
    assert main(["play", *arguments.split(), "--conf", str(CONF)]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.startswith("slider: ")
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_fall_is_status_1_and_leaves_no_log(tmp_path, monkeypatch, capsys):
    """Uniform actions make MuJoCo warn about the accelerations of a fallen robot."""
    monkeypatch.chdir(tmp_path)
    options = ["--conf", str(CONF), "--headless", "--seconds", "3"]
    assert main(["play", "random", *options]) == 1
    assert "agent random: fell after" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []
