"""``slider robot``: the parameters that result from a robot file, as text and as a drawing."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from slider.composition.compose import compose
from slider.composition.robot_file import read_option
from slider.config.parameters import parameters
from slider.config.robot import Geometry, RobotConfig
from slider.core.errors import require
from slider.robot.knee_map import all_joints
from slider.robot.mjcf import SimulationOptions, build_model
from slider.robot.model_file import APART, ModelFile
from slider.robot.model_motors import GUESS
from slider.robot.transmission import Transmission

_SEEN, _LEVEL, _BEHIND = 1e-3, 0.02, 0.1  # [m], [rad], share of a foot's length


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("robot", help="a file, such as ./robot.yaml, or a robot of conf/robot")
    parser.add_argument("--conf", type=Path, default=Path("conf"), help="folder (default: conf)")
    parser.add_argument("--draw", type=Path, metavar="PNG", help="draw the nominal pose")


def run(arguments: argparse.Namespace) -> None:
    """Print masses, axes, ranges and torques; draw the robot if asked to."""
    picture = arguments.draw
    possible = picture is None or (picture.suffix == ".png" and picture.parent.is_dir())
    require(possible, "--draw", "a name that ends in .png in a folder", picture)
    robot = compose([f"robot={arguments.robot}"], arguments.conf).robot
    data = mujoco.MjData(build_model(robot, SimulationOptions()))  # all joints at zero
    mujoco.mj_forward(data.model, data)
    model, given = read_option(arguments.robot)
    print("\n".join(_lines(robot, data, model, given)))
    if picture is not None:
        _draw(robot, data, picture, model.outlines if model else [])
        print(f"{picture} is ready")


def _lines(
    robot: RobotConfig, data: mujoco.MjData, model: ModelFile | None, given: set[str] | None
) -> Iterator[str]:
    geometry = robot.geometry
    yield (
        f"{robot.name}: {data.model.body_subtreemass[0]:.2f} kg, base "
        f"{geometry.standing_height:.3f} m above the ground, legs of {geometry.leg_length:.3f} m, "
        f"{2 * geometry.hip[1]:.3f} m apart"
    )
    if given is not None:
        yield from _origins(robot, model, given)
    yield f"\n{'link':<12}{'mass [kg]':>10}  {'centre [m]':>24}  {'principal moments [kg m²]':>30}"
    links = {name: link for name, link in vars(robot.links).items() if link is not None}
    for name, link in links.items():
        place = " ".join(f"{value:7.4f}" for value in link.com)
        moments = " ".join(f"{value:9.3g}" for value in np.linalg.eigvalsh(link.tensor))
        yield f"{name:<12}{link.mass:10.3f}  {place:>24}  {moments:>30}"
    if geometry.knee is not None:
        knee, sense = robot.joints["slide"], np.sign(geometry.bend)
        ends = np.rad2deg(sense * (np.array([knee.lower, knee.upper]) + geometry.bend))
        ends = np.round(ends) + 0.0
        yield (
            f"\nslide is the knee: it points {'forward' if sense > 0 else 'backward'}, is bent by "
            f"{abs(np.rad2deg(geometry.bend)):.0f}° at zero, by {ends.min():.0f}° to "
            f"{ends.max():.0f}° at its ends"
        )
    head = f"\n{'joint':<12}{'range [rad, m]':>18}{'damping':>10}{'armature':>10}"
    formulas = {} if model is None else model.formulas
    yield head + "  left and right by the model's joints" * bool(formulas)
    for name, joint in robot.joints.items():
        bounds = f"{joint.lower:.3f} to {joint.upper:.3f}"
        row = f"{name:<12}{bounds:>18}{joint.damping:10.4g}{joint.armature:10.4g}"
        yield f"{row}  {formulas.get(name, '')}".rstrip()
    head = f"\n{'motor':<12}{'limit':>12}{'on one leg':>12}{'share':>8}"
    yield f"{head}{'speed':>8}{'kp':>9}{'kd':>9}{'rotor':>10}"
    motors = Transmission.of(robot)
    needed = motors.torques(all_joints(_standing_efforts(robot)[None]))[0]
    shares = np.abs(needed) / motors.torque
    rows = zip(robot.leg_motors, motors.torque, needed, shares, strict=False)  # of the left leg
    for name, limit, torque, share in rows:
        unit = "N" if name == "slide" and geometry.knee is None else "N m"
        row = f"{name:<12}{f'{limit:.1f} {unit}':>12}{f'{torque:.1f} {unit}':>12}{share:8.0%}"
        drive, gains = robot.drives[name], robot.gains[name]
        yield f"{row}{drive.speed:8.3g}{gains.kp:9.4g}{gains.kd:9.4g}{drive.inertia:10.3g}"
    yield from _remarks(robot, data, shares[: len(robot.leg_motors)], model)


def _origins(robot: RobotConfig, model: ModelFile | None, given: set[str]) -> Iterator[str]:
    """Lines about the model file, and the values that the robot file inherits."""
    if model is not None:
        difference, part = model.differs
        yield f"left and right differ by {difference:.1%} ({part})"
        if abs(model.lateral) > _SEEN:
            yield f"the base's centre at y = {model.lateral:.4f} m counts as 0"
        if model.pose:
            angles = (f"{name}: {angle:.4f}" for name, angle in model.pose.items())
            yield f"solved pose: {{{', '.join(angles)}}}"
        if model.foot_rotation > _LEVEL and not model.foot:
            angle = np.rad2deg(model.foot_rotation)
            yield (
                f"remark: the pose turns the feet by {angle:.0f}° from the model's zero. If they "
                "are level there, the sum of hip, knee and ankle in roles.pose is wrong"
            )
        held = (f"{name} and beyond with {mass:.2f} kg" for name, mass in model.held.items())
        yield f"held: {', '.join(held) or 'nothing'}"
        for source in dict.fromkeys(model.motors.values()):
            keys = ", ".join(key for key, own in model.motors.items() if own == source)
            what = f"guessed, {GUESS}" if source == "rule" else f"from the model's {source}"
            yield f"{what}: {keys}"
        yield from _foot(robot.geometry, model.foot)
        yield from (f"remark: {text}" for text in model.remarks)
    paths = [item.path for item in parameters(robot)]
    rest = [path for path in paths if not any(f"{path}.".startswith(f"{k}.") for k in given)]
    yield f"from the robot that it builds on: {', '.join(rest) or 'nothing'}"


def _foot(geometry: Geometry, foot: dict[str, float]) -> Iterator[str]:
    """Lines about the model's sole, and where the configured foot differs from it."""
    if not foot:
        return
    places = ", ".join(f"{name} {value:.3f}" for name, value in foot.items())
    yield f"foot: in the model {places} m"
    sole = geometry.sole
    for name in sorted(foot.keys() - ({"width"} if sole is None else ())):
        part = geometry if sole is None or name != "width" else sole
        value = geometry.hip[1] if name == "y" else getattr(part, name)
        if abs(value - foot[name]) > APART:
            what = "foot line" if sole is None else "sole"
            yield f"remark: {name} of the {what} is {value:.3f} m, of the model {foot[name]:.3f}"


