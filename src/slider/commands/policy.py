"""``slider policy``: what is in a policy file, and how to take it elsewhere."""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.store import Store
from slider.commands import make_folder
from slider.control import EXPORT_FILES, POLICY_FILE

_MAKE = "snakemake -j2 policy"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(dest="action", required=True)
    show = actions.add_parser("show", help="print what a policy sees and does")
    show.add_argument("--json", action="store_true", help="the whole layout, for programs")
    export = actions.add_parser("export", help="write it for use without this package")
    export.add_argument("--out", type=Path, default=Path("policy"), help="folder (default: policy)")
    for action in (show, export):
        action.add_argument(
            "file", type=Path, nargs="?", help="policy.pt (default: of the current plan)"
        )
        add_store_argument(action)


def run(arguments: argparse.Namespace) -> None:
    """Show or export one policy."""
    file, origin = _choose(arguments)
    if arguments.action == "export":
        from slider.control.export import export

        make_folder(arguments.out)
        observations, difference = export(file, origin, arguments.out)
        print("\n".join(str(arguments.out / name) for name in EXPORT_FILES))
        found = f"{observations} observations of a roll-out: {difference:.1e}"
        print(f"largest difference of an action over {found}")
        return
    from slider.control.layout import describe
    from slider.control.policy import load_policy

    layout = describe(load_policy(file), origin)
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

    network, observation, action = layout["network"], layout["observation"], layout["action"]
    widths = [observation["size"], *network["hidden"], action["size"]]
    terms = [
        term | {"unit": ", ".join(dict.fromkeys(term["units"]))} for term in observation["terms"]
    ]
    tables = [
        pd.DataFrame(
            [{title: row["name"]} | {name: row[name] for name in columns} for row in rows]
        ).to_string(index=False, float_format="{:g}".format)
        for title, rows, columns in (
            ("observation", terms, ("start", "width", "scale", "frame", "unit")),
            ("joint", action["joints"], ("nominal", "scale", "lower", "upper")),
            ("motor", action["motors"], ("kp", "kd", "torque_limit", "no_load_speed")),
        )
    ]
    offset, clock = "the nominal pose", "none"
    if action["offset"] != "nominal":
        acceleration = layout["reference"]["acceleration"]
        offset = f"the gait of the reference velocity, which changes by {acceleration:g} m/s²"
    if layout["clock"] is not None:
        times = np.ravel(layout["clock"]["step_time"])
        mirror = "mirrored in right stance" if layout["clock"]["mirror"] else "not mirrored"
        clock = f"steps of {times.min():.2f} to {times.max():.2f} s, {mirror}"
    facts = [
        f"robot           {layout['robot']}",
        f"control period  {layout['control_period']:g} s",
        f"network         {' × '.join(map(str, widths))}, {network['activation']}",
        "training        " + ", ".join(f"{k} {v:g}" for k, v in layout["training"].items()),
        f"clock           {clock}",
        f"actions about   {offset}",
    ]
    return "\n\n".join(["\n".join(facts), *tables])
