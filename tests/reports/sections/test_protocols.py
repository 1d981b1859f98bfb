"""The sections about protocols, from the files that their stages write."""

import base64

from slider.config.convert import to_dict
from slider.reports.page import content
from slider.reports.table import Table, Tables, Text
from tests.evaluation.test_segments import protocol
from tests.reports.protocols import test_cases, test_segments, test_speeds
from tests.reports.sections.sources import html, pick, sources


def section(name, out, evaluations, settings):
    inputs = {name: [out], f"{name}.evaluations": evaluations}
    configuration, labels = {"protocols": {name: settings}}, {"policy": "policy (ours)"}
    return content(name, sources(inputs, configuration=configuration, labels=labels))


def sweep(folder):
    _, out = test_speeds.write(folder, "one")
    settings = test_speeds.section()["evaluation"]
    settings.pop("profile")  # as the pipeline does with what a protocol does not use
    return section("sweep", out, test_speeds.folders(folder, "one"), settings), out


def joystick(folder, fall=False):
    _, _, out = test_segments.run(folder, fall)
    return section("joystick", out, [folder / "a"], to_dict(protocol()))


def test_constant_commands_have_the_tables_of_table_1_and_the_speeds(tmp_path):
    section, _ = sweep(tmp_path)
    found = {
        table.caption: [[cell.text for cell in row] for row in table.rows]
        for table in pick(section, Tables)[0].tables
    }
    assert found["Mean speed [m/s]"] == [["0.2", "1.469 ± 0.335"], ["3.0", "–"]]
    assert found["Success rate"] == [
        ["0.2", "100.0 % ± 0.0 [51.0, 100.0]"],
        ["3.0", "0.0 % ± 0.0 [0.0, 49.0]"],
    ]
    (highest,) = pick(section, Table)
    assert [cell.text for cell in highest.rows[0]] == ["policy (ours)", "none", "none"]
    tables = pick(section, Tables)[0].tables
    best = [cell.best for table in tables for row in table.rows for cell in row]
    assert not any(best)  # of one controller


def test_the_figure_is_the_one_of_the_stage_on_a_card_of_its_own(tmp_path):
    section, out = sweep(tmp_path)
    drawn = base64.b64encode((out / "sweep.svg").read_bytes()).decode()
    assert f'<img class="card" src="data:image/svg+xml;base64,{drawn}"' in html(sweep=section)


def test_a_changing_command_has_a_row_per_segment(tmp_path):
    section = joystick(tmp_path)
    (table,) = pick(section, Table)
    assert table.caption == "policy (ours)"
    turn = [cell.text for cell in table.rows[1]]
    assert turn[1:5] == ["turn", "0.4, 0, 0.3", "75", "0.167"]
    assert "data:image/svg+xml" in html(joystick=section)


def test_where_all_fall_there_are_no_numbers(tmp_path):
    (table,) = pick(joystick(tmp_path, fall=True), Table)
    assert {cell.text for row in table.rows for cell in row[4:]} == {"–"}
    assert {row[3].text for row in table.rows} == {"0"}


def test_cases_have_a_row_each_in_the_table_of_their_kind(tmp_path):
    _, _, out = test_cases.write(tmp_path, [True] * 4)
    evaluations = [tmp_path / "e0", tmp_path / "e1"]
    found = section("heldout", out, evaluations, to_dict(test_cases.protocol()))
    standing, sideways = pick(found, Table)
    ((stop,), (side,)) = standing.rows, sideways.rows
    assert [cell.text for cell in stop[:4]] == [
        "stop from 0.4 m/s",
        "10",
        "100 [51, 100]",
        "75 [30.1, 95.4]",
    ]
    assert side[0].text == "0.4 m/s leftward"
    assert "stay below 0.1 m/s" in " ".join(html(heldout=found).split())
    assert "Seeds" in pick(found, Text)[0].markdown
