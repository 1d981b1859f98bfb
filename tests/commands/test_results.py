"""``slider results`` fills pages from reports and names their origin."""

import sys
from pathlib import Path

import pytest

from slider import cli
from slider.artefacts.plan import JobSpec, build_plan, write_plan
from slider.artefacts.recipe import Code
from slider.artefacts.store import Store
from slider.commands import results
from slider.commands.results import BLOCKS, MARKED, changed_since
from tests.artefacts.samples import compute

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
TABLE = """\
# Table 1

Text.

## Success rate

| command [m/s] | policy (ours) |
|---|---|
| 0.2 | **99.6 %** |

## Velocity MSE [m²/s²]

| command [m/s] | policy (ours) |
|---|---|
| 0.2 | 0.00271 |
"""
QUALITY = "controller,label,speed,flight,slip\npolicy,ours,0.2,0,0.02\nother,not shown,0.2,0,0\n"
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
def todays(tmp_path, monkeypatch) -> dict[str, str]:
    """Reports, a store whose job wrote the table, today's plan digests without Snakemake."""
    monkeypatch.chdir(tmp_path)
    Path("reports").mkdir()
    for name, text in (("table1.md", TABLE), ("table1.csv", "v\n"), ("sweep.md", TABLE)):
        Path("reports", name).write_text(text)
    job = JobSpec("table1", "table 1", Code("", "", {}), {})
    compute(Store(Path("artefacts")), job, metadata=METADATA, table1=TABLE)
    write_plan(build_plan({"table1": job}), Path("artefacts/plans"))
    digests = dict(job.plan_digests)
    monkeypatch.setattr(results, "_todays_digests", lambda *command: {"table1": digests})
    return digests


def filled(*names: str, status: int = 0) -> list[str]:
    """Lines of a README with the blocks."""
    marks = "\n".join(f"<!-- results: {name} -->\n<!-- /results -->" for name in names)
    Path("README.md").write_text(f"# Results\n\n{marks}\n\nText.\n")
    assert cli.main(["results"]) == status
    return Path("README.md").read_text().splitlines()


def test_a_block_has_the_reports_tables_and_their_origin():
    lines = filled("table1")
    headings = [line for line in lines if line.startswith("**")]
    assert headings == ["**Success rate**", "**Velocity MSE [m²/s²]**"]
    assert "| 0.2 | **99.6 %** |" in lines
    assert "# Table 1" not in lines
    assert lines[-1] == "Text."
    (origin,) = (line for line in lines if line.startswith("Made by `snakemake -j2 reports/table1"))
    assert origin.endswith(
        ", commit `01234567`, 2026-11-23, 2 min of processor time, Processor X, 2 cores, Linux."
    )


HEAD = "controller,label,source,speed,success_rate,tracking_rate,mse_steady,mse\n"
RUNS = """\
seed,speed,success_rate,tracking_rate,mse_steady,samples_to_walk
1,0.2,1,1,0.000421,
2,0.2,1,1,0.000275,
3,0.2,1,0.9,0.000300,
1,,,,,2457600
"""


def test_the_summary_has_lower_rates_and_the_papers_error():
    ours = "policy,ours,measured,0.2,0.996,0.9,0.00271,0.01\nhzd,HZD,measured,0.2,1,1,0.5,1\n"
    printed = "guided_drl,guided RL (paper),paper,0.2,0.731,,,0.0317\n"
    printed += "guided_drl,guided RL (paper),paper,0.4,1,,,0.0222\n"  # which ours was not at
    Path("reports/table1.csv").write_text(HEAD + ours + printed)
    shown = filled("summary")[6:9]
    heading = "| Velocity MSE after the warm-up [m²/s²] |"
    assert shown[0] == f"{heading} ours | **0.00271** (99.6 % survive, 90 % track) | – |"
    assert shown[1] == "|  | HZD | 0.500 | – |"
    assert shown[2] == "|  | guided RL (paper) | 0.0317 (73.1 % survive) | 0.0222 |", (
        "it prints no tracking"
    )


