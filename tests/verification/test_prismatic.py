"""The base wrench that the massless-leg assumption leaves, in MuJoCo."""

from dataclasses import replace

import numpy as np

from slider.robot.knee_model import build_knee_model
from slider.verification.pin_robot import PinRobot
from slider.verification.prismatic import PrismaticRobot, converted_at, residual_wrench
from tests.verification.sample import config, gaits, pinocchio


def light_legs(share: float):
    """The robot with all but a share of its legs' mass and inertia gone."""
    robot = config().robot
    links = robot.links
    light = {
        name: replace(
            getattr(links, name),
            mass=share * getattr(links, name).mass,
            inertia=tuple(share * i for i in getattr(links, name).inertia),
        )
        for name in ("yaw", "roll", "pitch", "tube", "foot", "upper_foot")
    }
    heavy = replace(links.base, mass=12.0, inertia=(0.3, 0.2, 0.2))
    return replace(robot, links=replace(links, base=heavy, **light))


def left_over(share: float) -> float:
    """Worst force or moment that pinocchio's ground wrench leaves on MuJoCo's base."""
    robot, gait = light_legs(share), gaits()[1]
    knee = PinRobot(build_knee_model(robot.geometry, robot.links, robot.virtual_knee))
    slides, worst = PrismaticRobot(robot), 0.0
    for step, motion in enumerate(gait.steps):
        for time in np.linspace(0.0, motion.duration, 5):
            joints, roll = motion.joints_at(time), motion.roll_at(time)
            state = knee.standing(roll, *joints, motion.side)
            _, wrench = knee.inverse_dynamics(state, motion.side)
            moved = converted_at(gait, knee, robot, step, time, "exact")
            worst = max(worst, np.abs(slides.residual(moved, wrench, motion.side)).max())
    return worst


def test_robots_with_massless_legs_are_the_same_in_both_models():
    assert left_over(1e-6) < 1e-4
    assert left_over(1e-3) > 1e-3


def test_the_assumption_costs_some_newtons_and_the_printed_map_more():
    found = residual_wrench(gaits()[1], pinocchio(), PrismaticRobot(config().robot))
    assert 1.0 < found["wrench_force_exact"] < found["wrench_force_paper"] < 123.0
    assert 0.1 < found["wrench_moment_exact"] < found["wrench_moment_paper"] < 30.0
