"""``slider library`` and ``slider gait``: what people read, also of their mistakes."""

import re
import shutil
from pathlib import Path

import pytest

from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import write_plan
from slider.cli import main
from tests.artefacts.samples import LIBRARY, PLAN
from tests.library.gaits import write_store

GAITS = [(0.0, 0.0), (0.5, 0.0), (0.6, 0.1)]
HOLES = [(0.6, 0.0)]


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> Path:
    return write_store(tmp_path_factory.mktemp("commands"), GAITS, HOLES)


def test_the_overview_has_grid_holes_ranges_and_the_worst_residual(library, capsys):
    assert main(["library", "show", "--library", str(library)]) == 0
    text = capsys.readouterr().out
    assert "3 of 4 gaits converged" in text
    assert re.search(r"^  vx +0(\.\d+)? +0\.\d+ +0\.6  m/s$", text, re.M)
    hole = "hole (0.6, 0) m/s: Infeasible_Problem_Detected; torso 0.3, at most 0 (3.0e-01 beyond); "
    assert f"{hole}impact" in text
    assert "worst residual: impact 1.0e-09" in text


def test_show_prints_a_summary(library, capsys):
    assert main(["gait", "show", "--vx", "0.5", "--library", str(library)]) == 0
    text = capsys.readouterr().out
    assert "gait (0.5, 0) m/s: Solve_Succeeded, 30 iterations" in text
    assert "step time    0.395 s" in text
    assert re.search(r"^    voltage +\d+\.\d\d of 1 of the bus .* %  (left|right)_\w+$", text, re.M)


def test_export_writes_the_gait(library, capsys, tmp_path: Path):
    out = tmp_path / "new" / "gait.csv"
    arguments = ["--vx", "0.6", "--vy", "0.1", "--library", str(library), "--out", str(out)]
    assert main(["gait", "export", *arguments]) == 0
    assert str(out) in capsys.readouterr().out
    assert len(out.read_text().splitlines()) == 43


def test_without_a_store_or_a_library_it_says_what_makes_one(store, library, refused, capsys):
    write_plan(PLAN, store.root / "plans")
    for folder in (store.root, Path("nowhere")):
        text = refused("library", "show", "--artefacts", str(folder))
        assert "no library of the current configuration yet" in text
        assert "`snakemake -j2 gait_library`" in text
    with store.temporary("test") as out:
        shutil.copytree(library, out / "library.zarr")
        result = store.publish(out, {})
    store.write_manifest(Manifest("library", LIBRARY.recipe, {}, result))
    assert main(["library", "show", "--artefacts", str(store.root)]) == 0
    assert "3 of 4 gaits" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vx", "0.52"], "found (0.52, 0) m/s; the nearest gait is at (0.5, 0) m/s"),
        (["--vx", "0.6"], "the gait (0.6, 0) m/s did not converge: Infeasible_Problem_Detected"),
        (["--vx", "0.5", "--library", "/tmp"], "expected a gait library at /tmp"),
    ],
)
def test_mistakes_are_one_line(library, refused, arguments, message):
    assert message in refused("gait", "show", "--library", str(library), *arguments)