def _remarks(
    robot: RobotConfig, data: mujoco.MjData, shares: np.ndarray, model: ModelFile | None
) -> Iterator[str]:
    """Lines about values that are valid but probably wrong."""
    geometry = robot.geometry
    if robot.links.tube.com[2] < -geometry.leg_length - geometry.ankle_height:
        yield "remark: the tube's centre of mass is below the sole"
    x, ankle = data.subtree_com[0][0], data.joint("left_ankle").xanchor[0]
    if not -geometry.heel < x - ankle < geometry.toe:
        yield f"remark: the centre of mass is not above the feet, x = {x:.3f} m"
    ahead = robot.links.foot.com[0]
    if model is not None and "toe" in model.foot:
        ahead = (model.foot["toe"] - model.foot["heel"]) / 2
    if ahead < -_BEHIND * (geometry.toe + geometry.heel):
        yield (
            "remark: the feet are behind the ankles. If the base looks along −x, left and right "
            "are swapped and roles.forward is -x"
        )
    if max(geometry.toe + geometry.heel, geometry.foot_radius) > geometry.leg_length:
        yield "remark: a foot is longer than the leg; all lengths are in m"
    if shares.max() > 1.0:
        name = robot.leg_motors[int(shares.argmax())]
        yield f"remark: {name} cannot hold the robot on one leg"
    for name, joint in robot.joints.items():
        if joint.armature > 0.0 and name in robot.drives and robot.drives[name].inertia > 0.0:
            yield f"remark: joints.{name}.armature and drives.{name}.inertia add up"


