"""The gait library: maps over the commanded velocity, and the limit cycle of each gait."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from slider.library.reader import GaitLibrary
from slider.reports.controllers import colour
from slider.reports.page import Section, chart
from slider.reports.sections.sources import Sources
from slider.reports.sections.velocity_map import velocity_map
from slider.robot.names import CHANNELS

MAP, CYCLE = "gait-map", "limit-cycle"
_FIRST_SHOWN = (0.6, 0.0)  # the cycle drawn before anything is hovered [m/s]


@dataclass(frozen=True)
class _Gaits:
    """What is drawn of G gaits with S samples each."""

    velocities: np.ndarray  # (G, 2) [m/s]
    quantities: dict[str, np.ndarray]  # title → (G,)
    cycles: dict[str, np.ndarray]  # title → (G, curves, S, 2), closed curves


def section(sources: Sources) -> Section:
    """A map whose colour can be chosen; hovering a gait draws its limit cycle beside it."""
    gaits = _read(sources.file("library", "library.zarr"))
    first = int(np.argmin(np.linalg.norm(gaits.velocities - _FIRST_SHOWN, axis=1)))
    cycle = chart(
        CYCLE,
        _cycle_figure(gaits, first),
        "Limit cycles of the gait under the pointer: positions against velocities over one walk "
        "of two steps; straight jumps are the impacts.",
        height=360,
    )
    overview = chart(
        MAP,
        velocity_map(gaits.velocities, gaits.quantities),
        "Gaits of the library at their commanded velocities. The menu above chooses the colour.",
        height=360,
        linked=CYCLE,
        details=_details(gaits),
    )
    values = {
        "charts": [overview, cycle],
        "count": len(gaits.velocities),
        "first": gaits.velocities[first],
    }
    return Section("Gait library", "gaits.html", values)


def _read(path: Path) -> _Gaits:
    library = GaitLibrary.load(path)
    arrays = library.arrays
    quantities = {
        "step time [s]": library.step_time.mean(axis=1),
        "cost, log10": np.log10(arrays["cost"]),
        "peak joint torque [N m]": np.abs(arrays["knee_torques"]).max(axis=(1, 2)),
        "base height [m]": library.base[:, :, 2].mean(axis=1),
        "worst violation, log10": np.log10(np.maximum(arrays["max_violation"], 1e-16)),
        "iterations": arrays["iterations"].astype(float),
    }
    return _Gaits(library.velocities, quantities, _cycles(library.samples, arrays["roll"]))


def _cycles(samples: np.ndarray, roll: np.ndarray) -> dict[str, np.ndarray]:
    """Phase portraits (G, curves, S, 2): the unactuated roll, then joints of both legs."""
    # The second step is stored reflected, which turns the sign of a roll.
    unreflected = roll[..., :2] * np.array([1.0, -1.0])[None, :, None, None]
    flat = unreflected.reshape(len(roll), 1, -1, 2)
    joints = {
        "hip pitch [rad], [rad/s]": ("left_hip_pitch", "right_hip_pitch"),
        "slide [m], [m/s]": ("left_slide", "right_slide"),
    }
    portraits = {"roll about the foot [rad], [rad/s]": flat}
    for title, names in joints.items():
        portraits[title] = np.stack([_portrait(samples, name) for name in names], axis=1)
    return {title: np.concatenate([x, x[:, :, :1]], axis=2) for title, x in portraits.items()}


def _portrait(samples: np.ndarray, joint: str) -> np.ndarray:
    channels = [CHANNELS.index(f"{joint}.{kind}") for kind in ("position", "velocity")]
    return samples[:, :, channels]


def _cycle_figure(gaits: _Gaits, index: int) -> go.Figure:
    figure = make_subplots(1, len(gaits.cycles), subplot_titles=list(gaits.cycles))
    for column, portraits in enumerate(gaits.cycles.values(), start=1):
        for curve, portrait in enumerate(portraits[index]):
            figure.add_scatter(
                x=np.round(portrait[:, 0], 4),
                y=np.round(portrait[:, 1], 4),
                mode="lines+markers",
                name=("left", "right")[curve],
                legendgroup=str(curve),
                showlegend=column == 2,
                marker={"size": 3, "color": colour(curve)},
                line={"color": colour(curve), "width": 1.8, "dash": ("solid", "dot")[curve]},
                row=1,
                col=column,
            )
    figure.update_layout(legend={"orientation": "h", "y": -0.12, "x": 0.5, "xanchor": "center"})
    figure.update_annotations(font_size=12)
    return figure


def _details(gaits: _Gaits) -> str:
    """For each gait its title, and x and y of each curve of the figure of cycles, as JSON."""
    vx, vy = gaits.velocities.T
    curves = [
        [
            np.round(portrait, 4).T.tolist()
            for portraits in gaits.cycles.values()
            for portrait in portraits[index]
        ]
        for index in range(len(vx))
    ]
    titles = [f"{x:.2f}, {y:+.2f} m/s" for x, y in zip(vx, vy, strict=True)]
    return json.dumps({"titles": titles, "curves": curves}, separators=(",", ":"))
