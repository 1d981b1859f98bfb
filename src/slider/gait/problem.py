"""A gait problem: functions, bounds and names.

Built once (``build``), solved for many velocities (``slider.gait.solve``).
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from slider.config.gait import FormulationConfig
from slider.gait.constraint import Constraint, RowInfo
from slider.gait.formulation import Formulation
from slider.gait.layout import Layout
from slider.gait.pieces import Piece, collocation_piece, ends_piece, node_piece, quantities
from slider.gait.tree import NUM_JOINTS

ROLL_BOUNDS = (0.6, 6.0, 200.0)  # generous: solutions stay inside [rad, rad/s, rad/s²]
DENSE = 10  # phases per node interval at which a solution is checked


@dataclass(frozen=True)
class Block:
    """Rows of one named constraint in the stacked vector."""

    name: str
    unit: str
    scale: float
    rows: np.ndarray


Bounds = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class GaitProblem:
    """Everything that a solver needs but the command, the step time and its options.

    Attributes:
        config: of the formulation.
        layout: of the variables.
        node, ends, collocation: functions with derivatives, rows scaled.
        gradient: of a node's cost.
        quantities: of a node, for the stored gait.
        node_rows, end_rows: names of the rows of a node and of the step ends.
        bounds: scaled lower and upper bounds: ``joint`` (10,) positions, ``node`` (nodes, rows),
            ``dense`` (phases, rows) without the nodes' margins, ``ends`` (rows,).
    """

    config: FormulationConfig
    layout: Layout
    node: Piece
    ends: Piece
    collocation: Piece
    gradient: ca.Function
    quantities: ca.Function
    node_rows: list[RowInfo]
    end_rows: list[RowInfo]
    bounds: dict[str, Bounds]

    @property
    def nodes(self) -> int:
        """Nodes per step."""
        return self.layout.nodes

    @cached_property
    def row_counts(self) -> tuple[int, int, int]:
        """Rows of one node, of the collocation and of the step ends."""
        node = sum(info.size for info in self.node_rows)
        ends = sum(info.size for info in self.end_rows)
        return node, self.collocation.value.size1_out(0), ends

    @cached_property
    def row_bounds(self) -> Bounds:
        """Scaled lower and upper bounds of all rows."""
        zero = np.zeros(self.row_counts[1])
        lower, upper = (
            np.concatenate([node.ravel(), node.ravel(), zero, ends])
            for node, ends in zip(self.bounds["node"], self.bounds["ends"], strict=True)
        )
        return lower, upper

    @cached_property
    def blocks(self) -> list[Block]:
        """Where each named constraint is, for residuals by name."""
        node_rows, collocation_rows, _ = self.row_counts
        total = 2 * self.nodes * node_rows
        blocks = node_blocks(self.node_rows, 2 * self.nodes)
        blocks.append(Block("collocation", "rad", 1.0, total + np.arange(collocation_rows)))
        offset = total + collocation_rows
        for info in self.end_rows:
            rows = offset + np.arange(info.size)
            blocks.append(Block(info.name, info.unit, info.scale, rows))
            offset += info.size
        return blocks

    def variable_bounds(self, duration: tuple[float, float]) -> Bounds:
        """Lower and upper bounds of the variables, the step time within ``duration`` [s].

        The second step's time equals the first one's; bounds on it too would be redundant, which
        leaves the multipliers undetermined.
        """
        rolls = np.tile(ROLL_BOUNDS, self.nodes)
        place = self.layout.joints.bounded
        sides = []
        for sign, joints, time in zip((-1.0, 1.0), self.bounds["joint"], duration, strict=True):
            step = np.where(place < 0, sign * np.inf, joints[place])
            sides.append(np.tile(np.concatenate([step, [time], sign * rolls]), 2))
        second = self.layout.time_index(1)
        sides[0][second], sides[1][second] = duration[0] / 2, duration[1] * 2
        return sides[0], sides[1]


def node_blocks(infos: list[RowInfo], count: int) -> list[Block]:
    """Blocks of rows that repeat for ``count`` nodes."""
    per_node = sum(info.size for info in infos)
    starts, offset, blocks = np.arange(count) * per_node, 0, []
    for info in infos:
        rows = (starts[:, None] + offset + np.arange(info.size)).ravel()
        blocks.append(Block(info.name, info.unit, info.scale, rows))
        offset += info.size
    return blocks


def build(form: Formulation) -> GaitProblem:
    """Derive all functions and collect names and bounds."""
    layout = Layout.of(form.config)
    node, gradient, node_constraints = node_piece(form)
    ends, end_constraints = ends_piece(form)
    dense = np.linspace(0.0, 1.0, DENSE * (layout.nodes - 1) + 1)
    return GaitProblem(
        config=form.config,
        layout=layout,
        node=node,
        ends=ends,
        collocation=collocation_piece(layout),
        gradient=gradient,
        quantities=quantities(form),
        node_rows=[c.info for c in node_constraints],
        end_rows=[c.info for c in end_constraints],
        bounds={
            "joint": _joint_bounds(form),
            "node": _stack(node_constraints, layout.phase, True),
            "dense": _stack(node_constraints, dense, False),
            "ends": (
                np.concatenate([c.bounds(np.zeros(1))[0][0] for c in end_constraints]),
                np.concatenate([c.bounds(np.zeros(1))[1][0] for c in end_constraints]),
            ),
        },
    )


def _stack(constraints: list[Constraint], phase: np.ndarray, at_nodes: bool) -> Bounds:
    parts = [c.bounds(phase, at_nodes) for c in constraints]
    return np.concatenate([p[0] for p in parts], 1), np.concatenate([p[1] for p in parts], 1)


def _joint_bounds(form: Formulation) -> Bounds:
    """Of yaw, roll and knee; hip pitch and ankle are bounded after eq. 1, at the nodes."""
    joints, posture = form.robot.joints, form.config.posture
    yaw, roll, free = joints["hip_yaw"], joints["hip_roll"], np.pi
    lower = np.tile([yaw.lower, roll.lower, -free, posture.knee_min, -free], 2)
    upper = np.tile([yaw.upper, roll.upper, free, posture.knee_max, free], 2)
    assert len(lower) == NUM_JOINTS
    return lower, upper
