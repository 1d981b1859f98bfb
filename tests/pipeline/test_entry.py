"""What the Snakefile takes of the pipeline."""

from pathlib import Path

import pytest

from pipeline.entry import open_pipeline

CONF = Path(__file__).parents[2] / "conf"


@pytest.mark.parametrize(
    ("overrides", "cores", "threads"),
    [
        ("", 2, 1),
        ("", 8, 1),
        ("", 16, 2),
        ("", 128, 4),
        ("", None, 4),  # a cluster
        ("resources.threads=3", 2, 3),
    ],
)
def test_a_training_has_a_thread_for_every_eight_cores(
    tmp_path, monkeypatch, overrides, cores, threads
):
    monkeypatch.chdir(tmp_path)
    opened = open_pipeline({"hydra": f"experiment=test {overrides}"}, CONF)
    assert opened.training_threads(cores) == threads
