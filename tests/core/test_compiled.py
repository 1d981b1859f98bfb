"""Compiled functions: their arithmetic is IEEE's; their cache serves one source."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from slider.core.compiled import compiled

SHIFT = 1.0


def rise(values: np.ndarray, slope: float) -> None:
    """A product and a sum that a processor could fuse."""
    for i in range(len(values)):
        values[i] = values[i] * slope + SHIFT


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def compilations() -> int:
    """Number of compilations that a call takes; its results are NumPy's."""
    function, values = compiled(rise), np.linspace(0.1, 2.0, 37)
    expected = values * (1.0 / 3.0) + SHIFT
    function(values, 1.0 / 3.0)
    np.testing.assert_array_equal(values, expected)
    return len(function.stats.cache_misses)


def test_cache_serves_one_source_and_its_constants(cache, monkeypatch):
    assert compilations() == 1
    assert compilations() == 0
    monkeypatch.setitem(globals(), "SHIFT", 2.0)
    assert compilations() == 1
    assert len(list(cache.iterdir())) == 2, "one for each value of a constant"


def test_function_compiles_where_nothing_can_be_written(cache):
    cache.write_text("no folder")
    function, values = compiled(rise), np.ones(2)
    function(values, 2.0)
    np.testing.assert_array_equal(values, 3.0)


@pytest.mark.parametrize("hidden", ["variable", "file"])
def test_hidden_settings_of_numba_do_not_apply(hidden, cache, tmp_path, monkeypatch):
    if hidden == "variable":
        monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    else:
        (tmp_path / ".numba_config.yaml").write_text("disable_jit: 1\n")
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    imports = "import slider.core.compiled, numba.core.config as c"
    program = f"{imports}; print(c.DISABLE_JIT, c.CPU_NAME)"
    command = [sys.executable, "-c", program]
    printed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert printed.stdout.split()[0] == "0"
    assert printed.stdout.split()[1] != "generic"


def test_instructions_are_those_of_any_processor_with_avx2(cache):
    function = compiled(rise)
    function(np.zeros(3), 2.0)
    (code,) = function.inspect_asm().values()
    assert "ymm" in code
    assert "zmm" not in code
    assert "vfmadd" not in code, "a fused sum rounds once"
