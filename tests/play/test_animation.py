"""Animations of walks and falls, on their ground."""

import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from pipeline.stages.page import find_renderer
from slider import cli
from slider.play import animation
from slider.reports import film
from tests.config.composed import CONF


@pytest.mark.skipif(find_renderer() == "none", reason="needs EGL or OSMesa")
def test_writes_pictures_that_move(tmp_path):
    path = tmp_path / "images" / "walk.webp"
    options = ["mpc_wbc_tuned", "--film", str(path), "--seconds", "1.6", "--conf", str(CONF)]
    done = subprocess.run(  # MuJoCo picks its renderer when it is imported
        [sys.executable, "-m", "slider.cli", "play", *options],
        env={**os.environ, "MUJOCO_GL": find_renderer()},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    with Image.open(path) as image:
        assert (image.format, image.n_frames >= 2, image.info["loop"]) == ("WEBP", True, 0)
        pictures = []
        for index in (0, image.n_frames - 1):
            image.seek(index)
            pictures.append(np.asarray(image.convert("L"), dtype=int))
    assert np.ptp(pictures[0]) > 100  # not an empty picture
    assert (pictures[0] != pictures[1]).any()


@pytest.fixture
def pictures(monkeypatch) -> SimpleNamespace:
    """Black ones in the place of what is rendered, and what was asked for."""
    asked = SimpleNamespace(frames=[], reliefs=[], facts=[], alarms=[])

    def render(robot, frames, size, cameras, relief):
        asked.frames.append(frames)
        asked.reliefs.append(relief)
        return [np.zeros((*size[::-1], 3), dtype=np.uint8) for _ in frames]

    def annotate(picture, title, texts, alarm):
        asked.facts.append(texts)
        asked.alarms.append(alarm)
        return Image.fromarray(picture)

    monkeypatch.setattr(film, "render", render)
    monkeypatch.setattr(film, "annotate", annotate)
    return asked


def test_shows_the_ground_below_the_robot(tmp_path, pictures):
    slope = "evaluation.disturbance.terrain={kinds:[slope_across],level:{lower:4,upper:4}}"
    path = str(tmp_path / "walk.webp")
    options = ["mpc_wbc_tuned", "--film", path, "--seconds", "1.0", "--conf", str(CONF)]
    assert cli.main(["play", *options, "--set", slope]) == 0
    (relief,) = pictures.reliefs
    across, along = (np.diff(relief.heights, axis=axis).mean() for axis in (0, 1))
    assert abs(across) == pytest.approx(0.02 * np.tan(np.radians(5.0)), rel=1e-6)
    assert along == pytest.approx(0.0, abs=1e-9)


def test_a_fall_is_shown_from_the_start(tmp_path, monkeypatch, capsys, pictures):
    path = tmp_path / "fall.webp"
    options = ["play", "random", "--film", str(path), "--conf", str(CONF)]
    assert cli.main(options) == 1
    first, *_, last = pictures.frames[0]
    assert capsys.readouterr().out == f"{path}: agent random fell after {last.time:.2f} s\n"
    assert first.time < 1 / 25
    assert path.is_file()
    monkeypatch.setattr(animation, "TILES", animation.TILES[:3])
    assert cli.main([*options, "--tiles"]) == 1
    assert capsys.readouterr().out == f"{path}: a robot fell\n"
    assert all(pictures.alarms), "it lies there to the end"


def test_tiles_show_ground_push_and_measured_speed(tmp_path, monkeypatch, pictures):
    walk, pushed, stairs = (animation.TILES[index] for index in (1, 3, 5))
    monkeypatch.setattr(animation, "TILES", (walk, pushed, stairs))
    path = tmp_path / "tiles.webp"
    options = ["--policy", str(CONF.parent / "docs" / "policy"), "--seconds", "2.0"]
    options += ["--film", str(path), "--tiles", "--conf", str(CONF), "--set", "robot=slider"]
    assert cli.main(["play", *options]) == 0
    assert [relief is not None for relief in pictures.reliefs] == [False, False, True]
    ways = [np.ptp([frame.qpos[1] for frame in frames]) for frames in pictures.frames]
    assert ways[1] > ways[0] + 0.1, "the push moves the robot sideways"
    measured = float(pictures.facts[len(pictures.facts) // 3 - 1].split()[4])
    assert measured == pytest.approx(walk.speed, rel=0.05)
    with Image.open(path) as image:
        assert image.size == (3 * 320, 240)
