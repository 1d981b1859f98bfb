"""``slider bundle``: a result with all that it came from, for a paper or another machine."""

import argparse
import shutil
import tempfile
from pathlib import Path

from slider.artefacts.current import current_plan, current_result
from slider.artefacts.plan import build_plan
from slider.artefacts.store import ARTEFACTS, Store
from slider.core.errors import UserError

_NO_LICENCE = "No licence has been chosen: all rights are reserved."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("targets", nargs="+", help="such as table1, or of other reports")
    parser.add_argument("--out", type=Path, help="file (default: reports/<first target>.crate.zip)")
    parser.add_argument(
        "--licence", default=_NO_LICENCE, help="its URL, or a sentence (default: none chosen)"
    )
    parser.add_argument(
        "--artefacts", type=Path, default=Path(ARTEFACTS), help="folder (default: artefacts)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Write the archive in one step.

    Raises:
        UserError: a target is unknown or not computed, or the source changed since.
    """
    store = Store(arguments.artefacts)
    plan = current_plan(store)
    known = sorted(plan.targets) if plan else []
    for name in arguments.targets:
        if plan and name not in known:
            raise UserError(f"expected a target of {', '.join(known)}, found '{name}'")
    targets = {name: current_result(store, name, _make(name))[0] for name in arguments.targets}
    try:
        from slider.artefacts.bundle import write_bundle
    except ModuleNotFoundError as error:
        install = "pip install -e '.[bundle]' -c constraints.txt"
        raise UserError(f"expected the package {error.name}, found none: {install}") from None
    out = arguments.out or Path("reports") / f"{arguments.targets[0]}.crate.zip"
    if out.is_dir():
        raise UserError(f"--out: expected a file, found the folder {out}")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out: {out.parent}: {error.strerror}") from None
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as place:
        folder = Path(place) / "crate"
        folder.mkdir()
        size = write_bundle(build_plan(targets), store, Path(), arguments.licence, folder)
        archive = shutil.make_archive(str(Path(place) / "archive"), "zip", folder)
        Path(archive).replace(out)
    print(f"{out}: {out.stat().st_size / 1e6:.1f} MB, results of {size / 1e6:.1f} MB")


def _make(target: str) -> str:
    return f"snakemake -j2 reports/{target}.csv" if target == "table1" else "snakemake -j2"
