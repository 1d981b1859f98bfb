"""Pipelines that ran."""

import pytest

from tests.workflow.workspace import Workspace, dummies_that_ran, finished


@pytest.fixture(scope="session")
def real() -> Workspace:
    """A pipeline that ran from nothing to its table and its page, once; nobody may change it."""
    return finished()


@pytest.fixture
def workspace(tmp_path) -> Workspace:
    """A pipeline of stages in miniature that ran."""
    return dummies_that_ran().copy(tmp_path / "copy")
