"""``slider robot``: what a robot's file gives, as numbers and as a picture."""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from slider.config.compose import compose
from slider.config.model_file import ModelFile
from slider.config.robot import RobotConfig
from slider.config.robot_file import model_of
from slider.core.errors import UserError
from slider.robot import names
from slider.robot.bodies import prismatic_bodies, total_mass
from slider.robot.kinematics import foot_ends, leg_points
from slider.robot.knee_map import with_upper_feet
from slider.robot.transmission import Transmission


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("robot", help="a file, such as ./robot.yaml, or a robot of conf/robot")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument("--draw", type=Path, metavar="PNG", help="draw the nominal pose")


def run(arguments: argparse.Namespace) -> None:
    """Print masses, axes, ranges and torques; draw the robot if asked to."""
    if arguments.draw is not None and arguments.draw.suffix != ".png":
        raise UserError(f"--draw: expected a name that ends in .png, found {arguments.draw}")
    robot = compose([f"robot={arguments.robot}"], arguments.conf).robot
    print("\n".join(_lines(robot, model_of(arguments.robot))))
    if arguments.draw is not None:
        _draw(robot, arguments.draw)
        print(f"{arguments.draw} is ready")


def _lines(robot: RobotConfig, model: ModelFile | None) -> Iterator[str]:
    geometry, bodies = robot.geometry, prismatic_bodies(robot)
    yield (
        f"{robot.name}: {total_mass(bodies):.2f} kg, base {geometry.standing_height:.3f} m above "
        f"the ground, legs of {geometry.leg_length:.3f} m, {2 * geometry.hip[1]:.3f} m apart"
    )
    if model is not None:
        difference, part = model.differs
        yield f"left and right differ by {difference:.1%} ({part})"
        held = (f"{name} with {mass:.2f} kg" for name, mass in model.held.items())
        yield f"held: {', '.join(held) or 'nothing'}"
    yield ""
    yield f"{'link':<12}{'mass [kg]':>10}  {'centre [m]':>24}  {'principal moments [kg m²]':>30}"
    for name, link in vars(robot.links).items():
        place = " ".join(f"{value:7.4f}" for value in link.com)
        moments = " ".join(f"{value:9.3g}" for value in np.linalg.eigvalsh(link.tensor))
        yield f"{name:<12}{link.mass:10.3f}  {place:>24}  {moments:>30}"
    yield ""
    yield f"{'joint':<12}{'range [rad, m]':>18}"
    for name, joint in robot.joints.items():
        bounds = f"{joint.lower:.3f} to {joint.upper:.3f}"
        yield f"{name:<12}{bounds:>18}"
    yield ""
    yield f"{'motor':<12}{'limit':>10}{'one leg':>10}{'share':>8}   standing on the left leg"
    motors = Transmission.of(robot)
    needed = motors.torques(with_upper_feet(_standing_efforts(robot)[None]))[0]
    for name, limit, torque in zip(names.LEG_MOTORS, motors.torque, needed, strict=False):
        yield f"{name:<12}{limit:10.1f}{torque:10.1f}{abs(torque) / limit:8.0%}"


def _standing_efforts(robot: RobotConfig) -> np.ndarray:
    """Joint efforts (10,) that hold the nominal pose on the left foot, which does not turn."""
    from slider.gait.rooted import NUM, RootedRobot

    still = np.zeros(NUM)
    return RootedRobot(robot).dynamics(still, still)[1].full().ravel()[1:]


def _draw(robot: RobotConfig, path: Path) -> None:
    """The nominal pose from the right and from the front, with the axes of the left leg."""
    from slider.reports.figures.style import DARK, LIGHT, MIDDLE, new_figure, style

    geometry, zero = robot.geometry, np.zeros((1, names.NUM_JOINTS))
    upright = np.eye(3)[None]
    base = np.array([0.0, 0.0, geometry.standing_height])
    points = leg_points(geometry, upright, zero)[0] + base
    feet = foot_ends(geometry, upright, zero)[0] + base
    axes = geometry.axes
    steps = np.array([axes.hip_yaw, axes.hip_roll, axes.hip_pitch])
    places = np.vstack([base, base + steps.cumsum(axis=0)])
    marks: dict[str, Any] = dict(zip(("hip_yaw", "hip_roll", "hip_pitch"), places[1:], strict=True))
    marks["ankle"] = points[0, 1]
    with style():
        figure = new_figure(4.5)
        for panel, across, title in zip(
            figure.subplots(1, 2, sharey=True), (0, 1), ("right", "front"), strict=True
        ):
            for leg, colour in ((1, LIGHT), (0, DARK)):
                hip, ankle, top, back, front = points[leg]
                chain = [base, hip, top, ankle] if leg else [*places, top, ankle]
                for line in (np.array(chain), feet[leg], np.array([back, front])):
                    panel.plot(line[:, across], line[:, 2], color=colour, linewidth=2)
            panel.plot(base[across], base[2], "s", color=DARK, markersize=9)
            panel.axhline(0.0, color=MIDDLE, linewidth=0.8)
            for k, (name, place) in enumerate(marks.items()):
                panel.plot(place[across], place[2], "o", color=MIDDLE, markersize=4)
                panel.annotate(
                    name,
                    (place[across], place[2]),
                    (0.98, 0.8 - 0.08 * k),
                    textcoords="axes fraction",
                    ha="right",
                    arrowprops={"arrowstyle": "-", "color": LIGHT},
                )
            panel.set(aspect="equal", title=f"from the {title}", xlabel="xy"[across] + " [m]")
            panel.set_xlim(-0.7, 0.7)
        figure.savefig(path)
