"""Rules of the simulated environment and of what disturbs the robot in it."""

from slider.config.disturbance import DisturbanceConfig
from slider.config.env import EnvConfig
from slider.config.legs import LEG_JOINTS
from slider.config.validation.checks import multiple, require
from slider.config.validation.robot import check_names

MAX_CELLS = 400


def check_env(env: EnvConfig) -> None:
    """Steps that fill the control period, and a clock where something needs it."""
    period = env.physics.timestep * env.physics.substeps
    expected = f"timestep × substeps = control_period ({env.control_period} s)"
    require(abs(period - env.control_period) < 1e-9, "env.physics", expected, period)
    check_names("env.action.scale", env.action.scale, LEG_JOINTS)
    possible = env.phase.enabled or env.action.offset == "nominal"
    require(possible, "env.action.offset", "nominal where there is no phase", env.action.offset)
    halt = env.phase.halt
    expected = f"a value ≥ {halt.below}"
    require(halt.above >= halt.below, "env.phase.halt.above", expected, halt.above)
    possible = env.phase.enabled or not (env.phase.mirror or halt.below > 0)
    require(possible, "env.phase", "a clock for mirror and halt", "none")


def check_disturbance(disturbance: DisturbanceConfig, env: EnvConfig, key: str) -> None:
    """Times that the simulation can hit, and ground that repeats."""
    for name in ("lower", "upper"):
        delay = getattr(disturbance.delay, name)
        multiple(f"{key}.delay.{name}", delay, env.physics.timestep)
    multiple(f"{key}.push.interval", disturbance.push.interval, env.control_period)
    ground = disturbance.ground
    multiple(f"{key}.ground.period", ground.period, ground.cell)
    cells = round(ground.period / ground.cell)
    require(cells <= MAX_CELLS, f"{key}.ground.period", f"at most {MAX_CELLS} cells", cells)