def _standing_efforts(robot: RobotConfig) -> np.ndarray:
    """Joint efforts (10,) that hold the nominal pose on the left foot, which does not rotate."""
    from slider.gait.rooted import NUM, RootedRobot

    still = np.zeros(NUM)
    return RootedRobot(robot).dynamics(still, still)[1].full().ravel()[1:]


def _draw(robot: RobotConfig, data: mujoco.MjData, path: Path, outlines: list[Any]) -> None:
    """Draw the nominal pose from right and front, with the left leg's axes and the model's feet."""
    from slider.reports.figures.style import DARK, LIGHT, MIDDLE, new_figure, style

    marked = (*robot.geometry.axes.order, "ankle")
    named = {name: name for name in robot.geometry.axes.order}
    named |= {} if robot.geometry.knee is None else {"slide": "knee"}
    named |= {name: name for name in ("ankle", "ankle_roll") if name in robot.joints}
    base, sole = data.body("base").xpos, -robot.geometry.ankle_height
    foot_style = {"color": MIDDLE, "alpha": 0.25, "linewidth": 0}
    half = 0.0 if robot.geometry.sole is None else robot.geometry.sole.width / 2
    foot = np.array([[-robot.geometry.heel, -half, sole], [robot.geometry.toe, half, sole]])
    with style():
        figure = new_figure(4.5)
        panels = figure.subplots(1, 2, sharey=True)
        for across, (panel, title) in enumerate(zip(panels, ("right", "front"), strict=True)):
            for side, colour in (("right", LIGHT), ("left", DARK)):
                axes = {name: data.joint(f"{side}_{name}").xanchor for name in robot.joints}
                chain, top = [base, *(axes[name] for name in marked)], [axes["hip_pitch"]]
                if robot.geometry.knee is None:
                    top.append(axes.get("upper_foot", axes["hip_pitch"]))
                else:
                    chain.insert(-1, axes["slide"])
                    panel.plot(*axes["slide"][[across, 2]], "o", color=MIDDLE, markersize=4)
                for line in np.array(chain), np.array(top), axes["ankle"] + foot:
                    panel.plot(line[:, across], line[:, 2], color=colour, linewidth=2)
                for outline in outlines[across : across + 1]:
                    mirror = [-1.0 if across and side == "right" else 1.0, 1.0]
                    panel.fill(*(base[[across, 2]] + mirror * np.array(outline)).T, **foot_style)
            panel.plot(base[across], base[2], "s", color=DARK, markersize=9)
            panel.axhline(0.0, color=MIDDLE, linewidth=0.8)
            for k, (name, label) in enumerate(named.items()):
                place = axes[name][[across, 2]]
                panel.plot(*place, "o", color=MIDDLE, markersize=4)
                arrow = {"arrowstyle": "-", "color": LIGHT}
                text = {"textcoords": "axes fraction", "ha": "right", "arrowprops": arrow}
                panel.annotate(label, place, (0.98, 0.8 - 0.08 * k), **text)
            panel.set(aspect="equal", title=f"from the {title}", xlabel="xy"[across] + " [m]")
            top = max(base[2], *(axes[name][2] for name in marked))
            panel.set(xlim=(-top, top), ylim=(-0.1 * top, 1.2 * top))
        panels[0].set_ylabel("z [m]")
        figure.savefig(path)
