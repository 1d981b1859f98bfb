"""For all tests: one thread per process, long files first, results that all processes share."""

import copy
import os
import pickle
import shutil
import signal
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from pipeline.stages import entries
from slider.artefacts.recipe import Code
from slider.artefacts.runner import limit_threads
from slider.artefacts.store import Store
from slider.cli import main
from slider.composition import compose as composing
from slider.core import machine
from tests import shared

# Machine code is compiled once for all stores that tests make.
os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(__file__).parent / "__pycache__"))
os.environ.setdefault("WARP_CACHE_PATH", str(Path.home() / ".cache" / "warp"))  # as Warp's own
limit_threads(1)  # before torch and casadi are imported: `make test` has a process per core
os.fsync = lambda _: None  # what tests write need not outlive a power failure

# Hydra takes half a second for a configuration: the repository's are composed once per session.
CONF = Path(__file__).parents[1] / "conf"
_compose = composing.compose_untyped


@shared.shared
def _composed(*overrides: str) -> dict[str, Any]:
    return _compose(overrides, CONF)


def _compose_once(overrides: Sequence[str], conf: Path) -> dict[str, Any]:
    if conf.resolve() != CONF or any(text.startswith("robot=") for text in overrides):
        return _compose(overrides, conf)  # files of a test
    return copy.deepcopy(_composed(*overrides))


composing.compose_untyped = _compose_once

# Most of a composition is the choice of files, which few tests change: values go on top of it.
_compose_files = composing.hydra_compose


@shared.shared
def _chosen(*choices: str) -> bytes:
    return pickle.dumps(_compose_files("config", overrides=[*choices]))


def _compose_values(name: str, overrides: list[str]) -> DictConfig:
    loader = GlobalHydra.instance().config_loader()
    own = str(CONF) in [source.path for source in loader.repository.get_sources()]
    if not own or any(text.startswith("robot=") for text in overrides):
        return _compose_files(name, overrides=overrides)
    try:
        parsed = OverridesParser.create().parse_overrides(overrides)
        files = [each for each in parsed if loader.repository.group_exists(each.key_or_group)]
        files = [each for each in files if not isinstance(each.value(), dict)]
        config = pickle.loads(_chosen(*(each.input_line for each in files)))
        loader._apply_overrides_to_config([each for each in parsed if each not in files], config)
        return config
    except (OmegaConfBaseException, TypeError, ValueError, AttributeError):  # Hydra words them
        return _compose_files(name, overrides=overrides)


composing.hydra_compose = _compose_values


def pytest_configure() -> None:
    # Not ignored, as below nohup: pipelines that tests start inherit it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    if "PYTEST_XDIST_WORKER" not in os.environ:
        os.environ[shared.FOLDER] = tempfile.mkdtemp(prefix="slider-tests-")


def pytest_unconfigure() -> None:
    if "PYTEST_XDIST_WORKER" not in os.environ:
        shutil.rmtree(shared.folder(), ignore_errors=True)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first, so that no process is left alone with one of them at the end.

    These are the ones with runs of the real pipeline and with trainings; those that look at a
    finished pipeline come after the one that runs it.
    """

    def place(item: pytest.Item) -> tuple[bool, ...]:
        lacks = [item.get_closest_marker(name) is None for name in ("workflow", "learn")]
        return *lacks, "browser" in item.path.parts

    items.sort(key=place)


@pytest.fixture
def processor(monkeypatch):
    """Pretend to have a processor of another kind."""

    def pretend(flags: str, maker: str = "GenuineIntel", architecture: str = "x86_64") -> None:
        values = {"flags": flags, "vendor_id": maker, "model name": "any"}
        monkeypatch.setattr(machine, "cpuinfo", lambda field: values[field])
        monkeypatch.setattr(machine.platform, "machine", lambda: architecture)
        machine.kernels.cache_clear()

    yield pretend
    monkeypatch.undo()
    machine.kernels.cache_clear()


@pytest.fixture
def refused(capsys) -> Callable[..., str]:
    """Run a command that must fail, and give the one line that it says."""

    def run(*arguments: str) -> str:
        assert main([*arguments]) == 1
        found = capsys.readouterr()
        assert found.out == ""
        (line,) = found.err.splitlines()
        return line

    return run


@pytest.fixture(scope="module")
def constant_code():
    """The same code for every stage, which takes no time to read."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entries, "code_of", lambda entry: Code(entry, "source", {}))
        yield


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "artefacts")
