"""The study of the gait optimisation: other meshes, and random starts.

All jobs are independent. The mesh of the library has the library's own gaits, and further starts
leave the first ones alone.
"""

from dataclasses import replace
from typing import Any

from pipeline.stages.entries import job
from pipeline.stages.gaits import gait, gait_section
from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.schema import Config

NAME = "gait_convergence"


def gait_study_job(config: Config) -> JobSpec:
    """Gaits on every mesh and from every start, and the tables of them."""
    study, shared = config.gait_study, gait_section(config)
    meshes = [
        _on_mesh(shared, command, nodes) for command in study.commands for nodes in study.nodes
    ]
    starts = [
        gait_start(config, command, index)
        for command in study.commands
        for index in range(study.starts.number)
    ]
    section = {"study": to_dict(study), "max_violation": config.library.max_violation}
    own = [gait(shared, (command, 0.0, 0.0)) for command in study.commands]
    return job(NAME, NAME, section, {"meshes": meshes, "starts": starts, "library": own})


def gait_start(config: Config, command: float, index: int) -> JobSpec:
    """One gait from a random start alone; it does not know how many there are."""
    starts = config.gait_study.starts
    start = {"seed": starts.seed, "index": index, "spread": to_dict(starts.spread)}
    section = gait_section(config) | {"command": [command, 0.0, 0.0], "start": start}
    return job("gait_start", f"gait {command:.2f} m/s from start {index}", section, tracked=False)


def _on_mesh(shared: dict[str, Any], command: float, nodes: int) -> JobSpec:
    formulation = shared["formulation"] | {"nodes": nodes}
    made = gait(shared | {"formulation": formulation}, (command, 0.0, 0.0))
    return replace(made, label=f"{made.label}, {nodes} nodes")
