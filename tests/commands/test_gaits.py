"""``slider library`` and ``slider gait``: what people read, also of their mistakes."""

import re
import shutil
from pathlib import Path

import pytest

from slider.artefacts.manifest import Manifest
from slider.artefacts.plan import JobSpec, build_plan, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.cli import main
from tests.library.gaits import write_store

GAITS = [(0.0, 0.0), (0.5, 0.0), (0.6, 0.1)]
HOLES = [(0.6, 0.0)]
CODE = Code("slider.none:run", "abc", {})
STORE = Store(Path("artefacts"))


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> Path:
    return write_store(tmp_path_factory.mktemp("commands"), GAITS, HOLES)


@pytest.fixture
def job(monkeypatch, tmp_path: Path) -> JobSpec:
    """Of the library, in the plan of an empty store, in the working directory."""
    monkeypatch.chdir(tmp_path)
    gaits = [JobSpec("gait", "gait", CODE, {"velocity": [*v, 0.0]}) for v in [*GAITS, *HOLES]]
    job = JobSpec("library", "library", CODE, {}, {"gaits": gaits})
    write_plan(build_plan({"library": job}), STORE.root / "plans")
    return job


def publish(job: JobSpec, made: Path) -> None:
    """Put a library into the store as the result of a job."""
    with STORE.temporary("test") as out:
        shutil.copytree(made, out / "library.zarr")
        result = STORE.publish(out, {})
    STORE.write_manifest(Manifest(job.stage, job.recipe, {}, result))


def test_the_overview_has_grid_holes_ranges_and_the_worst_residual(library, capsys):
    assert main(["library", "show", "--library", str(library)]) == 0
    text = capsys.readouterr().out
    assert "3 of 4 gaits converged" in text
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


def test_without_a_store_or_a_library_it_says_what_makes_one(job, library, refused, capsys):
    for folder in (STORE.root, Path("nowhere")):
        text = refused("library", "show", "--artefacts", str(folder))
        assert "no library of the current configuration yet" in text
        assert "`snakemake -j2 gait_library`" in text
    publish(job, library)
    assert main(["library", "show"]) == 0
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
