"""Every default weight pulls the way that its term is meant to: what walks well earns more."""

import numpy as np
import pytest

from slider.config.train import TrainConfig
from slider.env.rewards import Reward, RewardView
from tests.env.synthetic import TORQUE_LIMITS, config, make_guide, make_state, make_view

SPEED, STANCE = 0.4, 120.0  # of the gait [m/s]; on the foot that carries the robot [N]
APART = [[[0.0, 0.1, 0.0], [0.0, -0.1, 0.0]]]  # feet [m]
TILT = 0.2  # [rad]
# Of a robot on its gait in left stance: what one thing that goes wrong changes.
FAULTS = {
    "forward_velocity": {"heading_velocity": [[0.9, 0.0]]},
    "forward_velocity_filtered": {"filtered_velocity": [[0.6, 0.0]]},
    "lateral_velocity_filtered": {"filtered_velocity": [[SPEED, 0.2]]},
    "yaw_rate": {"angular_velocity": [[0.0, 0.0, 0.6]]},
    "heading": {"command": [[SPEED, 0.0, 0.0, 0.3]]},
    "guide_phase": {"joint_positions": 0.2},
    "contact_schedule": {"foot_forces": [[0.0, STANCE]]},
    "upright": {"gravity": [[np.sin(TILT), 0.0, -np.cos(TILT)]]},
    "height": {"base_position": [[0.0, 0.0, 0.62]]},
    "guide_height": {"base_position": [[0.0, 0.0, 0.62]]},
    "action_rate": {"action": 1.0},
    "roll_pitch_rate": {"angular_velocity": [[4.0, -4.0, 0.0]]},
    "foot_slip": {"foot_velocities": [[[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]]]},
    "soft_landing": {"foot_velocities": [[[0.0, 0.0, 0.0], [0.0, 0.0, -1.5]]]},
    "airborne": {"foot_forces": 0.0, "phase": 0.0},  # as the feet change, where both may be down
    "feet_close": {"foot_positions": [[[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]]]},
    "effort": {"motor_torques": TORQUE_LIMITS},
}
AGENT = ("command", "filtered_velocity", "action", "phase")


def training(name: str) -> TrainConfig:
    return getattr(config().train, name)


def earned(train: TrainConfig, fell: bool = False, **changes) -> float:
    """Reward of a robot that does what it should, but for ``changes``."""
    view = {
        "command": [[SPEED, 0.0, 0.0, 0.0]],
        "filtered_velocity": [[SPEED, 0.0]],
        "expected_velocity": [[SPEED, 0.0]],
        "reference_velocity": [[SPEED, 0.0]],
        "phase": 0.2,
    }
    view |= {name: value for name, value in changes.items() if name in AGENT}
    guide, shapes = make_guide(), make_view(make_state(1))
    view = {n: np.broadcast_to(v, getattr(shapes, n).shape).copy() for n, v in view.items()}
    gait = guide.at_phase(make_view(make_state(1), **view))
    state = {
        "joint_positions": gait[:, :12],
        "base_position": gait[:, 26:29],
        "heading_velocity": [[SPEED, 0.0]],
        "foot_forces": [[STANCE, 0.0]],
        "foot_positions": APART,
    }
    state |= {name: value for name, value in changes.items() if name not in AGENT}
    seen = RewardView(make_view(make_state(1, **state), **view), guide)
    total, _ = Reward(train.reward)(seen, np.array([fell]))
    return float(total[0])


def terms(name: str) -> list[tuple[str, str]]:
    return [(name, term) for term in training(name).reward.active]


@pytest.mark.parametrize(("name", "term"), [*terms("standing"), *terms("walking")])
def test_a_fault_costs(name, term):
    """With its weight at zero or turned about it would not."""
    if term not in FAULTS:
        pytest.skip(f"FAULTS has no fault of {term}")
    train, fault = training(name), FAULTS[term]
    right = {"phase": fault["phase"]} if "phase" in fault else {}
    assert earned(train, **right) - earned(train, **fault) > 0.04


@pytest.mark.parametrize("name", ["standing", "walking"])
def test_a_fall_costs_more_than_a_step_earns(name):
    """So that no fault is worth a fall, and no robot earns by falling early."""
    train = training(name)
    assert earned(train) > 0.5
    assert earned(train) - earned(train, fell=True) > 0.5
    everything = {name: value for fault in FAULTS.values() for name, value in fault.items()}
    assert earned(train, **everything) >= 0.0, "staying up never costs"
