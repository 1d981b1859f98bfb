"""A film of a tiny policy, made by the stage in a process of its own, as the pipeline does."""

import json
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest

from pipeline.stages.page import find_renderer
from slider.config.convert import to_dict
from tests.config.composed import composed
from tests.control.policies import write_policy

pytestmark = pytest.mark.skipif(find_renderer() == "none", reason="needs EGL or OSMesa")
RUN = """
import json, sys
from pathlib import Path
from slider.core.job import Job
from slider.reports.video import run
section = json.loads(Path(sys.argv[1]).read_text())
folder = Path(sys.argv[2])
run(section, {"walking": [folder]}, folder / "out", Job(folder))
"""


def film(folder: Path, *overrides: str) -> Path:
    """Result of the stage, whose files are in a folder ``out``."""
    config = to_dict(composed("experiment=test", *overrides))
    write_policy(folder / "policy.pt", *overrides)
    config["robot"].pop("provenance")
    section = {name: config["evaluation"][name] for name in ("start", "disturbance")}
    section |= {"robot": config["robot"], "env": config["env"], "speed": 0.2}
    section |= {"video": config["report"]["video"] | {"renderer": find_renderer()}}
    section |= {"controller": "policy", "label": "policy (ours)"}
    (folder / "section.json").write_text(json.dumps(section))
    (folder / "out").mkdir()
    command = [sys.executable, "-c", RUN, str(folder / "section.json"), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def flat(tmp_path_factory) -> Path:
    """Folder of a film on the plane."""
    return film(tmp_path_factory.mktemp("flat"))


def pictures(out: Path) -> list[np.ndarray]:
    with av.open(str(out / "video.mp4")) as container:
        return [one.to_ndarray(format="rgb24").astype(int) for one in container.decode(video=0)]


def test_films_what_the_configuration_asks_for(flat):
    with av.open(str(flat / "video.mp4")) as container:
        stream = container.streams.video[0]
        assert (stream.codec.name, stream.width, stream.height) == ("h264", 160, 96)
        assert stream.average_rate == 25
    first, *_, last = shown = pictures(flat)
    assert len(shown) == 11  # 0.4 s at 25 per second, both ends
    assert (first != last).any()
    side, front = (half.mean(axis=2) < 90 for half in np.hsplit(first[:60], 2))  # above the text
    width, depth = (np.ptp(np.flatnonzero(dark.any(axis=0))) for dark in (front, side))
    assert width > 1.2 * depth, "hips are wider than long"
    about = json.loads((flat / "about.json").read_text())
    assert (about["controller"], about["speed"]) == ("policy", 0.2)


def test_terrain_is_in_the_picture(flat, tmp_path):
    terrain = "terrain={kinds: [stairs_up], level: {lower: 10, upper: 10}}"
    out = film(tmp_path, f"evaluation.disturbance.{terrain}")
    assert json.loads((out / "about.json").read_text())["terrain"] == "stairs up, 10 cm"
    changed = np.abs(pictures(out)[0] - pictures(flat)[0]).max(axis=2) > 20
    assert changed.mean() > 0.02, "stairs instead of a plane"
