"""The report page, its videos, and the renderer of this machine."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.stages.entries import job, origin, without
from pipeline.stages.evaluation import base_of, labels, lay_out, protocol_section
from slider.artefacts.plan import JobSpec
from slider.config.control import ONBOARD, POLICY
from slider.config.convert import to_dict
from slider.config.env import TerrainConfig
from slider.config.schema import Config
from slider.config.types import Interval
from slider.reports.sections import OPTIONAL, page_section

_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def report(config: Config, targets: Mapping[str, JobSpec]) -> JobSpec:
    """The report page; its sections declare what they need: targets, or inputs of targets."""
    available: dict[str, list[JobSpec]] = {name: [job] for name, job in targets.items()}
    if not targets["velocity_tracking"].inputs["evaluations"]:  # none of its speeds is evaluated
        del available["velocity_tracking"]
    for name, target in targets.items():
        available |= {f"{name}.{group}": list(jobs) for group, jobs in target.inputs.items()}
    available["videos"] = _videos(config, targets)
    inputs = {}
    for need in needs(config):
        name = need.removesuffix(OPTIONAL)
        if name == need or name in available:
            inputs[name] = available[name]
    shown = _shown(config, inputs)
    section = {
        "report": to_dict(config.report),
        "configuration": shown,
        "origins": {name: [origin(item) for item in jobs] for name, jobs in inputs.items()},
    }
    return job("report", "report", section, inputs)


def needs(config: Config) -> list[str]:
    """Distinct needs of the sections of the page."""
    names = (need for section in config.report.sections for need in page_section(section).needs)
    return list(dict.fromkeys(names))


def _shown(config: Config, inputs: Mapping[str, Sequence[JobSpec]]) -> dict[str, Any]:
    """The parts of the configuration that the page shows."""
    shown = without(
        to_dict(config), "resources", "tracking", "store", "study", "protocols", "gauge", "tuning"
    )
    shown["evaluation"] = protocol_section(config.evaluation)
    protocols = {name: p for name, p in config.protocols.items() if name in inputs}
    if protocols:
        shown["protocols"] = {name: protocol_section(p) for name, p in protocols.items()}
    names = [name for p in (config.evaluation, *protocols.values()) for name in p.controllers]
    if "gauge" in inputs:
        shown["gauge"] = to_dict(config.gauge)
        names += config.gauge.controllers
    used = set(map(base_of, names))
    shown["control"] = {name: node for name, node in shown["control"].items() if name in used}
    return shown


def _videos(config: Config, jobs: Mapping[str, JobSpec]) -> list[JobSpec]:
    """Videos of the controllers at some speeds, and of the policy on each kind of terrain."""
    video, evaluation = config.report.video, config.evaluation
    if video.renderer == "none":
        return []
    names = [name for name in evaluation.controllers if base_of(name) == name]
    videos = [v for name in names for v in _films(config, name, video.speeds, jobs)]
    if (filmed := video.terrain) is not None:
        for kind in filmed.kinds:
            terrain = TerrainConfig([kind], Interval(filmed.level, filmed.level), curriculum=False)
            disturbance = replace(evaluation.disturbance, terrain=terrain)
            there = replace(config, evaluation=replace(evaluation, disturbance=disturbance))
            videos += _films(there, f"{POLICY}{ONBOARD}", [filmed.speed], jobs)
    return videos


def _films(
    config: Config, controller: str, speeds: Sequence[float], jobs: Mapping[str, JobSpec]
) -> list[JobSpec]:
    """Videos of one controller, one per speed."""
    own = {
        "label": labels(config, [controller])[controller],
        "start": to_dict(config.evaluation.start),
        "disturbance": to_dict(config.evaluation.disturbance),
        "video": without(to_dict(config.report.video), "speeds", "terrain"),
    }
    ground = config.evaluation.disturbance.terrain.kinds[0].replace("_", " ")
    place = "" if ground == "flat" else f", {ground}"
    cases = {f" at {speed:.1f} m/s{place}": own | {"speed": speed} for speed in speeds}
    return lay_out(config, "video", "video", [controller], cases, jobs, tracked=False)


def with_renderer(config: Config) -> Config:
    """Replace ``report.video.renderer=auto`` by the renderer that works on this machine."""
    video = config.report.video
    if video.renderer != "auto":
        return config
    video = replace(video, renderer=find_renderer())
    return replace(config, report=replace(config.report, video=video))


def find_renderer() -> str:
    """The first of ``egl`` and ``osmesa`` that works, else ``none``; takes a millisecond."""
    if _egl_devices() > 0:
        return "egl"
    return "osmesa" if any(_load(name) for name in _OSMESA) else "none"


def _egl_devices() -> int:
    """Number of devices that EGL offers; MuJoCo renders on one of these."""
    library, count = _load("libEGL.so.1"), ctypes.c_int(0)
    if library is None:
        return 0
    library.eglGetProcAddress.restype = ctypes.c_void_p
    address = library.eglGetProcAddress(b"eglQueryDevicesEXT")
    number = ctypes.POINTER(ctypes.c_int)
    function = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, number)
    return count.value if address and function(address)(0, None, ctypes.byref(count)) else 0


def _load(name: str) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None
