"""What the Snakefile takes of the pipeline."""

import shlex

import pytest
from snakemake.cli import parse_config

from pipeline.entry import Pipeline, open_pipeline, parse_overrides
from slider.artefacts.run_metadata import config_option
from slider.core.errors import UserError
from tests.config.composed import CONF


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def opened(overrides: str = "", **options) -> Pipeline:
    return open_pipeline({"hydra": f"experiment=test {overrides}"}, CONF, **options)


@pytest.mark.parametrize(
    ("overrides", "cores", "slots", "threads"),
    [("", 1, 1, 1), ("", 4, 1, 2), ("resources.threads=3", 2, 3, 3)],
)
def test_a_training_holds_one_core_and_uses_idle_ones(overrides, cores, slots, threads):
    pipeline = opened(overrides, cores=cores)
    assert pipeline.threads(slots) == threads


def test_no_remote_fails_a_run(capsys):
    opened("store.remote=/nowhere")
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("slider: remote /nowhere: expected results of slider, found none")
    assert line.endswith("; what is missing is computed here")


@pytest.mark.parametrize("overrides", ["a='b c' d=[1,2]", 'a="it\'s" b=1', "", "a=`x`$HOME"])
def test_overrides_come_back_through_shell_and_snakemake(overrides):
    words = shlex.split(config_option(overrides))
    assert parse_overrides(parse_config(words[1:])) == shlex.split(overrides)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"hydra": 3}, "expected hydra='key=value ...', found 3"),
        ({"hydar": "gait.nodes=3"}, "expected hydra='key=value ...', found hydar"),
        ({"hydra": "a='b"}, "No closing quotation .* before or after them keeps them"),
    ],
)
def test_a_mistake_in_the_option_is_one_line(setting, message):
    with pytest.raises(UserError, match=message):
        parse_overrides(setting)
