"""The controllers of ``conf/control`` of any family: all that are not learned."""

from functools import partial

from slider.config.control import AnyControl, MpcConfig
from slider.config.env import PhysicsConfig
from slider.config.robot import RobotConfig
from slider.control.hzd.controller import EnforcedGaits, hzd_controller
from slider.control.mpc.controller import mpc_controller
from slider.control.whole_body.controller import ModelBased, WalkingController
from slider.control.whole_body.observed import observed
from slider.core.errors import UserError


def any_controller(
    robot: RobotConfig, config: AnyControl, period: float, gaits: EnforcedGaits | None
) -> WalkingController:
    """A controller for a nominal robot, with ticks of ``period`` [s].

    Raises:
        UserError: the controller walks by gaits, and there are none.
    """
    if isinstance(config, MpcConfig):
        return mpc_controller(robot, config, period)
    if gaits is None:
        raise UserError("controller: expected gaits to walk by, found none")
    return hzd_controller(robot, config, gaits, period)


def build_controller(
    robot: RobotConfig,
    config: AnyControl,
    physics: PhysicsConfig,
    count: int,
    gaits: EnforcedGaits | None = None,
    threads: int = 1,
) -> ModelBased:
    """``any_controller`` for ``count`` robots, behind its observer."""
    build = partial(any_controller, gaits=gaits)
    return observed(build, robot, config, physics, count, threads)
