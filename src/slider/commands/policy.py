"""``slider policy``: show the contents of a policy file, or export it."""

import argparse
import json
from pathlib import Path
from typing import Any

from slider.artefacts.current import add_store_argument, current_result
from slider.artefacts.run_metadata import last_robot
from slider.artefacts.store import Store
from slider.composition.compose import compose
from slider.control import EXPORT_FILES, ONNX, POLICY_FILE

_MAKE = "snakemake -j2 policy"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="print its contract, policy.json of an export")
    export = actions.add_parser("export", help="write it for use without this package")
    export.add_argument("--out", type=Path, default=Path("policy"), help="folder (default: policy)")
    export.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    for action in (show, export):
        action.add_argument("file", type=Path, nargs="?", help="default: of the current plan")
        add_store_argument(action)


def run(arguments: argparse.Namespace) -> None:
    """Show or export one policy."""
    from slider.control import export
    from slider.control.deployment import policy_step
    from slider.control.layout import describe
    from slider.control.policy import load_policy

    file, origin = _choose(arguments)
    if arguments.action == "export":
        config = compose(last_robot(arguments.artefacts), arguments.conf)
        arguments.out.mkdir(parents=True, exist_ok=True)
        policy = export.write_files(file, origin, arguments.out, config.env.estimator)
        difference = export.compare(policy, arguments.out / ONNX, export.DURATION)
        print("\n".join(str(arguments.out / name) for name in EXPORT_FILES))
        print(f"largest difference of a joint target in a roll-out: {difference:.1e}")
        return
    policy = load_policy(file)
    print(json.dumps(describe(policy, origin, {ONNX: policy_step(policy)}), indent=1))


def _choose(arguments: argparse.Namespace) -> tuple[Path, dict[str, Any]]:
    """The policy file, and its origin in the store."""
    if arguments.file is not None:
        return arguments.file, {}
    store = Store(arguments.artefacts)
    job, folder = current_result(store, "walking", _MAKE)
    return folder / POLICY_FILE, {"recipe": job.recipe, "source": job.code.source}
