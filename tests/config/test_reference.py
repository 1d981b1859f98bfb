"""The configuration reference: complete, with the comments of ``conf/``."""

import dataclasses
from pathlib import Path

from slider.config.compose import compose
from slider.config.reference import OPTIONAL, group_entries, read_comments, reference
from slider.config.schema import Config

CONF = Path(__file__).parents[2] / "conf"


def test_every_value_has_an_entry_and_nearly_all_a_meaning():
    config, comments = compose(OPTIONAL, CONF), read_comments(CONF)
    found = [
        entry
        for item in dataclasses.fields(Config)
        for entry in group_entries(getattr(config, item.name), item.name, comments)
    ]
    paths = {entry.path for entry in found}
    assert {"gait.nodes", "train.walking.ppo.schedule", "report.video.quality"} <= paths
    assert len(paths) == len(found) > 100
    silent = [entry.path for entry in found if not entry.comment]
    assert len(silent) < 0.12 * len(found), silent


def test_takes_the_comment_of_the_key_itself():
    comments = read_comments(CONF)
    assert comments["gait.posture.clearance"].startswith("of the swing foot at mid-step")
    assert comments["tracking.experiment"] == "name of the MLflow experiment"


def test_is_a_page_with_a_table_per_group():
    page = reference(CONF)
    assert page.count("| key | type | default | meaning |") == len(dataclasses.fields(Config))
    assert "| `gait.nodes` | int | `21` |" in page
    assert "| `finetuning.disturbance.push.interval` | float | `2.0` |" in page
