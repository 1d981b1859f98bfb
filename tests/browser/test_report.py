"""The page as its reader meets it, in a headless Chromium of the system."""

import shutil
from collections.abc import Iterator

import pytest

from tests.workflow.workspace import Workspace, finished

pytestmark = pytest.mark.workflow
CANDIDATES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 300.0  # for anything to happen on a busy machine [s]


@pytest.fixture(scope="module")
def browser() -> Iterator[object]:
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="needs the Python package playwright (extra test)"
    )
    path = next(filter(None, map(shutil.which, CANDIDATES)), None)
    if path is None:
        pytest.skip("needs Chromium, such as Debian's package chromium")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def real(browser) -> Workspace:
    """A pipeline that ran up to its report; nobody may change it."""
    return finished()


@pytest.fixture
def page(browser, real) -> Iterator[object]:
    """The open report, and everything it complained about or asked for."""
    with browser.new_page(viewport={"width": 1280, "height": 900}) as page:
        page.set_default_timeout(1000 * PATIENCE)
        page.complaints, page.requests = [], []
        page.on("console", lambda m: m.type == "error" and page.complaints.append(m.text))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("request", lambda asked: page.requests.append(asked.url))
        page.goto((real.folder / "reports" / "index.html").as_uri())
        yield page


def test_loads_without_complaint_and_without_the_network(page):
    assert page.complaints == []
    outside = [r for r in page.requests if not r.startswith(("file:", "data:", "blob:"))]
    assert outside == []
    drawn = page.locator(".pictures img").evaluate_all("all => all.map(i => i.naturalWidth)")
    assert len(drawn) >= 4
    assert min(drawn) > 0


def test_the_first_screen_shows_the_robot_and_the_plot(page):
    for selector in ("#overview video", "#overview img"):
        box = page.locator(selector).first.bounding_box()
        assert box["y"] + box["height"] < 900


def test_a_video_plays(page):
    video = page.locator("video").first
    assert video.evaluate("v => v.play().then(() => v.videoWidth)") > 0
    video.evaluate("v => { v.loop = false; }")
    page.wait_for_function("() => document.querySelector('video').currentTime > 0.15")
    assert video.evaluate("v => v.error") is None


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_follows_the_theme_of_the_reader(page, scheme):
    page.emulate_media(color_scheme=scheme)

    def brightness(name):
        colour = page.locator("body").evaluate(
            f"e => getComputedStyle(e).{name}.match(/[0-9.]+/g).slice(0, 3).map(Number)"
        )
        return sum(colour) / (3 * 255)

    assert (brightness("backgroundColor") < 0.5) == (scheme == "dark")
    assert abs(brightness("backgroundColor") - brightness("color")) > 0.5


@pytest.mark.parametrize("width", [1280, 400])
def test_fits_the_screen(page, width):
    page.set_viewport_size({"width": width, "height": 900})
    # On a narrow screen a table scrolls.
    wide = page.locator("section > .scroll").evaluate_all(
        "boxes => boxes.filter(b => b.scrollWidth > b.clientWidth).map(b => b.innerText)"
    )
    assert wide == [] or width < 700
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    ids = page.locator("[id]").evaluate_all("all => all.map(e => e.id)")
    assert len(ids) == len(set(ids))
