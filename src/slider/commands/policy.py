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
_ORIGINS = {
    "nominal": "the nominal pose",
}


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
    else:
        _show(file, origin, arguments.json)


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
    found = export(file, origin, out)
    for name in EXPORT_FILES:
        print(out / name)
    print(
        f"largest difference of an action over {found.observations} observations of a roll-out: "
        f"ONNX {found.onnx:.1e}, torch.export {found.torch_export:.1e}"
    )


def _show(file: Path, origin: dict[str, Any], as_json: bool) -> None:
    from slider.control.layout import describe
    from slider.control.policy import load_policy

    layout = describe(load_policy(file), origin)
    print(json.dumps(layout, indent=1) if as_json else "\n".join(summary_lines(layout)))


def summary_lines(layout: dict[str, Any]) -> list[str]:
    """A layout for people."""
    network, observation, action = layout["network"], layout["observation"], layout["action"]
    widths = [observation["size"], *network["hidden"], action["size"]]
    clock = layout["clock"]
    lines = [
        f"robot           {layout['robot']}",
        f"control period  {layout['control_period']:g} s",
        f"network         {' × '.join(map(str, widths))}, {network['activation']}",
        "training        " + ", ".join(f"{k} {v:g}" for k, v in layout["training"].items()),
        "clock           " + _clock_line(clock),
        f"actions about   {_origin(layout)}",
        "",
        f"{'observation':<26}{'at':>4}{'width':>7}{'scale':>7}  frame    unit",
    ]
    lines += [
        f"{t['name']:<26}{t['start']:>4}{t['width']:>7}{t['scale']:>7g}  {t['frame']:<9}"
        + ", ".join(dict.fromkeys(t["units"]))
        for t in observation["terms"]
    ]
    lines += [
        "",
        f"{'joint':<18}{'nominal':>8}{'scale':>7}{'lower':>8}{'upper':>8}",
    ]
    lines += [
        f"{j['name']:<18}{j['nominal']:>8g}{j['scale']:>7g}{j['lower']:>8g}{j['upper']:>8g}"
        for j in action["joints"]
    ]
    lines += ["", f"{'motor':<18}{'kp':>8}{'kd':>7}{'torque':>8}{'speed':>8}"]
    lines += [
        f"{m['name']:<18}{m['kp']:>8g}{m['kd']:>7g}{m['torque_limit']:>8g}{m['no_load_speed']:>8g}"
        for m in action["motors"]
    ]
    return lines


def _origin(layout: dict[str, Any]) -> str:
    offset = layout["action"]["offset"]
    if offset in _ORIGINS:
        return _ORIGINS[offset]
    acceleration = layout["reference"]["acceleration"]
    return f"the gait of the reference velocity, which changes by {acceleration:g} m/s²"


def _clock_line(clock: dict[str, Any] | None) -> str:
    if clock is None:
        return "none"
    times = np.ravel(clock["step_time"])
    mirror = "mirrored in right stance" if clock["mirror"] else "not mirrored"
    return f"steps of {times.min():.2f} to {times.max():.2f} s, {mirror}"
