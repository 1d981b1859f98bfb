"""Results that all processes of a test session share: the first one computes, the others wait."""

import os
import pickle
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, TypeVar

from slider.artefacts.store import exclusive
from slider.core.files import digest_text

F = TypeVar("F", bound=Callable[..., Any])
FOLDER = "SLIDER_TEST_SESSION"  # set by tests/conftest.py; a process of pytest-xdist inherits it


def folder() -> Path:
    """Where they lie; it goes with the session."""
    return Path(os.environ[FOLDER])


def new_folder() -> Path:
    """An empty one there, for a result that consists of files."""
    return Path(mkdtemp(dir=folder()))


def shared(function: F) -> F:
    """Compute a result, which pickle must give back as it was, once for some plain arguments."""

    @cache
    @wraps(function)
    def once(*arguments: Any) -> Any:
        name = f"{function.__module__}.{function.__name__}.{digest_text(repr(arguments))[:16]}"
        path = folder() / f"{name}.pickle"
        with exclusive(folder(), name):
            if not path.exists():
                content = pickle.dumps(function(*arguments))
                path.write_bytes(content)
            return pickle.loads(path.read_bytes())

    return once
