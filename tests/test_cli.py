"""The command line: what people are shown, and what the pipeline calls."""

import errno
import os
import shlex
import subprocess
import sys
from unittest.mock import Mock

import pytest

from slider.cli import COMMANDS, INTERNAL, main
from tests.config.composed import CONF


def test_help_lists_what_people_use(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    text = capsys.readouterr().out
    listed = {line.split()[0] for line in text.partition("commands:")[2].splitlines() if line}
    assert listed == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS | INTERNAL)
def test_every_command_has_help_of_its_own(name, capsys):
    with pytest.raises(SystemExit, match="0"):
        main([name, "--help"])
    assert f"usage: slider {name}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "variables", "line"),
    [
        ("play zero --film w.webp", {"MUJOCO_GL": "egll"}, "MUJOCO_GL=egll: expected a renderer, "),
        ("config", {}, "expected slider of this folder, "),
    ],
)
def test_a_strange_environment_is_one_line(command, variables, line, tmp_path):
    if not variables:  # the folder is a copy of a checkout
        (tmp_path / "src" / "slider").mkdir(parents=True)
        (tmp_path / "src" / "slider" / "cli.py").touch()
    done = subprocess.run(
        [sys.executable, "-m", "slider.cli", *command.split(), "--conf", str(CONF)],
        env=os.environ | variables,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1)
    assert done.stderr.startswith(f"slider: {line}")


def test_an_unknown_command_names_those_of_people(refused):
    text = refused("walk")
    assert text.startswith("slider: argument command: invalid choice: 'walk'")
    assert "publish" not in text


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("play --velocity 1.2 0", "play: argument --velocity: expected 3 arguments"),
        ("play --seed abc", "play: argument --seed: invalid int value: 'abc'"),
        ("store", "store: the following arguments are required: action"),
        ("results NOPAGE.md", "NOPAGE.md: No such file or directory"),
    ],
)
def test_a_wrong_argument_is_one_line(arguments, line, refused):
    assert refused(*arguments.split()) == f"slider: {line}"


@pytest.mark.parametrize(
    "command",
    [
        "{} config >&- <&-",
        "PYTHONIOENCODING=ascii {} config --keys gait >/dev/null",  # with signs beyond ASCII
    ],
)
def test_no_kind_of_output_gives_a_trace(command):
    command = command.format(f"{shlex.quote(sys.executable)} -m slider.cli")
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.stderr == ""


def test_ctrl_c_is_the_status_of_a_shell(monkeypatch, capsys):
    monkeypatch.setattr("slider.commands.config.run", Mock(side_effect=KeyboardInterrupt))
    assert main(["config"]) == 130
    assert capsys.readouterr().err == ""


def test_a_missing_right_is_one_line(monkeypatch, refused):
    error = PermissionError(errno.EACCES, "Permission denied", "artefacts/a")
    monkeypatch.setattr("slider.commands.config.run", Mock(side_effect=error))
    line = "slider: expected to write artefacts/a, found: Permission denied"
    assert refused("config") == line
