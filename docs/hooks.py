"""Hooks of mkdocs: what is generated when the site is built."""

from pathlib import Path

from mkdocs.structure.files import File

from slider.core.config.reference import reference, robot_table

ROOT = Path(__file__).parents[1]
ROBOT = "<!-- robot parameters: docs/hooks.py puts the table here -->"


def on_files(files, config):
    """Add the configuration reference."""
    files.append(File.generated(config, "configuration.md", content=reference(ROOT / "conf")))
    return files


def on_page_markdown(markdown, page, config, files):
    """Put the table of the robot's parameters in their page."""
    return markdown.replace(ROBOT, robot_table(ROOT / "conf")) if ROBOT in markdown else None
