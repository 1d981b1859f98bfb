"""Parts of sections that several stages have in common."""

from dataclasses import replace
from typing import Any

from slider.artefacts.plan import JobSpec
from slider.config.convert import to_dict
from slider.config.schema import Config
from slider.core.machine import kernels


def only(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """Some of the values."""
    return {name: values[name] for name in names}


def without(values: dict[str, Any], *names: str) -> dict[str, Any]:
    """All values but some."""
    return {name: value for name, value in values.items() if name not in names}


def robot(config: Config) -> dict[str, Any]:
    """The robot; where its values come from changes no result."""
    return without(to_dict(config.robot), "provenance")


def simulation(config: Config) -> dict[str, Any]:
    """The robot and the environment of its policies, and what their networks compute with."""
    return {"robot": robot(config), "env": environment(config), "numerics": kernels()}


def environment(config: Config) -> dict[str, Any]:
    """The environment, without sensors that it does not use."""
    return to_dict(replace(config.env, onboard=config.env.estimation))


def plant(config: Config) -> dict[str, Any]:
    """The environment's part for controllers other than the policy."""
    return to_dict(config.env.plant)


def origin(job: JobSpec) -> dict[str, Any]:
    """Where a result comes from, for the stage that tells people."""
    return {
        "stage": job.stage,
        "label": job.label,
        "recipe": job.recipe,
        "source": job.code.source,
        "versions": job.code.versions,
    }