def test_the_overview_has_median_and_range_of_the_trainings(capsys):
    ours, hzd = "policy,ours,measured,0.2,1,1,9,9\n", "hzd,HZD,measured,0.2,1,1,0.5,1\n"
    Path("reports/table1.csv").write_text(HEAD + ours + hzd)
    assert filled("overview")[2:4] == ["<!-- results: overview -->", "<!-- /results -->"]
    command = "snakemake -j2 reports/table1.csv reports/seeds.csv"
    line = f"slider results: overview is unchanged, no reports/seeds.csv: {command}\n"
    assert capsys.readouterr().err == line
    Path("reports/seeds.csv").write_text("v\n")
    Path("reports/seeds_runs.csv").write_text(RUNS)
    lines = filled("overview")
    assert lines[6].endswith("| ours, median of 3 trainings | **0.000300** (90 % track) |")
    assert lines[7:9] == ["|  | range | 0.000275–0.000421 |", "|  | HZD | 0.500 |"]
    assert lines[10].startswith("Made by `snakemake -j2 reports/table1.csv reports/seeds.csv`")


def test_seeds_at_other_speeds_than_table_1_are_one_line(capsys):
    Path("reports/table1.csv").write_text(f"{HEAD}policy,ours,measured,0.4,1,1,9,9\n")
    Path("reports/seeds.csv").write_text("v\n")
    Path("reports/seeds_runs.csv").write_text(RUNS)
    filled("overview", status=1)
    line = "seeds_runs.csv: expected the speeds of table1.csv, [0.4], found [0.2]"
    assert line in capsys.readouterr().err


def test_trainings_have_an_interval_to_the_mpc():
    Path("reports/table1.csv").write_text(f"{HEAD}mpc_wbc_tuned,MPC,measured,0.2,1,1,0.0001,1\n")
    Path("reports/seeds.csv").write_text("v\n")
    Path("reports/seeds_runs.csv").write_text(RUNS)
    assert filled("trainings")[6:8] == [
        "| Success rate [%] | no difference |",
        "| Velocity MSE after the warm-up [m²/s²] | +0.000175 to +0.000321 |",
    ]


ROBOTS = {"a": (1.0, 0.2), "a_b": (0.9, 0.3), "a_hzd": (0.5, 0.1), "a_b_hzd": (0.4, 0.0)}


@pytest.mark.parametrize("speeds", [(0.2,), (0.2, 0.4)])
def test_robots_have_a_row_each_and_their_controllers_beside_the_policy(speeds):
    rows = "variant,label,changes,speed,metric,mean\n"
    for variant, rates in ROBOTS.items():
        name, ends = variant.removesuffix("_hzd"), variant.endswith("_hzd")
        label, changes = (f'"{name}, HZD"', "") if ends else (name, f"robot={name}")
        for name, rate in zip(("success_rate", "tracking_rate"), rates, strict=True):
            for speed in speeds:
                rows += f"{variant},{label},{changes},{speed},{name},{rate * speed / speeds[0]}\n"
    Path("reports/robots.csv").write_text(rows)
    lines = filled("robots")
    heads, _, *robots = lines[lines.index("<!-- results: robots -->") + 2 :][:4]
    cells = " | ".join(
        ("100/20 200/40", "50/10 100/20") if len(speeds) > 1 else ("100/20", "50/10")
    )
    assert heads == "| robot | overrides | policy (ours) | HZD |"
    assert robots[0] == f"| a | `robot=a` | {cells} |"
    assert robots[1].startswith("| a_b | `robot=a_b` | 90/30")
    assert "| 40/0" in robots[1]


def test_a_picture_is_copied_beside_the_pages():
    Path("reports/figures").mkdir()
    Path("reports/figures/tradeoff.svg").write_text("<svg/>")
    lines = filled("tradeoff")
    assert lines[4].endswith("(docs/images/tradeoff.svg)")
    assert lines[6].startswith("Made by `snakemake -j2 reports/figures/tradeoff.svg`")
    assert Path("docs/images/tradeoff.svg").read_text() == "<svg/>"


def test_times_are_those_of_the_jobs_before():
    Path("reports/table1.csv").write_text(TABLE)
    assert "| table 1 | 1 | 2 | 1.5 | 2.0 |" in filled("times")


def test_quantities_are_down_and_speeds_across(monkeypatch):
    monkeypatch.setattr(results, "_WALKING", ("flight", "slip"))
    Path("reports/gait_quality.csv").write_text(QUALITY)
    lines = filled("learning")
    assert lines[4] == "| command [m/s] |  | 0.2 |"
    assert lines[6:8] == [
        "| Flight [% of time] | ours | 0 |",
        "| Slip of loaded heels and toes [cm/s] | ours | 2.00 |",
    ]


