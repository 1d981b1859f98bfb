"""Rules of the model-predictive controllers."""

from collections.abc import Mapping

from slider.config.control import (
    PAPER_LABELS,
    POLICY,
    POLICY_LABEL,
    SMOKE_AGENTS,
    AnyControl,
    MpcConfig,
)
from slider.config.env import EnvConfig, PhysicsConfig
from slider.config.validation.checks import multiple, named, ordered, require

LEAST_RATE = 200  # [Hz]
_TAKEN = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names with a meaning of their own


def check_controls(controls: Mapping[str, AnyControl], env: EnvConfig) -> None:
    """Every controller beside the policy; people tell them apart by their labels."""
    named("control", controls)
    labels = {POLICY_LABEL: POLICY, **{label: name for name, label in PAPER_LABELS.items()}}
    for name, control in controls.items():
        key = f"control.{name}"
        require(name not in _TAKEN, key, f"another name than {', '.join(_TAKEN)}", name)
        _label(control.label, labels, f"{key}.label")
        labels[control.label] = name
        _control(control, env, key)


def _label(label: str, taken: Mapping[str, str], key: str) -> None:
    """One line of text that no other controller has; ``taken`` are labels with their owners."""
    require(bool(label.strip()), key, "a label", "none")
    require(label.isprintable() and label == label.strip(), key, "one line of text", repr(label))
    owner = taken.get(label)
    expected = f"another label than that of {owner} (a file without one inherits it)"
    require(label not in taken, key, expected, label)


def _control(control: AnyControl, env: EnvConfig, key: str) -> None:
    _substeps(control.substeps, env.physics, f"{key}.substeps")
    if isinstance(control, MpcConfig):
        step, planner = control.step, control.planner
        ordered(f"{key}.step", step.time_min, step.time)
        ordered(f"{key}.step", step.time, step.time_max)
        ordered(f"{key}.planner.width_min", planner.width_min, planner.width_max)
    if control.observer is not None:
        period = env.physics.timestep * control.substeps
        multiple(f"{key}.observer.delay", control.observer.delay, period)


def _substeps(substeps: int, physics: PhysicsConfig, key: str) -> None:
    """Ticks of the controller end with steps of the physics, and are short."""
    divides = physics.substeps % substeps == 0
    require(divides, key, f"a divisor of env.physics.substeps ({physics.substeps})", substeps)
    rate = 1 / (physics.timestep * substeps)
    expected = f"a control rate of at least {LEAST_RATE} Hz"
    require(rate > LEAST_RATE - 0.1, key, expected, f"{rate:.0f} Hz")
