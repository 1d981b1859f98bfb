"""``slider publish``: copy files of a result to where people look for it."""

import argparse
import os
import shutil
from pathlib import Path

from slider.artefacts.current import add_store_argument
from slider.artefacts.manifest import damaged, parse_manifest
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("manifest", type=Path, help="manifest of the result")
    parser.add_argument(
        "targets", type=Path, nargs="+", help="files to write; the result has some of their names"
    )
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Copy each file in one step, so that a target is the old file or the new one.

    Raises:
        UserError: the result lacks a file or is damaged.
    """
    manifest = parse_manifest(arguments.manifest)
    result = manifest.result
    folder = Store(arguments.artefacts).object_folder(result.object)
    for target in arguments.targets:
        if target.name not in result.files:
            raise UserError(f"expected {target.name} in {arguments.manifest}, found none")
        if not _copy(folder / target.name, target, result.files[target.name]["sha256"]):
            raise damaged(manifest.stage, result.object)
        print(f"{target} is ready")


def _copy(source: Path, target: Path, digest: str) -> bool:
    """Copy a file; tell whether the copy is what it should be, else leave the target alone."""
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        shutil.copyfile(source, part)
        whole = files.digest_file(part) == digest
        if whole:
            part.replace(target)
        return whole
    except FileNotFoundError:
        return False
    finally:
        part.unlink(missing_ok=True)
