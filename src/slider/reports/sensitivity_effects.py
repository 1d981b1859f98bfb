"""What a parameter does to gaits and policy, over both signs and all commands, and what is much."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from slider.reports.rows import Row, by

NOMINAL = "nominal"  # the parameter of the unchanged robot's rows
SUCCESS = 0.95  # share of robots below which a guess carries the policy's result
Cell = tuple[float, float]
"""Factor [-] and command [m/s]."""


@dataclass(frozen=True)
class Effect:
    """A parameter's effects.

    Attributes:
        parameter: its name.
        gaits: whether the gait converges, where that of the unchanged robot does.
        costs: relative change of the gait's cost; of gaits that converge.
        success: share of robots that survive.
        impossible: factor → why there is no such robot.
    """

    parameter: str
    gaits: Mapping[Cell, bool]
    costs: Mapping[Cell, float]
    success: Mapping[Cell, float]
    impossible: Mapping[float, str]

    @property
    def lost(self) -> list[Cell]:
        """Where the gait does not converge."""
        return [cell for cell, converged in self.gaits.items() if not converged]

    @property
    def cost(self) -> float:
        """Greatest change of a gait's cost, without its sign [-]."""
        return max(map(abs, self.costs.values()), default=0.0)

    def falls(self, nominal: Mapping[float, float]) -> dict[Cell, float]:
        """Success rates that are too low; ``nominal`` is that of the unchanged robot by command."""
        return {cell: s for cell, s in self.success.items() if s < limit(nominal[cell[1]])}

    def drop(self, nominal: Mapping[float, float]) -> float:
        """Greatest loss of success [-]."""
        losses = (nominal[cell[1]] - value for cell, value in self.success.items())
        return max(0.0, *losses) if self.success else 0.0

    def size(self, nominal: Mapping[float, float]) -> float:
        """By this the parameters are sorted: gaits lost count as 1, and the rest is a share."""
        return len(self.lost) + max(self.cost, self.drop(nominal))


def limit(nominal: float) -> float:
    """Least success rate that is not too low; an unchanged robot may already be below 95 %."""
    return SUCCESS if nominal >= SUCCESS else max(0.0, nominal - (1 - SUCCESS))


def effects(rows: Sequence[Row]) -> list[Effect]:
    """Effects of all parameters, the greatest first."""
    nominal, gaits = nominals(rows), nominals(rows, "gait_converged")
    known = {command for command, converged in gaits.items() if converged == 1}
    groups = by((row for row in rows if row["parameter"] != NOMINAL), "parameter")
    found = [_effect(name, mine, known) for name, mine in groups.items()]
    return sorted(found, key=lambda effect: -effect.size(nominal))


def nominals(rows: Sequence[Row], column: str = "success_rate") -> dict[float, float]:
    """A number of the unchanged robot by command; NaN where there is none."""
    return {row["command"]: row[column] for row in rows if row["parameter"] == NOMINAL}


def carrying(found: Sequence[Effect], nominal: Mapping[float, float]) -> list[Effect]:
    """Effects of the guesses that carry the result: a gait is lost, or success."""
    return [effect for effect in found if effect.lost or effect.falls(nominal)]


def _effect(name: str, rows: Sequence[Row], known: Collection[float]) -> Effect:
    """Of one parameter's rows; ``known`` are the commands with a gait of the unchanged robot."""

    def numbers(column: str) -> dict[Cell, float]:
        return {_cell(row): row[column] for row in rows if not math.isnan(row[column])}

    return Effect(
        name,
        {cell: bool(v) for cell, v in numbers("gait_converged").items() if cell[1] in known},
        numbers("gait_cost_change"),
        numbers("success_rate"),
        {row["factor"]: row["note"] for row in rows if row["note"]},
    )


def _cell(row: Row) -> Cell:
    return row["factor"], row["command"]
