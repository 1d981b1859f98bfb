import numpy as np
import pytest

from slider.robot.bodies import Body, knee_bodies, prismatic_bodies, total_mass
from tests.gait.gaits import config

BODIES: dict[str, Body] = knee_bodies(config().robot)
LINKS = ("yaw", "roll", "pitch", "tube", "foot", "upper_foot")


def leg_points() -> dict[str, np.ndarray]:
    """Centres of mass (x, z) of thigh and shank at the nominal length; hip at the origin."""
    knee, length = config().robot.virtual_knee, config().robot.geometry.leg_length
    thigh, shank = knee.thigh_length, knee.shank_length
    along = (thigh**2 + length**2 - shank**2) / (2 * length)
    elbow = np.array([np.sqrt(thigh**2 - along**2), -along])
    unit = {"thigh": -elbow / thigh, "shank": (elbow - np.array([0.0, -length])) / shank}
    origin = {"thigh": np.zeros(2), "shank": elbow}
    return {name: origin[name] + unit[name] * BODIES[name].com[2] for name in origin}


def prismatic() -> list[tuple[float, float, float]]:
    """Mass, height below the hip and pitch inertia of what thigh and shank stand for."""
    links, geometry = config().robot.links, config().robot.geometry
    heights = {"pitch": 0.0, "tube": 0.0, "upper_foot": geometry.upper_foot_height}
    return [
        (link.mass, height + link.com[2], link.inertia[1])
        for link, height in ((getattr(links, name), heights[name]) for name in heights)
    ]


def test_both_models_weigh_the_same():
    links = config().robot.links
    total = links.base.mass + 2 * sum(getattr(links, name).mass for name in LINKS)
    for bodies in (BODIES, prismatic_bodies(config().robot)):
        assert total_mass(bodies) == pytest.approx(total, abs=1e-12)
    assert 12.0 <= total <= 13.0


def test_at_the_nominal_length_the_legs_mass_lies_at_the_same_height():
    points = leg_points()
    knee = sum(BODIES[name].mass * points[name][1] for name in points)
    slide = sum(mass * height for mass, height, _ in prismatic())
    assert knee == pytest.approx(slide, rel=1e-12)


def test_at_the_nominal_length_the_legs_inertia_about_the_hip_is_a_third_larger():
    # The virtual knee sticks out by 0.165 m, and a third of the tube lies below it.
    points = leg_points()
    knee = 0.0
    for name, point in points.items():
        body = BODIES[name]
        knee += body.inertia[1, 1] + body.mass * point @ point
    slide = sum(inertia + mass * height**2 for mass, height, inertia in prismatic())
    assert knee / slide == pytest.approx(1.33, abs=0.01)


def test_inertias_are_those_of_real_bodies():
    for body in (*BODIES.values(), *prismatic_bodies(config().robot).values()):
        moments = np.linalg.eigvalsh(body.inertia)
        assert (moments > 0).all()
        assert (2 * moments <= moments.sum() + 1e-12).all()
