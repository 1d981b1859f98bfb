"""From the arguments of ``slider play`` to what is shown."""

from argparse import Namespace
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TypeVar

from slider.artefacts.plan import JobSpec, read_plan
from slider.artefacts.store import Store
from slider.config.compose import compose
from slider.config.env import EnvConfig, PlantConfig
from slider.config.robot import RobotConfig
from slider.control.policy_file import load_policy
from slider.core.errors import UserError
from slider.env.terms import checked
from slider.library.reader import GaitLibrary
from slider.play.baseline import simulate_baseline
from slider.play.motion import Motion, Replay, simulate_ignorant, simulate_policy

Section = TypeVar("Section", EnvConfig, RobotConfig)


@dataclass(frozen=True)
class Scene:
    """A motion and the robot that moves."""

    title: str
    robot: RobotConfig
    motion: Motion


def build(arguments: Namespace) -> Scene:
    """Scene that the arguments ask for.

    Raises:
        UserError: there is no such policy or library, or they contradict each other.
    """
    if arguments.gait is not None:
        return _replay(arguments)
    if arguments.agent != "policy":
        if arguments.policy is not None:
            raise UserError(f"expected --policy with the agent policy, found {arguments.agent}")
        return (
            _baseline(arguments) if arguments.agent.startswith("mpc_wbc_") else _ignorant(arguments)
        )
    return _policy(arguments)


def _policy(arguments: Namespace) -> Scene:
    config = checked(compose(arguments.set, arguments.conf))
    plain = compose([], arguments.conf)
    path = arguments.policy
    if path is None:
        path = _current(arguments.artefacts, "walking", "policy.pt")
    policy = load_policy(path)
    robot = _changed(policy.robot, config.robot, plain.robot)
    env = _changed(policy.env, config.env, plain.env)
    test = config.evaluation
    motion = simulate_policy(policy, robot, env, test.start, arguments.seed, test.disturbance)
    return Scene(f"policy {path}", robot, motion)


def _changed(own: Section, asked: Section, plain: Section) -> Section:
    """What a policy was trained with, but for the parts that the overrides change."""
    names = [item.name for item in fields(own)]
    parts = {name: getattr(asked, name) for name in names}
    return replace(own, **{n: part for n, part in parts.items() if part != getattr(plain, n)})


def _baseline(arguments: Namespace) -> Scene:
    config = checked(compose(arguments.set, arguments.conf))
    control = getattr(config.control, arguments.agent.removeprefix("mpc_wbc_"))
    test = config.evaluation
    plant = PlantConfig(config.env.control_period, config.env.physics, config.env.termination)
    motion = simulate_baseline(
        config.robot, plant, control, test.start, arguments.seed, test.disturbance
    )
    return Scene(f"baseline {arguments.agent}", config.robot, motion)


def _ignorant(arguments: Namespace) -> Scene:
    config = checked(compose(arguments.set, arguments.conf))
    random = arguments.agent == "random"
    noise = config.evaluation.start
    motion = simulate_ignorant(config.robot, config.env, noise, arguments.seed, random)
    return Scene(f"agent {arguments.agent}", config.robot, motion)


def _replay(arguments: Namespace) -> Scene:
    config = checked(compose(arguments.set, arguments.conf))
    path = arguments.library
    if path is None:
        path = _current(arguments.artefacts, "library", "library.zarr")
    library = GaitLibrary.load(path)
    wanted_vx, wanted_vy = arguments.gait
    motion = Replay(library, wanted_vx, wanted_vy, config.env.control_period)
    vx, vy = motion.velocity
    return Scene(f"gait {vx:.2f} {vy:+.2f} m/s", config.robot, motion)


def _current(artefacts: Path, target: str, name: str) -> Path:
    """File of a target's result in the latest plan."""
    plans = sorted((artefacts / "plans").glob("*.json"), key=lambda path: path.stat().st_mtime)
    if not plans:
        raise UserError(f"expected a pipeline run in {artefacts}, found no plan there")
    plan = read_plan(plans[-1])
    job: JobSpec = plan.jobs[plan.targets[target]]
    store = Store(artefacts)
    if not store.manifest_path(job.stage, job.recipe).is_file():
        raise UserError(
            f"expected the {target} result of the latest plan in {artefacts}, found none: "
            "run the pipeline, or name a file"
        )
    result = store.read_manifest(job.stage, job.recipe).result
    return store.object_folder(result.object) / name
