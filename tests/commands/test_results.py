"""``slider results`` fills pages from reports and names their origin."""

from pathlib import Path

import pytest

from slider import cli
from slider.artefacts.plan import JobSpec
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.commands.results import BLOCKS, MARKED
from tests.artefacts.samples import compute

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
TABLE = """\
controller,label,source,speed,success_rate,success_low,success_high,mse,mse_steady,tracking_rate
policy,policy (ours),measured,0.2,0.996,0.99,0.998,0.0314,0.00271,0.9
policy,policy (ours),measured,3,0,0,0.004,inf,inf,0
guided_drl,guided RL (paper),paper,0.2,1,,,0.0317,,
guided_drl,guided RL (paper),paper,3,0.731,,,1.6,,
"""
REPORT = """\
# Sweep: sweep

| controller | highest |
|---|---|
| policy | 3.0 |

## Mean speed [m/s]

| command [m/s] | policy |
|---|---|
| 3.0 | 2.9 |
"""
METADATA = {
    "commit": "0123456789abcdef",
    "dirty": "false",
    "ended": "2026-11-23T08:00:00.000+00:00",
    "machine": "Processor X, 2 cores, Linux",
    "overrides": "evaluation.controllers=[policy] env.label='on ice'",
    "wall_s": 90.0,
    "cpu_s": 120.0,
    "threads": 2,
}


@pytest.fixture(autouse=True)
def workspace(tmp_path, monkeypatch) -> Path:
    """Reports, and a store whose job wrote the table."""
    monkeypatch.chdir(tmp_path)
    Path("reports").mkdir()
    Path("reports/table1.csv").write_text(TABLE)
    Path("reports/sweep.md").write_text(REPORT)
    job = JobSpec("table1", "table 1", Code("", "", {}), {})
    compute(Store(Path("artefacts")), job, metadata=METADATA, table1=TABLE)
    return tmp_path


def filled(*names: str, status: int = 0) -> list[str]:
    """Lines of a README with the blocks."""
    marks = "\n".join(f"<!-- results: {name} -->\n<!-- /results -->" for name in names)
    Path("README.md").write_text(f"# Results\n\n{marks}\n\nText.\n")
    assert cli.main(["results"]) == status
    return Path("README.md").read_text().splitlines()


def test_table1_has_numbers_as_people_read_them_and_its_origin():
    lines = filled("table1")
    assert lines[4] == "| command [m/s] |  | 0.2 | 3.0 |"
    assert "| Success rate [%] | policy (ours) | 99.6 [99, 99.8] | 0 [0, 0.4] |" in lines
    assert "|  | guided RL (paper) | 100 | 73.1 |" in lines
    assert "| Velocity MSE after the warm-up [m²/s²] | policy (ours) | 0.00271 | ∞ |" in lines
    assert "| Tracking rate [%] | policy (ours) | 90 | 0 |" in lines
    assert lines[-1] == "Text."
    (origin,) = (line for line in lines if line.startswith("Made by `snakemake -j2 reports/table1"))
    assert origin.endswith(", commit `01234567`, 2026-11-23, Processor X, 2 cores, Linux.")


def test_the_summary_has_lower_tracking_rates_the_papers_error_and_the_range_of_all_trainings():
    runs = "seed,speed,mse_steady\n1,,\n1,0.2,0.000421\n2,0.2,0.000275\n1,3,0.0178\n2,3,0.0104\n"
    Path("reports/seeds_runs.csv").write_text(runs)
    lines = filled("summary", "times")
    assert "| Success rate [%] | policy (ours) | 99.6 (90) | 0 |" in lines
    assert "|  | guided RL (paper) | 100 | 73.1 |" in lines, "it prints no tracking rate"
    assert "|  | guided RL (paper) | 0.0317 | 1.60 |" in lines
    assert "|  | policy (ours), seeds 1, 2 | 0.00028–0.00042 | 0.010–0.018 |" in lines
    assert "| table 1 | 1 | 2 | 1.5 | 2.0 |" in lines


def test_a_second_run_and_an_edit_by_hand_end_in_the_same_bytes(capsys):
    filled("table1", "sweep")
    before = Path("README.md").read_text()
    assert "**Mean speed [m/s]**" not in before
    Path("README.md").write_text(before.replace("99.6", "100"))
    assert cli.main(["results"]) == 0
    assert Path("README.md").read_text() == before
    capsys.readouterr()
    assert cli.main(["results"]) == 0
    assert capsys.readouterr().out == ""


def test_without_the_report_a_block_stays_and_one_line_names_the_command(capsys):
    before = filled("heldout")
    assert before[2:4] == ["<!-- results: heldout -->", "<!-- /results -->"]
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "snakemake -j2 reports/heldout.csv" in error


def test_a_report_of_another_version_is_one_line(capsys):
    Path("reports/table1.csv").write_text("controller,label,speed\npolicy,p,0.2\n")
    filled("table1", status=1)
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "expected the column 'success_rate' in reports/table1.csv" in error


def test_every_block_is_shown_somewhere():
    shown = {match[2] for page in PAGES for match in MARKED.finditer(page.read_text())}
    assert set(BLOCKS) <= shown
