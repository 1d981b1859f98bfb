"""``slider results`` fills pages from reports and says where these come from."""

from pathlib import Path

import pytest

from slider import cli
from slider.artefacts.manifest import Manifest, Result
from slider.artefacts.store import Store
from slider.core import files
from slider.reports.results.blocks import find

TABLE = """\
controller,label,source,command_velocity,success_rate,success_low,success_high,mse,mse_steady,tracking_rate
policy,policy (ours),measured,0.2,0.996,0.99,0.998,0.0314,0.00271,0.9
policy,policy (ours),measured,3,0,0,0.004,inf,inf,0
guided_drl,guided RL (paper),paper,0.2,1,,,0.0317,,
guided_drl,guided RL (paper),paper,3,0.731,,,1.6,,
"""
PAGE = "# Results\n\n<!-- results: table1 -->\n<!-- /results -->\n\nText.\n"


@pytest.fixture
def workspace(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("README.md").write_text(PAGE)
    Path("reports").mkdir()
    Path("reports/table1.csv").write_text(TABLE)
    return tmp_path


def results() -> int:
    return cli.main(["results"])


def body(page: str = "README.md") -> str:
    return find(Path(page).read_text())[0].body


def store_table(text: str) -> None:
    """A job of the store that wrote the table, and a copy of it in reports/."""
    store = Store(Path("artefacts"))
    with store.temporary("table1") as folder:
        (folder / "table1.csv").write_text(text)
        result = store.publish(folder, {})
    recipe = "ab" * 32
    store.write_manifest(Manifest("table1", recipe, {}, Result(result.object, result.files, {})))
    facts = {
        "commit": "0123456789abcdef",
        "dirty": "false",
        "ended": "2026-11-23T08:00:00.000+00:00",
        "machine": "Processor X, 2 cores, Linux",
        "overrides": "evaluation.controllers=[policy] env.label='on ice'",
    }
    files.write_json(store.sidecar_path("table1", recipe), facts)


def test_a_block_is_filled_with_numbers_as_people_read_them(workspace):
    assert results() == 0
    lines = body().splitlines()
    assert lines[0] == "| command [m/s] |  | 0.2 | 3.0 |"
    assert "| Success rate [%] | policy (ours) | 99.6 [99, 99.8] | 0 [0, 0.4] |" in lines
    assert "| Velocity MSE after the warm-up [m²/s²] | policy (ours) | 0.00271 | ∞ |" in lines
    assert "| MSE as the paper prints it [m²/s²] | guided RL (paper) | 0.0317 | 1.60 |" in lines
    assert Path("README.md").read_text().endswith("\n\nText.\n")


def test_the_line_below_tells_command_commit_date_and_machine_of_the_job(workspace):
    store_table(TABLE)
    assert results() == 0
    assert body().splitlines()[-1] == (
        "Made by `snakemake -j2 reports/table1.csv --config "
        """hydra='evaluation.controllers=[policy] env.label='"'"'on ice'"'"' '`, """
        "commit `01234567`, "
        "2026-11-23, Processor X, 2 cores, Linux."
    )


@pytest.mark.parametrize("stored", [True, False])
def test_the_same_files_change_nothing(workspace, capsys, monkeypatch, stored):
    if stored:
        store_table(TABLE)
    assert results() == 0
    before = Path("README.md").read_bytes()
    capsys.readouterr()
    monkeypatch.setattr("slider.reports.results.origin.revision", lambda: {"commit": "f" * 40})
    assert results() == 0
    assert Path("README.md").read_bytes() == before
    assert capsys.readouterr().out == ""


def test_an_edit_by_hand_is_written_over(workspace):
    assert results() == 0
    page = Path("README.md")
    before = page.read_text()
    page.write_text(before.replace("99.6", "100"))
    assert results() == 0
    assert page.read_text() == before


def test_without_the_report_a_block_stays_and_one_line_tells_the_command(workspace, capsys):
    Path("reports/table1.csv").unlink()
    assert results() == 0
    assert Path("README.md").read_text() == PAGE
    assert capsys.readouterr().err == (
        "slider results: table1 stays as it is, reports/table1.csv is missing: "
        "snakemake -j2 reports/table1.csv\n"
    )


def test_an_unknown_block_is_one_line_and_nothing_is_written(workspace, capsys):
    (workspace / "docs").mkdir()
    Path("docs/page.md").write_text("<!-- results: table2 -->\n<!-- /results -->\n")
    assert results() == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "docs/page.md: expected a result block of table1" in error
    assert "found 'table2'" in error
    assert Path("README.md").read_text() == PAGE


def test_a_report_of_another_version_is_one_line(workspace, capsys):
    Path("reports/table1.csv").write_text("controller,command_velocity\npolicy,0.2\n")
    assert results() == 1
    assert "expected a column 'source' in reports/table1.csv" in capsys.readouterr().err
