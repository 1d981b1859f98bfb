"""Commit and pipeline run: facts for display, beside results and in no recipe."""

import shlex
import subprocess

import pytest

from slider.artefacts import run_metadata


@pytest.fixture
def repository(tmp_path, monkeypatch):
    monkeypatch.setattr(run_metadata, "_SOURCE", tmp_path)
    elsewhere = tmp_path.parent / "elsewhere"
    subprocess.run(["git", "init", "-q", elsewhere], check=True)
    monkeypatch.setenv("GIT_DIR", str(elsewhere / ".git"))  # of another repository

    def git(*arguments: str) -> str:
        identity = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        command = ["env", "-u", "GIT_DIR", "git", *identity, *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    return tmp_path, git


def test_an_archive_outside_or_within_another_repository_has_no_commit(repository):
    _, git = repository
    assert run_metadata.revision() == {}
    git("init", "-q")
    git("commit", "-qm", "dotfiles", "--allow-empty")
    assert run_metadata.revision() == {}


def test_tells_the_commit_and_whether_files_differ(repository):
    folder, git = repository
    (folder / "a.txt").write_text("one")
    git("init", "-q")
    git("add", "a.txt")
    git("commit", "-qm", "one")
    (folder / "untracked.txt").write_text("results do not come from here")
    commit = git("rev-parse", "HEAD")
    assert run_metadata.revision() == {"commit": commit, "dirty": "false"}
    (folder / "a.txt").write_text("two")
    assert run_metadata.revision() == {"commit": commit, "dirty": "true"}


def test_jobs_belong_to_the_latest_run_of_their_plan(repository, tmp_path):
    plan, other = tmp_path / "plan.json", tmp_path / "other.json"
    assert run_metadata.pipeline_metadata(plan) == {}
    run_metadata.note_start(plan, ["gait.cost=torque", "env=paper"], ["abc"])
    assert run_metadata.forced_recipes(plan) == ["abc"]
    assert run_metadata.pipeline_metadata(plan)["pipeline_started"].endswith("+00:00")
    blanks = ["a.label=two words", "b.terms=[x,y]", "c='"]
    run_metadata.note_start(plan, blanks)
    run_metadata.note_start(other)  # of another user of the same store
    assert shlex.split(run_metadata.pipeline_metadata(plan)["overrides"]) == blanks
    assert run_metadata.forced_recipes(plan) == []
    (tmp_path / "plan.started").write_bytes(b"\xff\n")
    assert run_metadata.pipeline_metadata(plan) == {}


@pytest.mark.parametrize("wall_s", [float("nan"), float("inf"), -1.0, "3"])
def test_times_that_no_job_took_are_refused(wall_s):
    assert run_metadata.validate_metadata({"wall_s": 3.0, "commit": "abc"})
    with pytest.raises(ValueError, match="expected a table of numbers and texts"):
        run_metadata.validate_metadata({"wall_s": wall_s})
