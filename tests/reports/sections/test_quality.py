"""How it walks: a table per controller, turned over."""

from slider.reports.sections.quality import quality_tables

CSV = """controller,command_velocity,flight,clearance,new_quantity
policy,0.2,0.0244,0.09,1
policy,1.2,0.00001,,2
mpc_wbc_tuned,0.2,0,0.06,3
"""


def test_no_number_of_the_file_is_left_out(tmp_path):
    path = tmp_path / "gait_quality.csv"
    path.write_text(CSV)
    ours, baseline = quality_tables(path)
    assert (ours.caption, baseline.caption) == ("policy (ours)", "MPC + WBC, tuned")
    assert list(ours.columns) == ["at a command of [m/s]", "0.2", "1.2"]
    assert [[cell.text for cell in row] for row in ours.rows] == [
        ["flight, share of time", "0.0244", "< 0.0001"],
        ["foot clearance [m]", "0.09", "–"],
        ["new_quantity", "1", "2"],
    ]
    assert [cell.text for cell in baseline.rows[0]] == ["flight, share of time", "0"]
    assert not ours.sortable  # its rows have different units
