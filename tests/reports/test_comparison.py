"""Table 1 side by side: who is best, what is printed, and the same in documents."""

import math

import pytest

from slider.reports.comparison import METRICS, compare, comparisons
from slider.reports.table import escape, markdown

NAN = math.nan
SUCCESS, STEADY, WHOLE, TRACKING = METRICS


def row(controller, command, source="measured", **values):
    names = ("success_rate", "mse", "mse_steady", "tracking_rate")
    names = [*names, *(f"{name}_std" for name in names), "success_low", "success_high"]
    cells = dict.fromkeys(names, NAN)
    cells |= {
        "controller": controller,
        "label": f"{controller} of {source}",
        "source": source,
        "speed": command,
    }
    return cells | values


ROWS = [
    row("policy", 1.0, success_rate=1, success_rate_std=0, mse=0.0246, mse_steady=0.00271),
    row("mpc_wbc_tuned", 1.0, success_rate=0.5, mse=0.5, mse_steady=0.4),
    row("policy", 0.2, success_rate=1, mse=0.001, mse_steady=0.0005),
    row("guided_drl", 0.2, "paper", success_rate=1, mse=0.0317),
    row("guided_drl", 1.0, "paper", success_rate=1, mse=0.0221),
    row("mpc_wbc", 1.0, "paper", success_rate=0, mse=math.inf),
]


def test_commands_are_sorted_and_controllers_keep_the_order_of_the_table():
    table = compare(ROWS, SUCCESS)
    assert [row[0].key for row in table.rows] == [0.2, 1.0]
    assert table.columns[1] == "policy of measured"
    assert len(table.columns) == 1 + 4
    assert table.rows[0][2].text == "–"  # not evaluated at 0.2 m/s


def test_marks_all_who_share_the_best_value():
    best = [cell.best for cell in compare(ROWS, SUCCESS).rows[1][1:]]
    assert best == [True, False, True, False]


def test_the_paper_can_win():
    best = [cell.best for cell in compare(ROWS, WHOLE).rows[1][1:]]
    assert best == [False, False, True, False]


def test_an_error_of_few_survivors_is_not_the_best():
    for success, wins in ((0.001, False), (0.995, True)):
        rows = [*ROWS, row("other", 1.0, success_rate=success, mse=1e-6)]
        best = [cell.best for cell in compare(rows, WHOLE).rows[1][1:]]
        assert best == [False, False, not wins, False, wins]


def test_the_papers_error_stands_beside_both_of_ours():
    steady, whole = compare(ROWS, STEADY).rows[1], compare(ROWS, WHOLE).rows[1]
    assert steady[3].key == whole[3].key == 0.0221
    assert (steady[1].key, whole[1].key) == (0.00271, 0.0246)


def test_a_metric_that_the_paper_does_not_have_is_ours_alone():
    rows = [row("policy", 1.0, tracking_rate=0.9), *ROWS[3:]]
    assert compare(rows, TRACKING).columns[1:] == ["policy of measured"]


def test_nobody_is_best_where_nobody_survives():
    rows = [row("policy", 1.0, mse=math.inf), row("mpc_wbc", 1.0, "paper", mse=math.inf)]
    assert not any(cell.best for cell in compare(rows, WHOLE).rows[0])


@pytest.mark.parametrize(
    ("value", "spread", "metric", "text"),
    [
        (0.996, 0.00516, SUCCESS, "99.6 % ± 0.5"),
        (1.0, math.nan, SUCCESS, "100.0 %"),
        (0.000461344, 1.9e-5, STEADY, "0.000461 ± 0.000019"),
        (0.0217, math.nan, WHOLE, "0.0217"),
        (1.6, math.nan, WHOLE, "1.60"),
        (0.0, math.nan, WHOLE, "0.000"),
        (math.inf, math.nan, WHOLE, "∞"),
    ],
)
def test_prints_three_digits(value, spread, metric, text):
    cells = {metric: value, f"{metric}_std": spread}
    assert compare([row("policy", 1.0, **cells)], metric).rows[0][1].text == text


def test_success_has_its_interval_and_the_papers_has_none():
    rows = [row("policy", 1.0, success_rate=0.996, success_low=0.98981, success_high=0.99844)]
    rows.append(row("guided_drl", 1.0, "paper", success_rate=1, mse=0.0221))
    _, ours, papers = compare(rows, SUCCESS).rows[0]
    assert ours.text == "99.6 % [99.0, 99.8]"
    assert papers.text == "100.0 %"
    assert (ours.best, papers.best) == (False, True)
    assert "99.6 \\% [99.0, 99.8]" in compare(rows, SUCCESS).latex


def test_of_one_controller_nothing_is_best():
    assert not any(cell.best for cell in compare(ROWS[:1], SUCCESS).rows[0])


def test_markdown_has_one_row_per_command_and_metric():
    lines = markdown(comparisons(ROWS)).splitlines()
    assert "| 1.0 | 0.0246 | 0.500 | **0.0221** | ∞ |" in lines
    assert sum(line.startswith("| 0.2 |") for line in lines) == len(METRICS)


def test_latex_is_escaped_and_balanced():
    text = "".join(table.latex for table in comparisons(ROWS))
    assert "0.0246 & 0.500 & \\textbf{0.0221} & $\\infty$ \\\\" in text
    assert "100.0 \\%" in text
    assert text.count("\\begin{tabular}") == text.count("\\end{tabular}") == len(METRICS)
    assert not any(character in text for character in "±∞²–")


def test_latex_reads_every_character():
    assert escape("A | B & <c>_1\\") == "A $|$ B \\& $<$c$>$\\_1\\textbackslash{}"
