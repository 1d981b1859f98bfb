"""Stores and a remote, empty and filled."""

from pathlib import Path

import pytest

from slider.artefacts.remote import Remote
from slider.artefacts.store import Store
from slider.artefacts.transfer import push
from tests.artefacts.samples import JOBS, Place, fill


@pytest.fixture
def full(tmp_path: Path) -> Store:
    """A store in which everything is computed."""
    return fill(Store(tmp_path / "full"))


@pytest.fixture
def bare(tmp_path: Path) -> Store:
    return Store(tmp_path / "bare")


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(Remote(str(tmp_path / "remote")), tmp_path / "remote")


@pytest.fixture
def filled(place: Place, full: Store) -> Place:
    push(full, JOBS, place.remote)
    return place
