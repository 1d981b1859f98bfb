"""MLflow's own pages on what the pipeline recorded."""

import socket
import sqlite3
import subprocess
import sys
import time
import urllib.request
from contextlib import closing
from dataclasses import dataclass

import pytest

from tests.browser.conftest import PATIENCE

pytestmark = pytest.mark.workflow


@dataclass(frozen=True)
class Server:
    address: str
    start: str  # the page that the command names
    runs: dict[str, str]  # name of the latest run → its id
    experiment: str


@pytest.fixture(scope="module")
def server(finished):
    """``slider runs``, stopped at the end."""
    database = finished.artefacts / "mlflow.db"
    with closing(sqlite3.connect(database)) as connection:
        rows = connection.execute(
            "SELECT name, run_uuid, experiment_id FROM runs ORDER BY start_time"
        ).fetchall()
    arguments = ["--artefacts", str(finished.artefacts), "--port", str(_free_port())]
    process = subprocess.Popen(
        [sys.executable, "-m", "slider.cli", "runs", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        assert process.stdout is not None
        start = process.stdout.readline().removeprefix("open ").strip()
        address = start.partition("/#")[0]
        _wait_for(f"{address}/health")
        yield Server(address, start, {name: run for name, run, _ in rows}, str(rows[0][2]))
    finally:
        process.terminate()
        assert process.wait(PATIENCE) == 0


def _free_port() -> int:
    with closing(socket.socket()) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _wait_for(address: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(address, timeout=5).close()
            return
        except OSError:
            assert time.monotonic() < deadline, "mlflow ui does not answer"
            time.sleep(0.5)


def test_lists_the_pipeline_run_with_its_children(server, visit):
    found = visit(server.start)
    page = found.page
    page.get_by_role("link", name="pipeline").first.wait_for()
    rows = page.get_by_role("row")
    before = rows.count()
    # The latest pipeline run stands first; a click on its plus shows its children.
    page.get_by_role("row").filter(has_text="pipeline").first.locator("button").first.click()
    page.wait_for_function(f"() => document.querySelectorAll('[role=row]').length > {before}")
    outside = [r for r in found.requests if not r.startswith((server.address, "data:", "blob:"))]
    assert outside == []


def test_opens_on_the_runs_of_trainings(server, visit):
    """Not on traces of language models, MLflow's own choice."""
    page = visit(server.start).page
    page.get_by_role("link", name="pipeline").first.wait_for()
    assert f"/experiments/{server.experiment}/runs" in page.url
    page.get_by_role("link", name="Models").wait_for()  # in the menu of trainings alone


def test_the_library_leads_to_its_gaits(server, visit):
    run = f"{server.address}/#/experiments/{server.experiment}/runs/{server.runs['gait library']}"
    page = visit(run).page
    link = page.get_by_role("link", name="slider-gaits").first
    link.wait_for()
    gaits = visit(f"{server.address}/{link.get_attribute('href')}").page
    gaits.get_by_role("link", name="gait 0.40 +0.00 m/s").first.wait_for()
    assert gaits.get_by_role("link", name="walking").count() == 0


def test_opens_a_learning_curve(server, visit):
    run = f"{server.address}/#/experiments/{server.experiment}/runs/{server.runs['walking']}"
    page = visit(f"{run}/model-metrics").page
    page.locator(".js-plotly-plot .main-svg").first.wait_for()
    assert page.locator(".js-plotly-plot").count() >= 2


def test_links_a_run_to_its_result_by_a_path_that_survives_a_move(server, visit, finished):
    run = f"{server.address}/#/experiments/{server.experiment}/runs/{server.runs['table 1']}"
    page = visit(run).page
    page.get_by_text("table1.csv").first.wait_for()
    with closing(sqlite3.connect(finished.artefacts / "mlflow.db")) as connection:
        (path,) = connection.execute(
            "SELECT value FROM tags WHERE key = 'object.path' AND run_uuid = ?",
            (server.runs["table 1"],),
        ).fetchone()
    linked = finished.artefacts / path / "table1.csv"
    assert linked.read_bytes() == finished.table.read_bytes()