def test_a_second_run_and_an_edit_by_hand_end_in_the_same_bytes(capsys):
    filled("table1", "sweep")
    before = Path("README.md").read_text()
    assert before.count("**Velocity MSE [m²/s²]**") == 1, "of the sweep the first table alone"
    Path("README.md").write_text(before.replace("99.6", "100"))
    assert cli.main(["results"]) == 0
    assert Path("README.md").read_text() == before
    capsys.readouterr()
    assert cli.main(["results"]) == 0
    assert capsys.readouterr().out == ""


def test_a_run_with_another_config_replaces_no_table(capsys):
    filled("table1")
    before = Path("README.md").read_text()
    snow = before.replace("on ice", "on snow")
    Path("README.md").write_text(snow)
    assert cli.main(["results"]) == 0
    assert Path("README.md").read_text() == before, "of the same settings"
    other = snow.replace("settings ", "settings 0")
    Path("README.md").write_text(other)
    assert [cli.main(["results", *page]) for page in ([], ["README.md"])] == [0, 1]
    assert MARKED.search(Path("README.md").read_text())[0].startswith(other[11:200])
    line = f"found hydra={METADATA['overrides']}; empty the block to replace it"
    assert line in capsys.readouterr().err


def test_a_table_of_another_plan_says_so_and_is_listed(todays, monkeypatch, capsys):
    """A plan that cannot be laid out here changes no sentence."""
    assert not any("Since then" in line for line in filled("table1"))
    assert cli.main(["results", "--check"]) == 0
    for part, change in (("source", "the source has"), ("settings", "settings have")):
        todays[part] = "another"
        before = Path("README.md").read_text()
        capsys.readouterr()
        assert cli.main(["results", "--check"]) == 1
        assert capsys.readouterr().out == f"README.md: table1: {change} changed\n"
        assert Path("README.md").read_text() == before
        assert cli.main(["results", "README.md"]) == 0
        (origin,) = (o for o in Path("README.md").read_text().splitlines() if "Made by" in o)
        assert origin.endswith(f", Linux. Since then {change} changed.")
    before = Path("README.md").read_text()
    Path("reports/table1.md").unlink()  # else the table is filled anew
    monkeypatch.setattr(results, "_todays_digests", lambda *command: {})
    assert cli.main(["results", "README.md"]) == 0
    assert Path("README.md").read_text() == before


def test_a_table_of_two_reports_has_the_plans_of_both(todays, monkeypatch):
    plans = {"table1": todays, "seeds": {"settings": "123", "source": "345"}}
    monkeypatch.setattr(results, "_todays_digests", lambda *command: plans)
    mark = filled("table1")[-3].removesuffix(" -->")
    for seeds, change in (("34", ""), ("35", "the source has changed")):
        block = f"Made by `snakemake`.\n\n{mark} seeds settings 12 source {seeds} -->"
        assert changed_since(block) == change


def test_a_table_whose_plan_is_gone_may_be_of_other_settings(todays, capsys):
    for path in Path("artefacts/plans").iterdir():
        path.unlink()
    (origin,) = (line for line in filled("table1") if "Made by" in line)
    assert origin.endswith(" Since then settings may have changed.")


def test_tables_of_readme_and_results_say_what_changed_since(monkeypatch, capsys):
    """Settings as on any machine, source as with the Python that filled the pages.

    Table 1 is of today's settings.
    """
    monkeypatch.undo()
    monkeypatch.chdir(ROOT)
    cli.main(["results", "--check", "README.md", "docs/reference/results.md"])
    for line in capsys.readouterr().out.splitlines():
        page, block, change = line.split(": ")
        assert block not in ("summary", "table1") or "settings" not in change, line
        text = next(m[0] for m in MARKED.finditer(Path(page).read_text()) if m[2] == block)
        assert sys.version_info[:2] != (3, 11) or f"Since then {change}." in text, (
            f"{line}: run slider results"
        )


def test_every_block_is_shown_somewhere():
    shown = {match[2] for page in PAGES for match in MARKED.finditer(page.read_text())}
    assert set(BLOCKS) <= shown


def test_a_report_of_another_version_is_one_line(capsys):
    filled("summary", status=1)
    assert "expected the column 'controller' in reports/table1.csv" in capsys.readouterr().err
