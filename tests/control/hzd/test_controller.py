"""Gaits walk without learning: from rest and from their first sample; not without feedback."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from slider.config.control import HzdControlConfig
from slider.config.hzd import enforced_section
from slider.control.hzd.gaits import EnforcedGaits
from slider.control.hzd.steps import hzd_controller
from slider.control.model_based import build_plant
from slider.control.whole_body.controller import WalkingController
from slider.control.whole_body.memory import WALK
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.disturbance import Disturbance
from slider.env.physics import BatchedPhysics
from slider.evaluation import gait_walks
from slider.hzd.foot_placement import FootPlacement
from tests import shared
from tests.control.walking import walk
from tests.env.synthetic import config, disturbance, robot_config
from tests.hzd.sample import VELOCITIES, folder, library, placement_folder


@cache
def gaits() -> EnforcedGaits:
    return placed(FootPlacement.load(placement_folder()))


def placed(feedback: FootPlacement) -> EnforcedGaits:
    hzd = config().hzd
    return EnforcedGaits(library(), feedback, hzd, hzd.feedback.reach)


def controlled(count: int, enforced: EnforcedGaits | None = None):
    whole = config()
    control = whole.control["hzd"]
    physics = build_plant(robot_config(), whole.env.plant, control, count)
    return hzd_controller(robot_config(), control, enforced or gaits(), physics.period), physics


def integrating() -> HzdControlConfig:
    """With integral action on the velocity, which the default leaves out."""
    control = config().control["hzd"]
    return replace(control, velocity=replace(control.velocity, integral=0.35))


def test_walks_from_the_protocols_starts_at_the_commanded_velocity():
    """Up a slope that it receives, where the integral action takes 5 s."""
    text = "terrain={kinds: [slope_up], level: {lower: 4.8, upper: 4.8}}"
    ground, segment = Disturbance(disturbance(text), (1,)), (5.5, (0.2, 0.0, 0.0))
    recording, controller = walk(integrating(), segment, noise=True, drawn=ground, gaits=gaits())
    assert recording.survived.all()
    assert (controller.memory.mode == WALK).all()
    np.testing.assert_allclose(recording.velocity[-84:].mean(axis=(0, 1)), [0.2, 0.0], atol=0.03)


def walked(controller: WalkingController, physics: BatchedPhysics, steps: int) -> np.ndarray:
    job = Job(shared.new_folder())
    return gait_walks.walk(controller, physics, config().env, library(), steps, job)["walked"]


def test_gaits_walk_from_their_first_sample():
    assert walked(*controlled(len(VELOCITIES)), steps=40).tolist() == [40, 40]


def test_without_foot_placement_they_fall():
    """The roll's return map has an eigenvalue above one."""
    feedback = FootPlacement.load(placement_folder())
    blind = placed(replace(feedback, gains=np.zeros_like(feedback.gains)))
    assert walked(*controlled(len(VELOCITIES), blind), steps=40).max() < 40


def test_a_gait_of_the_library_is_that_gait():
    velocities = np.array(VELOCITIES)
    for side in range(2):
        steps = gaits().at(velocities, np.full(len(velocities), side))
        expected = library().arrays["coefficients"][:, side]
        np.testing.assert_allclose(steps.constraints.steps.coefficients, expected, atol=1e-12)
        np.testing.assert_allclose(
            steps.duration, library().arrays["step_time"][:, side], atol=1e-12
        )


def test_a_step_depends_on_no_other_robot():
    """To the bit: robots that have failed leave, and change no others."""
    velocities = np.random.default_rng(0).uniform((0.1, 0.0, 0.0), (0.7, 0.2, 0.0), (5, 3))
    stance = np.array([0, 1, 1, 0, 1])
    together = gaits().at(velocities, stance)
    for row in range(5):
        alone = gaits().at(velocities[[row]], stance[[row]])
        legs, others = alone.constraints.steps, together.constraints.steps
        for name in ("coefficients", "placement"):
            np.testing.assert_array_equal(getattr(legs, name)[0], getattr(others, name)[row])
        for name in ("duration", "gains", "orbit"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(together, name)[row])
        np.testing.assert_array_equal(alone.hip.values[0], together.hip.values[row])


def test_foot_placement_of_other_gaits_or_another_phase_is_refused():
    feedback = FootPlacement.load(placement_folder())
    with pytest.raises(UserError, match="expected the foot placement of 2 gaits"):
        placed(replace(feedback, velocities=feedback.velocities + 0.1))
    section = enforced_section(config("hzd.slowest_hip=0.1").hzd)
    with pytest.raises(UserError, match=r"expected foot placement for hzd\.slowest_hip=0\.1"):
        EnforcedGaits.load(folder(), placement_folder(), section)
