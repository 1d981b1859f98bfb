"""``slider library``: what people read, also of their mistakes."""

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
