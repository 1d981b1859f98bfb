"""``slider bundle``: a result with all that it came from, for a paper or another machine."""

import argparse
import shutil
import tempfile
from pathlib import Path

from slider.artefacts.current import add_store_argument, current_plan, current_result
from slider.artefacts.plan import Plan, build_plan
from slider.artefacts.run_metadata import config_option, run_metadata
from slider.artefacts.store import Store
from slider.commands import make_folder
from slider.core.errors import UserError, one_of, require

_NO_LICENCE = "No licence has been chosen: all rights are reserved."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("targets", nargs="+", help="such as table1, or of other reports")
    parser.add_argument("--out", type=Path, help="file (default: reports/<first target>.crate.zip)")
    parser.add_argument(
        "--licence", default=_NO_LICENCE, help="its URL, or a sentence (default: none chosen)"
    )
    add_store_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the archive in one step."""
    store = Store(arguments.artefacts)
    plan = current_plan(store)
    for name in arguments.targets:
        if plan:
            one_of("target", name, sorted(plan.targets))
    targets = {
        name: current_result(store, name, f"snakemake -j2 {_file(plan, name)}")[0]
        for name in arguments.targets
    }
    try:
        from slider.artefacts.bundle import write_bundle
    except ModuleNotFoundError as error:
        install = "pip install -e '.[bundle]' -c constraints.txt"
        raise UserError(f"expected the package {error.name}, found none: {install}") from None
    job = next(iter(targets.values()))
    noted = run_metadata(store.root) | store.facts(job.stage, job.recipe)
    overrides = str(noted.get("overrides", ""))
    command = " ".join(["snakemake -j2", *dict.fromkeys(_file(plan, name) for name in targets)])
    command += config_option(overrides)
    out = arguments.out or Path("reports") / f"{arguments.targets[0]}.crate.zip"
    require(not out.is_dir(), "--out", "a file", f"the folder {out}")
    make_folder(out.parent)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as place:
        folder = Path(place) / "crate"
        folder.mkdir()
        plan = build_plan(targets)
        size = write_bundle(plan, store, overrides, command, arguments.licence, folder)
        archive = shutil.make_archive(str(Path(place) / "archive"), "zip", folder)
        Path(archive).replace(out)
    print(f"{out}: {out.stat().st_size / 1e6:.1f} MB, results of {size / 1e6:.1f} MB")
    print(f"unpacked, this has the results: {command}")


def _file(plan: Plan | None, target: str) -> str:
    """What to ask Snakemake for; what Table 1 needs has no files of its own."""
    table = plan.targets.get("table1") if plan else None
    needed = plan.jobs_of("table1") if plan and table else {}
    of_table = target == "table1" or (plan and plan.targets.get(target) in needed)
    return "reports/table1.csv" if of_table else f"publish_{target}"
