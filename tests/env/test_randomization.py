"""Each robot is another one, by as much as the configuration says, and the physics feels it."""

import numpy as np
import pytest

from slider.robot import names
from slider.robot.mjcf import Actuation
from tests.env.synthetic import TRANSMISSION, disturbed_physics, momentum, stand

COUNT = 20
GRAVITY = 9.81


def test_mass_is_weight_on_the_feet():
    """The mean force carries the weight and changes the vertical momentum."""
    physics = disturbed_physics(COUNT, "mass={lower: 0.9, upper: 1.1}", substeps=1)
    stand(physics)
    forces = []
    for _ in range(60):
        physics.step(np.zeros((COUNT, names.NUM_JOINTS)))
        forces.append(physics.read().foot_forces.sum(axis=1))
    weight = np.mean(forces, axis=0) - momentum(physics)[:, 2] / 0.3
    nominal = physics.model.body_mass.sum()
    share = physics.masses / nominal
    assert 0.9 <= share.min() < 0.93 < 1.07 < share.max() <= 1.1
    np.testing.assert_allclose(weight, physics.masses * GRAVITY, rtol=0.02)
    inertia = np.array([model.body_inertia for model in physics.models])
    np.testing.assert_allclose(inertia, share[:, None, None] * physics.model.body_inertia)


def test_payload_and_centre_of_mass_are_those_of_the_base():
    settings = "payload={lower: 1.0, upper: 3.0}", "centre_of_mass=0.02"
    physics = stand(disturbed_physics(COUNT, *settings))
    nominal = physics.model
    masses, places = (
        np.array([getattr(model, name) for model in physics.models]) - getattr(nominal, name)
        for name in ("body_mass", "body_ipos")
    )
    base = nominal.body(names.BASE).id
    assert 1.0 <= masses[:, base].min() < 1.3 < 2.7 < masses[:, base].max() <= 3.0
    assert 0.018 < np.abs(places[:, base]).max() <= 0.02
    for changes in (masses, places):
        assert not np.delete(changes, base, axis=1).any()
    np.testing.assert_allclose(physics.masses, nominal.body_mass.sum() + masses[:, base])


def test_friction_bounds_the_force_along_the_ground():
    """Feet that slide are braked by μ times what they carry."""
    physics = disturbed_physics(COUNT, "friction={lower: 0.2, upper: 0.6}")
    stand(physics, 0.2)
    physics.qvel[:, 0] += 2.0
    friction = np.array([m.geom(names.foot("left")).friction[0] for m in physics.models])
    assert 0.2 <= friction.min() < 0.25 < 0.5 < friction.max() <= 0.6
    start = momentum(physics)
    physics.step(np.zeros((COUNT, names.NUM_JOINTS)))
    force = (momentum(physics) - start) / physics.period
    carried = force[:, 2] + physics.masses * GRAVITY
    assert (carried > 0.5 * physics.masses * GRAVITY).all()
    np.testing.assert_allclose(-force[:, 0], friction * carried, rtol=0.01)


@pytest.mark.parametrize("actuation", ["position", "torque"])
def test_motor_gain_scales_the_achieved_torque(actuation: Actuation):
    """Also where the effort limit binds: the limit is one of current."""
    gain = "motor_gain={lower: 0.9, upper: 1.1}"
    varied, exact = (
        disturbed_physics(3, *settings, actuation=actuation, substeps=1)
        for settings in ((gain,), ())
    )
    scale = 0.02 if actuation == "position" else 5.0
    inputs = scale * np.random.default_rng(0).uniform(0.3, 1.0, (3, names.NUM_JOINTS))
    inputs[2] *= 1000.0
    torques = []
    for physics in (varied, exact):
        stand(physics)
        physics.step(inputs)  # torques of the start, before anything moves
        torques.append(physics.read().motor_torques)
    ratio = torques[0] / torques[1]
    limits = np.array([model.actuator_forcerange[:, 1] for model in varied.models])
    np.testing.assert_allclose(ratio, limits / exact.model.actuator_forcerange[:, 1], rtol=1e-6)
    assert 0.9 <= ratio.min() < 0.93 < 1.07 < ratio.max() <= 1.1
    np.testing.assert_allclose(np.abs(torques[1][2]), TRANSMISSION.torque, rtol=1e-9)
