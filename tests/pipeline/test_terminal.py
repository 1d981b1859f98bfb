"""Table 1 in a few lines."""

from pipeline.terminal import Row, read_row, table

LABELS = {"policy": "policy (ours)"}


def test_a_column_per_command_and_infinity_where_none_survives():
    rows = [
        Row("policy (ours)", 0.2, 1.0, 0.000376945),
        Row("policy (ours)", 1.0, 0.998, 0.0054),
        Row("MPC", 1.0, 0.0, float("inf")),
    ]
    assert table(rows).splitlines() == [
        "command [m/s]                    0.2       1.0",
        "policy (ours)  success [%]       100      99.8",
        "               MSE [m²/s²]  0.000377    0.0054",
        "MPC            success [%]                   0",
        "               MSE [m²/s²]                   ∞",
    ]


def test_a_row_is_read_from_the_summary_of_an_evaluation():
    summary = {"controller": "policy", "command": 0.4, "success_rate": 0.5, "mse_steady": 0.1}
    assert read_row(LABELS, summary) == Row("policy (ours)", 0.4, 0.5, 0.1)
    assert read_row(LABELS, summary | {"mse_steady": None}) == Row(
        "policy (ours)", 0.4, 0.5, float("inf")
    )
