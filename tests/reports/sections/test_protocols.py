"""The sections about protocols, from the files that their stages write."""

import base64

from slider.config.convert import to_dict
from slider.reports.page import render_page
from slider.reports.sections import SECTIONS
from tests.evaluation.test_segments import protocol
from tests.reports.protocols import test_cases, test_segments, test_speeds
from tests.reports.sections.sources import sources


def sweep(folder):
    _, out = test_speeds.write(folder, "one")
    settings = test_speeds.section()["evaluation"]
    settings.pop("profile")  # as the pipeline does with what a protocol does not use
    given = sources({"sweep": [out]}, configuration={"protocols": {"sweep": settings}})
    return SECTIONS["sweep"](given), out


def joystick(folder, fall=False):
    _, _, out = test_segments.run(folder, fall)
    configuration = {"protocols": {"joystick": to_dict(protocol())}}
    return SECTIONS["joystick"](sources({"joystick": [out]}, configuration=configuration))


def test_constant_commands_have_the_tables_of_table_1_and_the_speeds(tmp_path):
    section, _ = sweep(tmp_path)
    found = {
        table.caption: [[cell.text for cell in row] for row in table.rows]
        for table in section.values["tables"]
    }
    assert found["Mean speed [m/s]"] == [["0.2", "1.469 ± 0.335"], ["3.0", "–"]]
    assert found["Success rate"] == [
        ["0.2", "100.0 % ± 0.0 [51.0, 100.0]"],
        ["3.0", "0.0 % ± 0.0 [0.0, 49.0]"],
    ]
    assert section.values["highest"] == [("policy (ours)", "none")]
    best = [cell.best for table in section.values["tables"] for row in table.rows for cell in row]
    assert not any(best)  # of one controller


def test_the_figure_is_the_one_of_the_stage_on_a_card_of_its_own(tmp_path):
    section, out = sweep(tmp_path)
    drawn = base64.b64encode((out / "sweep.svg").read_bytes()).decode()
    html = render_page("title", {}, {"sweep": section})
    assert f'<img class="card" src="data:image/svg+xml;base64,{drawn}"' in html


def test_a_changing_command_has_a_row_per_segment(tmp_path):
    section = joystick(tmp_path)
    (table,) = section.values["tables"]
    assert table.caption == "policy (ours)"
    turn = [cell.text for cell in table.rows[1]]
    assert turn[1:5] == ["turn", "0.4, 0, 0.3", "75%", "0.167"]
    assert "data:image/svg+xml" in render_page("title", {}, {"joystick": section})


def test_where_all_fall_there_are_no_numbers(tmp_path):
    (table,) = joystick(tmp_path, fall=True).values["tables"]
    assert {cell.text for row in table.rows for cell in row[4:]} == {"–"}
    assert {row[3].text for row in table.rows} == {"0%"}


def test_cases_have_a_row_each(tmp_path):
    _, _, out = test_cases.write(tmp_path, [True] * 4)
    configuration = {"protocols": {"heldout": to_dict(test_cases.protocol())}}
    section = SECTIONS["heldout"](sources({"heldout": [out]}, configuration=configuration))
    (table,) = section.values["tables"]
    stop, side = ([cell.text for cell in row] for row in table.rows)
    assert stop[:2] == ["stop from 0.4 m/s", "100.0 % [51.0, 100.0]"]
    assert stop[6] == "75.0 % [30.1, 95.4]"
    assert side[6:] == ["–", "–", "–"]
    html = render_page("title", {}, {"heldout": section})
    assert "stay below 0.1 m/s" in html
