"""The page as its reader meets it, in a browser."""

import csv
import time
from itertools import cycle

import pytest

from tests.browser.conftest import PATIENCE

pytestmark = pytest.mark.workflow


@pytest.fixture
def opened(finished, visit):
    def open_report(scheme="light"):
        found = visit((finished.folder / "reports" / "index.html").as_uri(), scheme)
        found.page.wait_for_selector("html[data-ready=true]")
        return found

    return open_report


def test_loads_without_complaint_and_without_the_network(opened):
    found = opened()
    assert found.complaints == []
    outside = [r for r in found.requests if not r.startswith(("file:", "data:", "blob:"))]
    assert outside == []
    assert found.page.locator(".chart .main-svg").count() >= 5


def test_shows_the_numbers_of_table_1(opened, finished):
    page = opened().page
    rows = csv.DictReader(finished.table.read_text().splitlines())
    ours = {float(r["command_velocity"]): r for r in rows if r["controller"] == "policy"}
    tables = page.locator("#table1 .tables table")
    assert tables.count() == 4
    for index, metric in enumerate(("success_rate", "mse_steady", "mse", "tracking_rate")):
        keys = (
            tables.nth(index)
            .locator("tbody tr")
            .evaluate_all(
                "rows => rows.map(r => [r.children[0].dataset.key, r.children[1].dataset.key])"
            )
        )
        assert {float(command): float(value) for command, value in keys} == pytest.approx(
            {command: float(row[metric]) for command, row in ours.items()},
            rel=1e-5,  # the file has six digits
        )


def test_sorts_a_table_by_its_heading(opened):
    page = opened().page
    table = page.locator("#table1 .tables table").first

    def commands():
        return table.locator("tbody tr td:first-child").evaluate_all(
            "cells => cells.map(c => Number(c.dataset.key))"
        )

    before = commands()
    assert before == sorted(before)
    assert len(before) > 1
    heading = table.locator("th [role=button]").first
    heading.click()
    heading.click()
    assert commands() == before[::-1]


def test_hovering_a_gait_draws_its_limit_cycle(opened):
    page = opened().page
    curve = "document.querySelector('#limit-cycle path.js-line').getAttribute('d')"
    before, shown = page.evaluate(curve), page.locator("#gait-map-shown").inner_text()
    points = page.locator("#gait-map .scatterlayer .point")
    points.first.scroll_into_view_if_needed()
    # The gait drawn at first may be the first or the last one, not both.
    ends, deadline = cycle((0, points.count() - 1)), time.monotonic() + PATIENCE
    while page.locator("#gait-map-shown").inner_text() == shown:
        assert time.monotonic() < deadline
        box = points.nth(next(ends)).bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=4)
        page.wait_for_timeout(500)
    page.wait_for_function(f"before => {curve} !== before", arg=before)


def test_a_video_plays(opened):
    page = opened().page
    video = page.locator("video").first
    video.scroll_into_view_if_needed()
    assert video.evaluate("v => v.play().then(() => v.videoWidth)") > 0
    video.evaluate("v => { v.loop = false; }")
    page.wait_for_function("() => document.querySelector('video').currentTime > 0.15")
    assert video.evaluate("v => v.error") is None


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_follows_the_theme_of_the_reader(opened, scheme):
    page = opened(scheme).page

    def brightness(selector, name):
        colour = page.locator(selector).first.evaluate(
            f"e => getComputedStyle(e).{name}.match(/[0-9.]+/g).slice(0, 3).map(Number)"
        )
        return sum(colour) / (3 * 255)

    def becomes(dark):
        """Whether the page and the text of a chart take these colours, so that it is legible."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            ground = brightness("body", "backgroundColor")
            text = brightness(".chart .xtick text", "fill")
            if (ground < 0.5) == dark and abs(ground - text) > 0.5:
                return True
            page.wait_for_timeout(200)
        return False

    assert becomes(dark=scheme == "dark")
    page.locator("#theme").click()
    assert becomes(dark=scheme == "light")


def test_fits_a_laptop(opened):
    page = opened().page
    wide = page.locator(".scroll").evaluate_all(
        "boxes => boxes.filter(b => b.scrollWidth > b.clientWidth).map(b => b.innerText)"
    )
    assert wide == []
    ids = page.locator("[id]").evaluate_all("found => found.map(e => e.id)")
    assert len(ids) == len(set(ids))
