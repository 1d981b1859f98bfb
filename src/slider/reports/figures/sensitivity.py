"""The sensitivity as a tornado plot: parameters below each other, the strongest first."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from slider.reports.controllers import PALETTE, speed
from slider.reports.figures.style import DARK, MIDDLE, new_figure
from slider.reports.rows import Row
from slider.reports.sensitivity_effects import SUCCESS, Effect, effects, nominals

SHOWN = 25  # parameters
_LOW, _HIGH = PALETTE[0], PALETTE[1]
_GROUND = "#f3f5f7"
_THICK = 0.36  # of a bar; two of them share a line
_EDGE = 0.08  # room beside the longest bar, as a share of it
_LEAST = 0.02  # half a panel shows at least this change of cost [-]


def draw(rows: Sequence[Row], change: float) -> Figure:
    """Bars to the changed gait's cost and to the policy's success, one panel per command."""
    found, nominal = effects(rows), nominals(rows)
    shown = found[:SHOWN]
    commands = list(nominal)
    kinds = [kind for kind in ("costs", "success") if _any(found, kind)]
    figure = new_figure(1.5 + 0.2 * len(shown))
    panels = figure.subplots(1, max(1, len(kinds) * len(commands)), sharey=True, squeeze=False)[0]
    axes = iter(panels)
    for kind in kinds:
        for command in commands:
            axis = next(axes)
            if kind == "costs":
                _draw_costs(axis, shown, command, _span(shown))
            else:
                _draw_success(axis, shown, command, nominal)
    _label(panels[0], shown)
    for panel in panels:
        _band(panel, len(shown))
    figure.legend(handles=_handles(change, kinds), loc="outside lower center", ncols=5)
    figure.suptitle(_title(found, shown, nominal), fontsize=8, x=0.01, ha="left")
    return figure


def _any(found: Sequence[Effect], kind: str) -> bool:
    if kind == "costs":
        return any(effect.gaits for effect in found)
    return any(effect.success for effect in found)


def _title(found: Sequence[Effect], shown: Sequence[Effect], nominal: Mapping[float, float]) -> str:
    if len(shown) == len(found):
        return f"All {len(found)} parameters"
    least = found[len(shown)]
    return (
        f"The strongest {len(shown)} of {len(found)} parameters; none of the others changes a "
        f"cost or a success rate by more than {100 * least.size(nominal):.2g} %"
    )


def _label(axis: Axes, shown: Sequence[Effect]) -> None:
    axis.set_yticks(range(len(shown)), [effect.parameter for effect in shown])
    axis.set_ylim(len(shown) - 0.4, -0.6)


def _band(axis: Axes, count: int) -> None:
    """Every other parameter on light ground, so that the eye finds its name."""
    for place in range(1, count, 2):
        axis.axhspan(place - 0.5, place + 0.5, color=_GROUND, linewidth=0, zorder=0)


def _span(shown: Sequence[Effect]) -> float:
    """Half width of the panels of costs [%], the same for all."""
    return 100 * (1 + _EDGE) * max([_LEAST, *(effect.cost for effect in shown)])


def _draw_costs(axis: Axes, shown: Sequence[Effect], command: float, span: float) -> None:
    for place, effect in enumerate(shown):
        for (factor, at), converged in effect.gaits.items():
            if at != command:
                continue
            y, colour = _line(place, factor)
            if converged and (factor, at) in effect.costs:
                axis.barh(y, 100 * effect.costs[factor, at], _THICK, color=colour)
            elif not converged:
                axis.plot(0, y, "x", color=colour, markersize=5, markeredgewidth=1.6, zorder=4)
        _mark_impossible(axis, place, effect, 0)
    axis.axvline(0, color=DARK, linewidth=0.8)
    axis.set_xlim(-span, span)
    axis.set_title(f"gait, {speed(command)} m/s")
    axis.set_xlabel("change of cost [%]")
    _quiet(axis)


def _draw_success(
    axis: Axes, shown: Sequence[Effect], command: float, nominal: Mapping[float, float]
) -> None:
    start = 100 * nominal[command]
    for place, effect in enumerate(shown):
        for (factor, at), success in effect.success.items():
            if at == command:
                y, colour = _line(place, factor)
                axis.barh(y, 100 * success - start, _THICK, left=start, color=colour)
        _mark_impossible(axis, place, effect, start)
    axis.axvline(start, color=DARK, linewidth=0.8)
    axis.axvline(100 * SUCCESS, color=MIDDLE, linewidth=0.8, linestyle="--")
    axis.set_xlim(-4, 104)
    axis.set_title(f"policy, {speed(command)} m/s")
    axis.set_xlabel("success [%]")
    _quiet(axis)


def _line(place: int, factor: float) -> tuple[float, str]:
    """Height and colour of a bar: the smaller value above the greater one."""
    return (place - _THICK / 2, _LOW) if factor < 1 else (place + _THICK / 2, _HIGH)


def _mark_impossible(axis: Axes, place: int, effect: Effect, x: float) -> None:
    for factor in effect.impossible:
        y, colour = _line(place, factor)
        axis.plot(x, y, "D", color=colour, markerfacecolor="white", markersize=4, zorder=4)


def _quiet(axis: Axes) -> None:
    """Lines between parameters, none through them."""
    axis.grid(False, axis="y")
    axis.tick_params(axis="y", length=0)


def _handles(change: float, kinds: Sequence[str]) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = [
        Patch(color=_LOW, label=f"value × {1 - change:g}"),
        Patch(color=_HIGH, label=f"value × {1 + change:g}"),
    ]
    if "costs" in kinds:
        text = "gait does not converge"
        handles.append(_marker("x", text, markeredgewidth=1.6))
    if "success" in kinds:
        text = f"{100 * SUCCESS:g} % success"
        handles.append(Line2D([], [], color=MIDDLE, linestyle="--", linewidth=0.8, label=text))
    return [*handles, _marker("D", "no such robot", markerfacecolor="white")]


def _marker(marker: str, label: str, **look: float | str) -> Line2D:
    settings = {"color": DARK, "markersize": 4, **look}
    return Line2D([], [], marker=marker, linestyle="", label=label, **settings)  # pyright: ignore[reportArgumentType]
