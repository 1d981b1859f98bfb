"""``slider publish``: copy one file of a result to where people look for it."""

import argparse
import os
import shutil
from pathlib import Path

from slider.core.errors import UserError
from slider.core.store import ARTEFACTS, Store, parse_manifest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("manifest", type=Path, help="manifest of the result")
    parser.add_argument("target", type=Path, help="file to write; the result has one of its name")
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Copy in one step, so that the target is the old file or the new one."""
    result = parse_manifest(arguments.manifest).result
    target: Path = arguments.target
    if target.name not in result.files:
        raise UserError(f"expected {target.name} in {arguments.manifest}, found none")
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    folder = Store(arguments.artefacts).object_folder(result.object)
    shutil.copyfile(folder / target.name, part)
    part.replace(target)
    print(f"{target} is ready")
