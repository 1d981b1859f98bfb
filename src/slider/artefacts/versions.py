"""Versions of the third-party packages that a stage imports."""

import importlib.util
import sys
from functools import cache
from importlib import metadata

from slider.core.errors import UserError

ABSENT = "absent"


def versions(packages: tuple[str, ...]) -> dict[str, str]:
    """Version of Python (major.minor) and of each importable top-level package, sorted."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python} | {name: version(name) for name in sorted(packages)}


@cache
def version(package: str) -> str:
    """Version of the distribution that provides an importable package; ``absent`` without one.

    Raises:
        UserError: the package can be imported, but no distribution owns up to it.
    """
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        if importlib.util.find_spec(package) is None:
            return ABSENT
        return _search(package)


def _search(package: str) -> str:
    # metadata.packages_distributions() parses every list of files and takes 0.7 s; the
    # names of two of ten packages differ from their distribution's, so a text search will do.
    # The packages of cmeel (pinocchio) are one folder of site-packages below another.
    markers = (f"\n{package}/", f"\n{package}.py,", f"/site-packages/{package}/__init__.py,")
    for distribution in metadata.distributions():
        record = "\n" + (distribution.read_text("RECORD") or "")
        if any(marker in record for marker in markers):
            return distribution.version
    raise UserError(f"expected an installed distribution with package {package}, found none")
