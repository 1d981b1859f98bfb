"""The stage ``video``: one controller at one command, as a short film."""

import json
import os
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.env import DisturbanceConfig, StartNoise
from slider.config.evaluation import VideoConfig
from slider.config.robot import RobotConfig
from slider.core.errors import UserError
from slider.core.job import Inputs, Job, Section, Summary

FILM, POSTER, ABOUT = "video.mp4", "poster.jpg", "about.json"
_POSTER_TIME = 2.0  # a robot in motion [s]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Simulate one robot from rest, film it, and say how it went.

    Raises:
        UserError: nothing can be rendered on this machine.
    """
    # Before the first import of mujoco, which reads it. The page reads names of this module: it
    # does not wait for what simulates.
    os.environ["MUJOCO_GL"] = section["video"]["renderer"]
    import torch

    from slider.env.disturbance import Disturbance
    from slider.env.rollout import Episode
    from slider.env.starts import at_rest
    from slider.evaluation import stage

    torch.set_num_threads(job.threads)
    robot = from_dict(RobotConfig, section["robot"])
    video = from_dict(VideoConfig, section["video"])
    noise = from_dict(StartNoise, section["start"])
    config = from_dict(DisturbanceConfig, section["disturbance"])
    disturbance = Disturbance(config, (video.seed,))
    simulate = stage.simulate if "walking" in inputs else stage.simulate_baseline
    one = simulate(section, inputs, 1, disturbance)
    episode = Episode(one.controller, one.physics, one.env)
    start = at_rest(robot, noise, np.random.default_rng(video.seed), 1)
    frames = [episode.start(*start, np.array([[section["speed"], 0.0, 0.0]]))]
    frames += [episode.step() for _ in range(round(video.duration / one.env.control_period))]
    terrain = one.physics.terrain
    _film(section, robot, video, frames, out, None if terrain is None else terrain.ground)
    place = "" if terrain is None else terrain.described(0)
    summary = _summary(section, frames) | {"terrain": place}
    (out / ABOUT).write_text(json.dumps(summary) + "\n", encoding="utf-8")
    return summary


def _film(
    section: Section, robot: RobotConfig, video: VideoConfig, frames, out: Path, ground
) -> None:
    from slider.reports import film
    from slider.robot.scene import build_scene

    relief = None if ground is None else film.relief(ground, frames)
    period = frames[1].time - frames[0].time
    shown = frames[:: round(1.0 / (video.frame_rate * period))]
    model = build_scene(robot, video.width, video.height, relief)
    pictures = film.render(model, shown, (video.width, video.height), video.cameras)
    images = []
    fallen = False
    try:
        for frame, picture in zip(shown, pictures, strict=True):
            fallen |= frame.failed
            images.append(film.annotate(picture, *_overlay(section, frame, fallen), fallen))
    except (ImportError, RuntimeError, AttributeError) as error:  # what broken OpenGL raises
        raise UserError(
            f"expected to render with {video.renderer}, found: {error}; the report does "
            "without videos after report.video.renderer=none"
        ) from None
    film.write(images, video, out / FILM)
    images[min(len(images) - 1, round(_POSTER_TIME * video.frame_rate))].save(
        out / POSTER, quality=80
    )


def _overlay(section: Section, frame, fallen: bool) -> tuple[str, list[str]]:
    title = section["label"] + (", fallen" if fallen else "")
    lines = [
        f"command {section['speed']:.2f} m/s",
        f"actual {frame.velocity[0]:.2f} m/s",
        f"t = {frame.time:.1f} s",
    ]
    return title, lines


def _summary(section: Section, frames) -> Summary:
    falls = [frame.time for frame in frames if frame.failed]
    half = [frame.velocity[0] for frame in frames[len(frames) // 2 :]]
    return {
        "controller": section["controller"],
        "label": section["label"],
        "speed": section["speed"],
        "fell_at": falls[0] if falls else None,
        "mean_velocity": float(np.mean(half)),
    }
