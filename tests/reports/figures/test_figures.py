"""The stage ``figures``: which files, that they repeat, and what they must show."""

import re
from itertools import product
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from slider.core.job import Job
from slider.library.reader import STORE, GaitLibrary
from slider.reports.figures import FILES, NAMES
from slider.reports.figures.cycles import draw as draw_cycles
from slider.reports.figures.cycles import forward_gaits
from slider.reports.figures.mapping import map_errors
from slider.reports.figures.maps import draw_map
from slider.reports.figures.stage import DRAWINGS, run
from slider.reports.figures.style import style
from tests.library.gaits import library as make_library
from tests.library.gaits import write_store

VELOCITIES = [*product((0.0, 0.5, 1.0), (-0.1, 0.0, 0.1)), (2.0, 0.0)]
HOLES = [(0.5, 0.0), (2.0, 0.1)]
GAITS = [velocity for velocity in VELOCITIES if velocity not in HOLES]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Object of a library with holes."""
    return write_store(tmp_path_factory.mktemp("figures"), GAITS, HOLES).parent


@pytest.fixture(scope="module")
def drawn(folder, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("drawn")
    assert run({}, {"library": [folder]}, out, Job(out)) == {"figures": len(NAMES)}
    return out


def test_writes_the_files_that_the_pipeline_publishes_without_dates_or_versions(drawn):
    assert {path.name for path in drawn.iterdir()} == set(FILES)
    assert set(DRAWINGS) == set(NAMES)
    for name in NAMES:
        assert not re.search("dc:date|matplotlib.org", (drawn / f"{name}.svg").read_text())
        assert f"({name}.svg)" in (drawn / f"{name}.md").read_text()


def test_the_same_library_gives_the_same_bytes(drawn, folder, tmp_path: Path):
    with matplotlib.rc_context({"font.size": 20, "svg.hashsalt": None}):  # someone's settings
        run({}, {"library": [folder]}, tmp_path, Job(tmp_path))
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (drawn / name).read_bytes(), name


def test_a_library_of_one_gait_can_be_drawn(tmp_path: Path):
    library = write_store(tmp_path / "library", [(0.0, -0.1)]).parent
    assert run({}, {"library": [library]}, tmp_path, Job(tmp_path)) == {"figures": len(NAMES)}
    assert set(FILES) <= {path.name for path in tmp_path.iterdir()}


def test_a_map_has_a_cell_per_gait_and_a_cross_per_hole(folder):
    library = GaitLibrary.load(folder / STORE)
    values = np.arange(len(library), dtype=float)
    axes = Figure().subplots()
    draw_map(axes, library, "eigenvalue", values, "1")
    (cells,) = axes.collections
    shown = cells.get_array()
    np.testing.assert_array_equal(np.sort(shown.compressed()), values)
    last = len(library) - 1  # the only gait at 2 m/s
    assert np.argwhere(shown == last).tolist() == [[1, 3]]
    assert axes.get_xlim() == (-0.25, 2.5)
    crosses = [line.get_xydata().ravel().tolist() for line in axes.lines]
    assert crosses == [[0.5, 0.0], [2.0, 0.1]]


def test_limit_cycles_are_closed_and_one_per_velocity(folder):
    library = GaitLibrary.load(folder / STORE)
    with style():
        axes = draw_cycles(library).axes[:6]
    gaits = forward_gaits(library, 9)
    assert library.velocities[gaits, :2].tolist() == [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]
    for panel in axes:
        assert len(panel.lines) == 4 * len(gaits)  # two steps, two touchdowns
        for start in range(0, len(panel.lines), 4):
            pieces = [line.get_xydata() for line in panel.lines[start : start + 4]]
            for piece, following in zip(pieces, [*pieces[1:], pieces[0]], strict=True):
                np.testing.assert_array_equal(piece[-1], following[0])


def test_forward_gaits_are_evenly_spread(tmp_path: Path):
    made = make_library(tmp_path, [(x / 10, y) for x in range(11) for y in (-0.05, 0.05)])
    chosen = made.velocities[forward_gaits(made, 5)]
    np.testing.assert_allclose(chosen[:, 0], [0, 0.25, 0.5, 0.75, 1.0], atol=0.051)
    assert len(set(chosen[:, 1])) == 1


def test_errors_of_equation_1_are_those_that_the_documents_state():
    errors = map_errors(np.linspace(0.1, 1.2, 200), 0.36, 0.36)
    assert np.abs(errors["hip"]).max() == pytest.approx(0.127, abs=1e-3)
    assert np.abs(errors["slide_rate"]).max() == pytest.approx(0.24, abs=5e-3)
    assert not errors["slide"].any()
