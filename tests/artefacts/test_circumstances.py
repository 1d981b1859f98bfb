"""Commit and pipeline run: facts for display, beside results and in no recipe."""

import shlex
import subprocess

import pytest

from slider.artefacts import circumstances


@pytest.fixture
def repository(tmp_path, monkeypatch):
    monkeypatch.setattr(circumstances, "_SOURCE", tmp_path)
    for name in ("GIT_DIR", "GIT_WORK_TREE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))

    def git(*arguments: str) -> str:
        identity = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        command = ["git", *identity, *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    return tmp_path, git


def test_there_is_no_commit_outside_a_repository(repository):
    assert circumstances.revision() == {}


def test_tells_the_commit_and_whether_files_differ(repository):
    folder, git = repository
    (folder / "a.txt").write_text("one")
    git("init", "-q")
    git("add", "a.txt")
    git("commit", "-qm", "one")
    (folder / "untracked.txt").write_text("results do not come from here")
    commit = git("rev-parse", "HEAD")
    assert circumstances.revision() == {"commit": commit, "dirty": "false"}
    (folder / "a.txt").write_text("two")
    assert circumstances.revision() == {"commit": commit, "dirty": "true"}


def test_jobs_belong_to_the_pipeline_run_that_began_last(repository, tmp_path):
    assert circumstances.circumstances(tmp_path) == {}
    circumstances.note_start(tmp_path, ["gait.cost=torque", "env=paper"])
    first = circumstances.circumstances(tmp_path)
    assert first == circumstances.circumstances(tmp_path)
    assert first["pipeline_started"].endswith("+00:00")
    assert first["overrides"] == "gait.cost=torque env=paper"
    blanks = ["a.label=two words", "b.terms=[x,y]", "c='"]
    circumstances.note_start(tmp_path, blanks)
    noted = circumstances.circumstances(tmp_path)["overrides"]
    assert noted.startswith("a.label='two words' b.terms=[x,y] c=")
    assert shlex.split(noted) == blanks
    (tmp_path / "current" / "started").write_bytes(b"\xff\n")
    assert circumstances.circumstances(tmp_path)["overrides"] == ""
