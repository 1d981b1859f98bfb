"""Checks of the simulated environment: physics, actions, phase and observations."""

from slider.config.env import EnvConfig
from slider.config.validation.checks import (
    all_at_least,
    at_least,
    one_of,
    positive,
    require,
    some,
)
from slider.config.validation.robot import check_joints


def check_env(env: EnvConfig) -> None:
    """The plant, and what a policy sees and does."""
    _physics(env)
    _action(env)
    at_least("env.phase.step_time", env.phase.step_time, 0.0)
    positive("env.observation.clip", env.observation.clip)
    some("env.observation.terms", env.observation.terms, "term")
    at_least("env.observation.velocity_filter", env.observation.velocity_filter, 0.0)
    at_least("env.reference.acceleration", env.reference.acceleration, 0.0)
    scan = env.observation.height_scan
    all_at_least("env.observation.height_scan", scan, ("points_x", "points_y"), 1)
    _phase(env)


def _phase(env: EnvConfig) -> None:
    halt = env.phase.halt
    at_least("env.phase.halt.below", halt.below, 0.0)
    at_least("env.phase.halt.above", halt.above, halt.below)
    possible = env.phase.enabled or not (env.phase.mirror or halt.below > 0)
    require(possible, "env.phase", "mirror and halt only with a phase", env.phase)


def _physics(env: EnvConfig) -> None:
    positive("env.control_period", env.control_period)
    positive("env.physics.timestep", env.physics.timestep)
    at_least("env.physics.substeps", env.physics.substeps, 1)
    period = env.physics.timestep * env.physics.substeps
    expected = f"timestep × substeps = control_period ({env.control_period} s)"
    require(abs(period - env.control_period) < 1e-9, "env.physics", expected, period)


def _action(env: EnvConfig) -> None:
    check_joints("env.action.scale", env.action.scale)
    positive("env.action.clip", env.action.clip)
    one_of("env.action.offset", env.action.offset, ("nominal", "gait"))
    possible = env.phase.enabled or env.action.offset == "nominal"
    require(possible, "env.action.offset", "nominal where there is no phase", env.action.offset)
