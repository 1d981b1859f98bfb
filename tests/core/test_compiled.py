"""Compiled functions: their arithmetic is IEEE's, what is kept is found again, and no more."""

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
def kept(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    return tmp_path / "kept"


def compilations() -> int:
    """How many it takes to use the function; its answers are numpy's."""
    function, values = compiled(rise), np.linspace(0.1, 2.0, 37)
    expected = values * (1.0 / 3.0) + SHIFT
    function(values, 1.0 / 3.0)
    np.testing.assert_array_equal(values, expected)
    return len(function.stats.cache_misses)


def test_what_is_kept_serves_as_long_as_it_is_whole_and_of_this_source(kept, monkeypatch):
    assert compilations() == 1
    (path,) = kept.iterdir()
    assert compilations() == 0
    whole = path.read_bytes()
    for damaged in (b"", whole[:-1], whole[:-1] + bytes([whole[-1] ^ 1])):
        path.write_bytes(damaged)
        assert compilations() == 1
        assert len(path.read_bytes()) == len(whole)
    monkeypatch.setitem(globals(), "SHIFT", 2.0)
    assert compilations() == 1
    assert len(list(kept.iterdir())) == 2, "one for each value of a constant"


def test_where_nothing_can_be_kept_it_is_compiled(kept):
    kept.write_text("no folder")
    assert compilations() == 1


def test_instructions_are_those_of_any_processor_with_avx2(kept):
    function = compiled(rise)
    function(np.zeros(3), 2.0)
    (code,) = function.inspect_asm().values()
    assert "ymm" in code
    assert "zmm" not in code
    assert "vfmadd" not in code, "a fused sum rounds once"
