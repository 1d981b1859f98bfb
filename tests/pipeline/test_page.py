"""What the page needs, and how this machine renders its films."""

import pytest

from pipeline.stages import page
from pipeline.targets import all_targets
from slider.artefacts.plan import build_plan
from slider.core.errors import UserError
from slider.reports.sections import SECTIONS
from tests.config.composed import CONF, composed


@pytest.mark.parametrize(
    ("devices", "libraries", "expected"),
    [(1, set(), "egl"), (0, {"libOSMesa.so.8"}, "osmesa"), (0, set(), "none")],
)
def test_takes_the_first_that_works(devices, libraries, expected, monkeypatch):
    monkeypatch.setattr(page, "_egl_devices", lambda: devices)
    monkeypatch.setattr(page, "_load", lambda name: name if name in libraries else None)
    config = page.with_renderer(composed("experiment=test"))
    assert config.report.video.renderer == expected


def stages(*overrides):
    given = ["experiment=test", *overrides]
    found = all_targets(composed(*given), given, CONF)
    jobs = build_plan(found).jobs.values()
    return {job.stage for job in jobs}, found["report"]


def test_without_a_renderer_there_is_a_page_and_no_video_job():
    found, _ = stages("report.video.renderer=none")
    assert "report" in found
    assert "video" not in found
    found, _ = stages("report.video.renderer=egl")
    assert "video" in found


def test_there_is_a_video_of_each_terrain_that_is_asked_for():
    terrain = "report.video={renderer: egl, terrain: {kinds: [tiles, rough], level: 5, speed: 0.8}}"
    _, page_job = stages(terrain)
    videos = [job.section for job in page_job.inputs["videos"]]
    kinds = [video["disturbance"]["terrain"]["kinds"] for video in videos]
    assert kinds[-2:] == [["tiles"], ["rough"]]
    assert all(kind == ["flat"] for kind in kinds[:-2])
    assert all(video["controller"] == "policy_onboard" for video in videos[-2:])


def test_without_a_speed_to_track_there_is_a_page_all_the_same():
    _, report = stages("report.sections=[tracking]", "report.tracking_speeds=[7.0]")
    assert not report.inputs


def test_a_section_that_is_not_there_is_one_line(refused):
    overrides = ["~protocols.sweep", "report.sections=[sweep]"]
    protocols = [name for name in composed("experiment=test").protocols if name != "sweep"]
    known = ", ".join([*SECTIONS, *protocols])
    with pytest.raises(UserError) as error:
        stages(*overrides)
    assert str(error.value) == f"report.sections: expected one of {known}, found sweep"
    line = refused("config", "experiment=test", *overrides, "--conf", str(CONF))
    assert line == f"slider: {error.value}"


def test_a_section_pulls_in_what_it_declares():
    _, report = stages("report.sections=[table1,learning]")
    assert set(report.inputs) == {"table1", "standing", "walking"}
    _, report = stages(f"report.sections=[{','.join(SECTIONS)}]")
    declared = {name.rstrip("?") for section in SECTIONS.values() for name in section.needs}
    assert set(report.inputs) == declared - {"untuned"}  # there is no fine-tuning
    assert {origin["stage"] for origin in report.section["origins"]["library.gaits"]} == {"gait"}


def test_a_page_shows_the_settings_of_its_protocols_only():
    _, report = stages("report.sections=[sweep,joystick]")
    assert report.section["configuration"]["protocols"].keys() == {"sweep", "joystick"}
    assert {job.stage for job in report.inputs["joystick"]} == {"segments"}
    _, report = stages()
    assert {"protocols", "gauge"}.isdisjoint(report.section["configuration"])
    _, report = stages("report.sections=[gauge]", "gauge.controllers=[mpc_wbc_tuned]")
    shown = report.section["configuration"]
    assert shown["gauge"]["controllers"] == ["mpc_wbc_tuned"]
    assert "mpc_wbc_tuned" in shown["control"]
