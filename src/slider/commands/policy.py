"""``slider policy``: what is in a policy file, and how to take it elsewhere."""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from slider.artefacts.current import add_store_argument, current_folder, current_result
from slider.artefacts.store import Store
from slider.core.errors import UserError

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
        _export(file, origin, arguments.out)
        return
    from slider.control.layout import describe
    from slider.control.policy import load_policy

    layout = describe(load_policy(file), origin)
    print(json.dumps(layout, indent=1) if arguments.json else summary(layout))


def _choose(arguments: argparse.Namespace) -> tuple[Path, dict[str, Any]]:
    """The policy file, and its origin in the store."""
    from slider.control import POLICY_FILE

    if arguments.file is not None:
        return arguments.file, {}
    store = Store(arguments.artefacts)
    folder = current_folder(store, "walking", _MAKE)
    job, _ = current_result(store, "walking", _MAKE)
    return folder / POLICY_FILE, {"recipe": job.recipe, "source": job.code.source}


def _export(file: Path, origin: dict[str, Any], out: Path) -> None:
    from slider.control import EXPORT_FILES
    from slider.control.export import export

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out: {out}: {error.strerror}") from None
    observations, difference = export(file, origin, out)
    for name in EXPORT_FILES:
        print(out / name)
    print(
        f"largest difference of an action over {observations} observations of a roll-out: "
        f"{difference:.1e}"
    )


def summary(layout: dict[str, Any]) -> str:
    """Facts of a policy, and tables of its observation, joints and motors."""
    import pandas as pd

    network, observation, action = layout["network"], layout["observation"], layout["action"]
    widths = [observation["size"], *network["hidden"], action["size"]]
    terms = [
        [*(f"{term[name]}" for name in ("name", "start", "width")), f"{term['scale']:g}"]
        + [term["frame"], ", ".join(dict.fromkeys(term["units"]))]
        for term in observation["terms"]
    ]
    joints = [_row(joint, "nominal", "scale", "lower", "upper") for joint in action["joints"]]
    limits = "kp", "kd", "torque_limit", "no_load_speed"
    tables = [
        pd.DataFrame(rows, columns=list(names)).to_string(index=False)
        for names, rows in (
            (("observation", "at", "width", "scale", "frame", "unit"), terms),
            (("joint", "nominal", "scale", "lower", "upper"), joints),
            (("motor", *limits), [_row(motor, *limits) for motor in action["motors"]]),
        )
    ]
    facts = [
        f"robot           {layout['robot']}",
        f"control period  {layout['control_period']:g} s",
        f"network         {' × '.join(map(str, widths))}, {network['activation']}",
        "training        " + ", ".join(f"{k} {v:g}" for k, v in layout["training"].items()),
        f"clock           {_clock(layout['clock'])}",
        f"actions about   {_offset(layout)}",
    ]
    return "\n\n".join(["\n".join(facts), *tables])


def _row(named: dict[str, Any], *names: str) -> list[str]:
    return [named["name"], *(f"{named[name]:g}" for name in names)]


def _offset(layout: dict[str, Any]) -> str:
    if layout["action"]["offset"] == "nominal":
        return "the nominal pose"
    acceleration = layout["reference"]["acceleration"]
    return f"the gait of the reference velocity, which changes by {acceleration:g} m/s²"


def _clock(clock: dict[str, Any] | None) -> str:
    if clock is None:
        return "none"
    times = np.ravel(clock["step_time"])
    mirror = "mirrored in right stance" if clock["mirror"] else "not mirrored"
    return f"steps of {times.min():.2f} to {times.max():.2f} s, {mirror}"
