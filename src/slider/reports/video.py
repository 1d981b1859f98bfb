"""The stage ``video``: one controller at one command, as a short film."""

import json
import os
from pathlib import Path

import numpy as np

from slider.config.convert import from_dict
from slider.config.env import DisturbanceConfig, StartNoise
from slider.config.evaluation import VideoConfig
from slider.config.robot import RobotConfig
from slider.core.job import Inputs, Job, Section, Summary

FILM, POSTER, ABOUT = "video.mp4", "poster.jpg", "about.json"
_POSTER_TIME = 2.0  # the robot is in motion then [s]


def run(section: Section, inputs: Inputs, out: Path, job: Job) -> Summary:
    """Simulate one robot from rest, film it, and report the outcome.

    Raises:
        UserError: nothing can be rendered on this machine.
    """
    # Set before the first import of mujoco, which reads it. Simulation is imported here: the page
    # only needs names of this module.
    os.environ["MUJOCO_GL"] = section["video"]["renderer"]
    from slider.env.disturbance import Disturbance
    from slider.env.rollout import Episode, mean_speed
    from slider.evaluation.stage import set_up
    from slider.reports import film

    robot = from_dict(RobotConfig, section["robot"])
    video = from_dict(VideoConfig, section["video"])
    noise = from_dict(StartNoise, section["start"])
    config = from_dict(DisturbanceConfig, section["disturbance"])
    one = set_up(section, inputs, 1, Disturbance(config, (video.seed,)), job.threads)
    episode, velocity = Episode(*one, noise, video.seed), np.array([section["speed"], 0.0, 0.0])
    frames, terrain = [episode.start(velocity)], episode.terrain
    frames += [episode.step(velocity) for _ in range(round(video.duration / episode.period))]
    relief = None if terrain is None else film.relief(terrain.ground, frames)
    shown = frames[:: round(1.0 / (video.frame_rate * (frames[1].time - frames[0].time)))]
    pictures = film.render(robot, shown, (video.width, video.height), video.cameras, relief)
    images, fallen = [], False
    for frame, picture in zip(shown, pictures, strict=True):
        fallen |= frame.failed
        title = section["label"] + (", fallen" if fallen else "")
        subtitle = f"command {section['speed']:.2f} m/s   actual {frame.velocity[0]:z.2f} m/s"
        subtitle += f"   t = {frame.time:.1f} s"
        images.append(film.annotate(picture, title, subtitle, fallen))
    film.write(images, video, out / FILM)
    poster = images[min(len(images) - 1, round(_POSTER_TIME * video.frame_rate))]
    poster.save(out / POSTER, quality=80)
    summary = {name: section[name] for name in ("controller", "label", "speed")}
    summary |= {
        "fell_at": next((frame.time for frame in frames if frame.failed), None),
        "mean_velocity": mean_speed(frames),
        "terrain": "" if terrain is None else terrain.described(0),
    }
    (out / ABOUT).write_text(json.dumps(summary) + "\n", encoding="utf-8")
    return summary
