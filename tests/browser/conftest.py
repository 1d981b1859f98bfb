"""A headless Chromium of the system, and a finished pipeline to look at."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest

from tests.workflow.workspace import Workspace
from tests.workflow.workspace import finished as finished_pipeline

CANDIDATES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 300.0  # for anything to happen on a busy machine [s]


@dataclass
class Visit:
    """A page and everything it complained about or asked for."""

    page: object
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@pytest.fixture(scope="session")
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


@pytest.fixture(scope="session")
def finished(browser, session_folder) -> Workspace:
    """A pipeline that ran up to its report, with tracking; nobody may change it."""
    return finished_pipeline(session_folder)


@pytest.fixture
def visit(browser):
    """Open pages; note console errors, exceptions and requests of each."""
    contexts = []

    def open_page(address: str, scheme: str = "light", width: int = 1280) -> Visit:
        size = {"width": width, "height": 900}
        context = browser.new_context(viewport=size, color_scheme=scheme)
        contexts.append(context)
        visit = Visit(context.new_page())
        page = visit.page
        page.set_default_timeout(1000 * PATIENCE)
        page.on("console", lambda m: m.type == "error" and visit.complaints.append(m.text))
        page.on("pageerror", lambda error: visit.complaints.append(str(error)))
        page.on("request", lambda request: visit.requests.append(request.url))
        page.goto(address)
        return visit

    yield open_page
    for context in contexts:
        context.close()
