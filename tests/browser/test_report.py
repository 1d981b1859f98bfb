"""The page as its reader meets it, in a browser."""

import csv

import pytest

pytestmark = pytest.mark.workflow


@pytest.fixture
def opened(finished, visit):
    def open_report(scheme="light", width=1280):
        return visit((finished.folder / "reports" / "index.html").as_uri(), scheme, width)

    return open_report


def test_loads_without_complaint_and_without_the_network(opened):
    report = opened()
    assert report.complaints == []
    outside = [r for r in report.requests if not r.startswith(("file:", "data:", "blob:"))]
    assert outside == []
    drawn = report.page.locator(".pictures img").evaluate_all("all => all.map(i => i.naturalWidth)")
    assert len(drawn) >= 5
    assert min(drawn) > 0


def test_the_first_screen_shows_the_robot_and_the_plot(opened):
    page = opened().page
    for selector in ("#overview video", "#overview img", "#overview p"):
        box = page.locator(selector).first.bounding_box()
        assert box["y"] + box["height"] < 900


def test_shows_the_numbers_of_table_1(opened, finished):
    page = opened().page
    rows = csv.DictReader(finished.table.read_text().splitlines())
    ours = {row["speed"]: row for row in rows if row["controller"] == "policy"}
    lines = page.locator("#table1 table").first.locator("tbody tr").all_inner_texts()
    shown = dict(line.split("\t")[:2] for line in lines)
    for speed, row in ours.items():
        assert shown[speed].startswith(f"{100 * float(row['success_rate']):.1f} %")


def test_a_video_plays(opened):
    page = opened().page
    video = page.locator("video").first
    assert video.evaluate("v => v.play().then(() => v.videoWidth)") > 0
    video.evaluate("v => { v.loop = false; }")
    page.wait_for_function("() => document.querySelector('video').currentTime > 0.15")
    assert video.evaluate("v => v.error") is None


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_follows_the_theme_of_the_reader(opened, scheme):
    page = opened(scheme).page

    def brightness(name):
        colour = page.locator("body").evaluate(
            f"e => getComputedStyle(e).{name}.match(/[0-9.]+/g).slice(0, 3).map(Number)"
        )
        return sum(colour) / (3 * 255)

    assert (brightness("backgroundColor") < 0.5) == (scheme == "dark")
    assert abs(brightness("backgroundColor") - brightness("color")) > 0.5


@pytest.mark.parametrize("width", [1280, 400])
def test_fits_the_screen(opened, width):
    page = opened(width=width).page
    # Of a table of numbers a column keeps its numbers whole; on a narrow screen it scrolls.
    numbers = ".scroll:has(.numbers)" if width < 700 else ".none"
    wide = page.locator(f"section > .scroll:not({numbers})").evaluate_all(
        "boxes => boxes.filter(b => b.scrollWidth > b.clientWidth).map(b => b.innerText)"
    )
    assert wide == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    ids = page.locator("[id]").evaluate_all("all => all.map(e => e.id)")
    assert len(ids) == len(set(ids))
