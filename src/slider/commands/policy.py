"""``slider policy``: what is in a policy file, and how to take it elsewhere."""

import argparse
import json
from pathlib import Path
from typing import Any

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.run_metadata import last_robot
from slider.artefacts.store import Store
from slider.composition.compose import compose
from slider.control import EXPORT_FILES, ONNX, POLICY_FILE

_MAKE = "snakemake -j2 policy"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="print what a policy sees and does")
    show.add_argument("--json", action="store_true", help="the whole layout, for programs")
    export = actions.add_parser("export", help="write it for use without this package")
    export.add_argument("--out", type=Path, default=Path("policy"), help="folder (default: policy)")
    export.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    for action in (show, export):
        action.add_argument(
            "file",
            type=Path,
            nargs="?",
            help="policy.pt, to show also the folder of an export (default: of the current plan)",
        )
        add_store_argument(action)


def run(arguments: argparse.Namespace) -> None:
    """Show or export one policy."""
    from slider.control import export, exported
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
    if file.is_dir():
        layout = exported.read_layout(file)
    else:
        policy = load_policy(file)
        layout = describe(policy, origin, {ONNX: policy_step(policy)})
    print(json.dumps(layout, indent=1) if arguments.json else summary(layout))


def _choose(arguments: argparse.Namespace) -> tuple[Path, dict[str, Any]]:
    """The policy file, and its origin in the store."""
    if arguments.file is not None:
        return arguments.file, {}
    store = Store(arguments.artefacts)
    folder = current_folder(store, "walking", _MAKE)
    job, _ = current_result(store, "walking", _MAKE)
    return folder / POLICY_FILE, {"recipe": job.recipe, "source": job.code.source}


def summary(layout: dict[str, Any]) -> str:
    """Facts of a policy, and tables of its observation, joints and motors."""
    import pandas as pd

    network, scales = layout["network"], layout["action"]["scale"]
    joints = [joint | {"scale": s} for joint, s in zip(layout["joints"], scales, strict=True)]
    terms = [t | {"unit": ", ".join(dict.fromkeys(t["units"]))} for t in layout["observation"]]
    widths = [sum(term["width"] for term in terms), *network["hidden"], len(joints)]
    tables = [
        pd.DataFrame(
            [{title: row["name"]} | {name: row[name] for name in columns} for row in rows]
        ).to_string(index=False, float_format="{:g}".format)
        for title, rows, columns in (
            ("observation", terms, ("start", "width", "scale", "frame", "unit")),
            ("joint", joints, ("default", "scale", "lower", "upper")),
            ("motor", layout["motors"], ("kp", "kd", "torque_limit", "no_load_speed")),
        )
    ]
    nominal, clock = layout["action"]["offset"] == "nominal", "none"
    offset = "the nominal pose" if nominal else "the gait of the reference velocity"
    if layout["clock"] is not None:
        shortest, longest = layout["clock"]["step_time"]
        mirror = "mirrored in right stance" if layout["clock"]["mirror"] else "not mirrored"
        clock = f"steps of {shortest:.2f} to {longest:.2f} s, {mirror}"
    facts = [
        f"robot           {layout['robot']}",
        f"control period  {layout['control_period']:g} s",
        f"network         {' × '.join(map(str, widths))}, {network['activation']}",
        "training        " + ", ".join(f"{k} {v:g}" for k, v in layout["training"].items()),
        f"clock           {clock}",
        f"actions about   {offset}",
    ]
    return "\n\n".join(["\n".join(facts), *tables])
