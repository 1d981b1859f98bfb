"""Hooks of mkdocs: pages that are generated when the site is built."""

from pathlib import Path

from mkdocs.structure.files import File

from slider.config.reference import page

ROOT = Path(__file__).parents[1]


def on_files(files, config):
    """Add the configuration reference."""
    files.append(File.generated(config, "configuration.md", content=page(ROOT / "conf")))
    return files
