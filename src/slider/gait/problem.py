"""A gait problem: functions, bounds and names, for a solver.

Built once (``build``), solved for many velocities (``slider.gait.solve``).
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.core.casadi_code import Functions, Source, interpreted
from slider.gait.constraint import Constraint, scaled_bounds
from slider.gait.constraints import ROLL_BOUNDS, joint_bounds
from slider.gait.formulation import Formulation
from slider.gait.layout import Layout
from slider.gait.pieces import NodeTerms, Piece, WalkTerms, collocation


@dataclass(frozen=True)
class Block:
    """Rows of one named constraint in the stacked vector."""

    name: str
    scale: float
    rows: np.ndarray


Bounds = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class GaitProblem:
    """Everything that a solver needs but the command, the step time and its options.

    Attributes:
        form: what the gait is.
        layout: of the variables.
        node, ends, collocation: functions with derivatives, rows scaled.
        gradient: of a node's cost.
        quantities: of a node, for the stored gait.
        node_constraints, end_constraints: what the rows of a node and of the step ends are.
    """

    form: Formulation
    layout: Layout
    node: Piece
    ends: Piece
    collocation: Piece
    gradient: ca.Function
    quantities: ca.Function
    node_constraints: list[Constraint]
    end_constraints: list[Constraint]

    @property
    def config(self) -> FormulationConfig:
        """Settings of the formulation."""
        return self.form.config

    @property
    def nodes(self) -> int:
        """Nodes per step."""
        return self.layout.nodes

    @cached_property
    def row_counts(self) -> tuple[int, int, int]:
        """Rows of one node, of the collocation and of the step ends."""
        node = sum(c.size for c in self.node_constraints)
        ends = sum(c.size for c in self.end_constraints)
        return node, self.collocation.value.size1_out(0), ends

    @cached_property
    def row_bounds(self) -> Bounds:
        """Scaled lower and upper bounds of all rows."""
        zero = np.zeros(self.row_counts[1])
        nodes = scaled_bounds(self.node_constraints, self.layout.phase)
        ends = scaled_bounds(self.end_constraints, np.zeros(1))
        lower, upper = (
            np.concatenate([node.ravel(), node.ravel(), zero, end[0]])
            for node, end in zip(nodes, ends, strict=True)
        )
        return lower, upper

    @cached_property
    def blocks(self) -> list[Block]:
        """Where each named constraint is, for residuals by name."""
        node_rows, collocation_rows, _ = self.row_counts
        total = 2 * self.nodes * node_rows
        blocks = node_blocks(self.node_constraints, 2 * self.nodes)
        blocks.append(Block("collocation", 1.0, total + np.arange(collocation_rows)))
        offset = total + collocation_rows
        for constraint in self.end_constraints:
            rows = offset + np.arange(constraint.size)
            blocks.append(Block(constraint.name, constraint.scale, rows))
            offset += constraint.size
        return blocks

    def variable_bounds(self, duration: tuple[float, float]) -> Bounds:
        """Lower and upper bounds of the variables, the step time within ``duration`` [s].

        The second step's time equals the first one's; bounds on it too would be redundant, which
        leaves the multipliers undetermined.
        """
        rolls = np.tile(ROLL_BOUNDS, self.nodes)
        place = self.layout.joints.bounded
        sides = []
        for sign, joints, time in zip((-1.0, 1.0), joint_bounds(self.form), duration, strict=True):
            step = np.where(place < 0, sign * np.inf, joints[place])
            sides.append(np.tile(np.concatenate([step, [time], sign * rolls]), 2))
        second = self.layout.time_index(1)
        sides[0][second], sides[1][second] = duration[0] / 2, duration[1] * 2
        return sides[0], sides[1]


def node_blocks(constraints: list[Constraint], count: int) -> list[Block]:
    """Blocks of rows that repeat for ``count`` nodes."""
    per_node = sum(constraint.size for constraint in constraints)
    starts, offset, blocks = np.arange(count) * per_node, 0, []
    for constraint in constraints:
        rows = (starts[:, None] + offset + np.arange(constraint.size)).ravel()
        blocks.append(Block(constraint.name, constraint.scale, rows))
        offset += constraint.size
    return blocks


def build(form: Formulation, functions: Source = interpreted) -> GaitProblem:
    """Derive all functions of a formulation, or take those that ``functions`` has of it."""
    layout, node, walk = Layout.of(form.config), NodeTerms.of(form), WalkTerms.of(form)

    def derive() -> Functions:
        made = [*node.functions(), *walk.functions(), *collocation(layout)]
        return {function.name(): function for function in made}

    found = functions(form.facts, derive)
    pieces = {
        name: Piece(found[name], found[f"{name}_jacobian"], found[f"{name}_hessian"])
        for name in ("node", "ends", "collocation")
    }
    return GaitProblem(
        form=form,
        layout=layout,
        **pieces,
        gradient=found["cost"],
        quantities=found["quantities"],
        node_constraints=node.constraints,
        end_constraints=walk.constraints,
    )
