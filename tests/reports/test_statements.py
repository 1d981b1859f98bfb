"""Statements of the paper: page and documentation agree, and each names places that exist."""

import re
from functools import reduce
from pkgutil import resolve_name

from pipeline.targets import report_files
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.env import observations, rewards
from slider.reports.page import read_statements
from tests.config.composed import CONF, composed

ROOT = CONF.parent
CONFIG = composed()
REPORTS = {file for files in report_files(CONFIG).values() for file in files}
STATUSES = {"as printed", "read", "ours differs", "not done"}
PAPER = composed("experiment=paper")


def read() -> list[dict[str, str]]:
    return read_statements().to_dict("records")


def test_page_and_documentation_agree():
    text = (ROOT / "docs/paper.md").read_text().replace("`", "").replace("\\|", "|")
    tables = re.findall(r"^\| the paper says .*\n\|.*\n((?:\|.*\n)+)", text, re.M)
    written = [f"| {' | '.join([*row.values()][1:])} |" for row in read()]
    assert re.sub(" +", " ", "".join(tables)).splitlines() == [
        re.sub(" +", " ", w) for w in written
    ]


def test_every_statement_has_a_status_and_those_that_differ_a_reason():
    for statement in read():
        assert statement["status"] in STATUSES, statement["paper"]
        assert statement["reading"], statement["paper"]
        assert statement["where"] or statement["status"] == "not done", statement["paper"]


def test_all_places_exist():
    """A key, group or file of the configuration, a term, a name of the source, a report, a page."""
    places = {place for row in read() for place in row["where"].split(", ") if place}
    assert [place for place in sorted(places) if not _exists(place)] == []


def _exists(place: str) -> bool:
    if place.startswith("reports/"):
        return place in REPORTS
    if place.startswith(("conf/", "docs/")):
        return (ROOT / place).is_file()
    if place.startswith("slider."):
        return resolve_name(place) is not None
    if "=" in place:
        return bool(composed(place))
    if "/" in place:
        return (CONF / place).is_dir()
    return place in {*rewards.TERMS, *observations.TERMS} or _is_key(place)


def _is_key(place: str) -> bool:
    try:
        _value(place, CONFIG)
    except (KeyError, TypeError):
        return False
    return True


def _value(place: str, config: Config) -> object:
    return reduce(lambda node, name: node[name], place.split("."), to_dict(config))


def test_the_papers_experiment_has_other_values():
    """Where a row says what ``experiment=paper`` does, its key is not the default's there."""
    places = {row["where"].split(", ")[0] for row in read() if "experiment=paper" in row["reading"]}
    keys = [place for place in places if _is_key(place)]
    assert keys
    assert [place for place in keys if _value(place, CONFIG) == _value(place, PAPER)] == []
