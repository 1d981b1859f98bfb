"""The model-based controllers of ``conf/control``."""

from collections.abc import Callable
from dataclasses import replace

from slider.config.control import AnyControl, MpcConfig
from slider.config.env import PhysicsConfig, PlantConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.hzd.steps import hzd_controller
from slider.control.mpc import mpc_controller
from slider.control.whole_body.controller import WalkingController
from slider.control.whole_body.observer import Observer
from slider.core.errors import UserError
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics


def build_controller(
    robot: RobotConfig,
    config: AnyControl,
    physics: PhysicsConfig,
    count: int,
    gaits: EnforcedGaits | None = None,
    threads: int = 1,
) -> WalkingController:
    """A controller for ``count`` robots, with the state observer of its settings, if any.

    The ``robot`` is the nominal one, not the plant; ``gaits`` are for the family ``hzd``. The
    observer's model has the ``physics`` of the plant and simulates on ``threads``.

    Raises:
        UserError: the controller enforces gaits, and there are none.
    """
    tick = replace(physics, substeps=config.substeps)
    period, observer = tick.substeps * tick.timestep, None
    if config.observer is not None:
        observer = Observer(robot, tick, config.observer, count, threads)
    if isinstance(config, MpcConfig):
        return mpc_controller(robot, config, period, observer)
    if gaits is None:
        raise UserError("controller: expected gaits to walk by, found none")
    return hzd_controller(robot, config, gaits, period, observer)


def build_plant(
    robot: RobotConfig,
    plant: PlantConfig,
    control: AnyControl,
    count: int,
    disturbance: Disturbance | None = None,
    threads: int = 1,
    engine: Callable[..., BatchedPhysics] = BatchedPhysics,
) -> BatchedPhysics:
    """The simulation on torque drives, stepped from one control tick to the next."""
    settings = replace(plant.physics, substeps=control.substeps)
    onboard = plant.estimation
    return engine(
        robot, settings, count, threads, "torque", disturbance=disturbance, onboard=onboard
    )
