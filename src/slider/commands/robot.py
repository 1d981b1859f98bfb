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
    picture = arguments.draw
    if picture is not None and not (picture.suffix == ".png" and picture.parent.is_dir()):
        raise UserError(f"--draw: expected a name that ends in .png in a folder, found {picture}")
    robot = compose([f"robot={arguments.robot}"], arguments.conf).robot
    print("\n".join(_lines(robot, model_of(arguments.robot))))
    if picture is not None:
        _draw(robot, picture)
        print(f"{picture} is ready")


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
    yield f"{'joint':<12}{'range [rad, m]':>18}{'damping':>10}{'armature':>10}"
    for name, joint in robot.joints.items():
        bounds = f"{joint.lower:.3f} to {joint.upper:.3f}"
        yield f"{name:<12}{bounds:>18}{joint.damping:10.4g}{joint.armature:10.4g}"
    yield ""
    yield f"{'motor':<12}{'limit':>12}{'on one leg':>12}{'share':>8}"
    motors = Transmission.of(robot)
    needed = motors.torques(with_upper_feet(_standing_efforts(robot)[None]))[0]
    shares = np.abs(needed) / motors.torque
    for name, limit, torque, share in zip(
        robot.leg_motors, motors.torque, needed, shares, strict=False
    ):
        unit = "N" if name == "slide" else "N m"
        yield f"{name:<12}{f'{limit:.1f} {unit}':>12}{f'{torque:.1f} {unit}':>12}{share:8.0%}"
    yield from _remarks(robot, shares[: len(robot.leg_motors)])


def _remarks(robot: RobotConfig, shares: np.ndarray) -> Iterator[str]:
    """Values that are accepted and probably wrong."""
    geometry, links = robot.geometry, robot.links
    if links.tube.com[2] < -geometry.leg_length - geometry.ankle_height:
        yield "remark: the tube's centre of mass is below the sole"
    x = sum(place * mass for place, mass in _places(robot)) / sum(m for _, m in _places(robot))
    if not -geometry.heel < x - geometry.hip[0] < geometry.toe:
        yield f"remark: the centre of mass is not above the feet, x = {x:.3f} m"
    if shares.max() > 1.0:
        name = robot.leg_motors[int(shares.argmax())]
        yield f"remark: {name} cannot hold the robot on one leg"
    for name, joint in robot.joints.items():
        if joint.armature > 0.0 and name in robot.drives and robot.drives[name].inertia > 0.0:
            yield f"remark: joints.{name}.armature and drives.{name}.inertia add up"


def _places(robot: RobotConfig) -> Iterator[tuple[float, float]]:
    """Forward place in the base's frame [m] and mass [kg] of each body, joints at zero."""
    axes, links = robot.geometry.axes, vars(robot.links)
    at = {"base": 0.0, "yaw": axes.hip_yaw[0]}
    at["roll"] = at["yaw"] + axes.hip_roll[0]
    for name, link in links.items():
        place = at.get(name, robot.geometry.hip[0]) + link.com[0]
        yield place, link.mass * (1 if name == "base" else 2)


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
