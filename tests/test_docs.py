"""The documentation builds as a site without a broken link; its robot is the configured one."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from snakemake.cli import parse_args

from tests.config.composed import composed

ROOT = Path(__file__).parents[1]
ROBOT_PAGE = (ROOT / "docs/reference/robot.md").read_text()
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
# Dated trials, what the paper prints, versions of files.
DATED = ("CHANGELOG.md", "docs/notebook.md", "docs/paper.md")
NOT_PROSE = (
    r"^```.*?^```",
    r"<!-- results.*?<!-- /results",
    r"^\|[^\n]*",
    r"`[^`\n]*`",
    r"\]\([^)]*\)",
    r"Python 3\.\d+( to 3\.\d+)?|MuJoCo 3\.\d+",
)
# Of the robot's mass, which has a test of its own, and of the public predecessors' files.
PRINTED = {"robot.md": "12.52 0.65 2.1 0.215"}


def test_the_mass_is_that_of_the_links():
    links = vars(composed().robot.links)
    mass = sum(link.mass * (1 if name == "base" else 2) for name, link in links.items() if link)
    assert f"The total mass is {mass:.2f} kg." in ROBOT_PAGE


def test_what_joints_see_of_the_capstan_is_computed_from_the_configuration():
    robot = composed().robot
    motor, gains = robot.drives["capstan"], robot.gains["capstan"]
    r, n = robot.capstan.drum_radius, robot.capstan.foot_ratio
    for slide, ankle in (
        (f"{2 * motor.torque / r:.0f} N", f"{2 * motor.torque / n:.1f} N m"),
        (f"{motor.speed * r:.1f} m/s", f"{motor.speed * n:.0f} rad/s"),
        (f"{2 * motor.inertia / r**2:.1f} kg", f"{2 * motor.inertia / n**2:.4f} kg m²"),
        (f"{2 * gains.kp / r**2:.0f} N/m", f"{2 * gains.kp / n**2:.1f} N m/rad"),
        (f"{2 * gains.kd / r**2:.1f} N s/m", f"{2 * gains.kd / n**2:.3f} N m s/rad"),
    ):
        assert f"| {slide} | {ankle} |" in ROBOT_PAGE


@pytest.fixture(scope="module")
def configured() -> set[float]:
    """Numbers of conf/."""
    texts = (path.read_text() for path in (ROOT / "conf").rglob("*.yaml"))
    return {float(n) for text in texts for n in re.findall(r"(?<![\w.])\d+\.?\d*(?![\w.])", text)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_to_files_and_results_in_prose_are_in_a_table(page, configured):
    """Fractions and percentages that are neither of ``conf/`` nor in a table that a run filled."""
    name, text = page.relative_to(ROOT).as_posix(), page.read_text()
    targets = re.findall(r"\]\((?![a-z]+:|#)([^)#\s]+)", text)
    assert not [target for target in targets if not (page.parent / target).exists()]
    if name in DATED:
        return
    tables = "".join(re.findall(r"<!-- results.*?<!-- /results", text, re.S))
    for pattern in NOT_PROSE:
        text = re.sub(pattern, "", text, flags=re.S | re.M)
    found = set(re.findall(r"(?<![\w.,:/-])(\d+\.\d+|\d+(?= ?%))(?![\w.])", text))
    known = {*re.findall(r"\d+\.?\d*", tables), *PRINTED.get(page.name, "").split()}
    scaled = {n for n in found if {float(n), float(n) / 100, float(n) / 1000} & configured}
    assert not found - known - scaled


def test_the_picture_of_the_readme_is_small():
    assert (ROOT / "docs" / "images" / "walk.webp").stat().st_size < 2_000_000


@pytest.mark.skipif(importlib.util.find_spec("mkdocs") is None, reason="needs the extra docs")
def test_builds_without_a_broken_link(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "configuration.html").read_text()
    assert "gait.posture.clearance" in page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_snakemake_takes_the_commands_of_a_page(page):
    lines = re.findall(r"^\s*(?:\d\. Run `)?snakemake (-[^`\n]*)", page.read_text(), re.M)
    for line in lines:
        _, arguments = parse_args(shlex.split(line, comments=True))
        assert arguments.targets or arguments.dryrun or arguments.unlock, line
