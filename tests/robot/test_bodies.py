"""Masses and inertias of both legs; their dynamics are compared in ``tests/numerics``."""

import numpy as np
import pytest

from slider.robot.bodies import knee_bodies, own_bodies, total_mass
from tests.gait.gaits import config

BODIES = knee_bodies(config().robot), own_bodies(config().robot)
LINKS = ("yaw", "roll", "pitch", "tube", "foot", "upper_foot")


def test_both_models_weigh_the_same():
    links = config().robot.links
    total = links.base.mass + 2 * sum(getattr(links, name).mass for name in LINKS)
    for bodies in BODIES:
        assert total_mass(bodies) == pytest.approx(total, abs=1e-12)
    assert 12.0 <= total <= 13.0


def test_inertias_are_those_of_real_bodies():
    for body in (body for bodies in BODIES for body in bodies.values()):
        moments = np.linalg.eigvalsh(body.inertia)
        assert (moments > 0).all()
        assert (2 * moments <= moments.sum() + 1e-12).all()
