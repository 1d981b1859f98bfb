"""Hooks of mkdocs: pages that are generated when the site is built."""

from pathlib import Path

from mkdocs.structure.files import File

from slider.composition.compose import compose
from slider.config.reference import OPTIONAL, page
from slider.env.terms import parameter_types

ROOT = Path(__file__).parents[1]


def on_files(files, config):
    """Add the configuration reference."""
    default = compose(OPTIONAL, ROOT / "conf")
    text = "---\nhide: [toc]\n---\n\n" + page(default, parameter_types(default))  # a wide table
    files.append(File.generated(config, "configuration.md", content=text))
    return files
