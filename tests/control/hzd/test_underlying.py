"""Actions on top of the controller: zero is the controller alone, whoever else is reset."""

from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest
import torch

from slider.commands.policy import summary_lines
from slider.config.convert import to_dict
from slider.config.hzd import enforced_section
from slider.control.export.folder import write_files
from slider.control.export.layout import describe
from slider.control.hzd.controller import HzdController
from slider.control.hzd.underlying import UnderlyingHzd, underlying_of
from slider.control.network import PolicyNetwork
from slider.control.policy import PolicyController
from slider.control.policy_file import Policy, load_policy, save_policy
from slider.control.whole_body.memory import LEFT, RIGHT, SWAY, WALK
from slider.core.errors import UserError
from slider.core.job import Job
from slider.env.disturbance.draws import Disturbance
from slider.env.interface import AgentInterface
from slider.env.physics import BatchedPhysics
from slider.env.rollout import roll_out
from slider.env.starts import at_rest
from slider.env.task import Task, task_of
from slider.env.underlying import NOBODY, build_physics
from slider.env.vec_env import WalkingEnv
from slider.evaluation import residual, stage
from slider.library.reader import STORE
from slider.play.motion import simulate_policy
from tests.env.synthetic import config, joint_efforts, motor_angles, robot_config
from tests.hzd.sample import folder
from tests.hzd.sample import placement_folder as placement

COUNT = 4
TICK = 0.005  # [s]
WHOLE = config("experiment=test", "env.action.offset=hzd")
COMMANDS = np.array([[0.2, 0.0, 0.0], [0.6, 0.1, 0.0], [0.4, 0.0, 0.1], [0.0, 0.0, 0.0]])
STEPS = 100
CHANGING = np.stack([COMMANDS] * (STEPS // 2) + [COMMANDS[::-1]] * (STEPS // 2))


@cache
def underlying() -> UnderlyingHzd:
    control = to_dict(WHOLE.control["hzd"])
    section = {"control": control, "hzd": enforced_section(WHOLE.hzd)}
    return UnderlyingHzd.of(section, {"library": [folder()], "foot_placement": [placement()]})


def make_agent(count: int = COUNT) -> AgentInterface:
    return AgentInterface(WHOLE.robot, WHOLE.env, count, None, None, underlying())


def plain_controller() -> HzdController:
    return underlying().controller(WHOLE.robot, TICK)


def starts(count: int = COUNT) -> tuple[np.ndarray, np.ndarray]:
    return at_rest(robot_config(), WHOLE.evaluation.start, np.random.default_rng(3), count)


def torques(controller, disturbance: str) -> tuple[np.ndarray, np.ndarray]:
    """Inputs of the plant at every tick (T, N, 12), and who is alive at the end."""
    config_ = config(f"evaluation={disturbance}").evaluation.disturbance
    disturbed = Disturbance(config_, (5,))
    physics = build_physics(WHOLE.robot, WHOLE.env.physics, COUNT, 1, disturbed, underlying())
    seen, step = [], physics.step

    def spy(inputs: np.ndarray) -> None:
        seen.append(inputs.copy())
        step(inputs)

    physics.step = spy  # type: ignore[method-assign]
    recording = roll_out(controller, physics, WHOLE.env, starts(), CHANGING, STEPS * 0.02)
    return np.stack(seen), recording.survived


@pytest.mark.parametrize("disturbance", ["development", "robust"])
def test_a_zero_action_is_the_controller_alone_tick_by_tick(disturbance):
    network = lambda observations: torch.zeros(len(observations), 12)  # noqa: E731
    residual_, _ = torques(PolicyController(network, make_agent()), disturbance)
    alone, survived = torques(plain_controller(), disturbance)
    assert len(alone) == 4 * STEPS
    assert survived.all() or disturbance == "robust"
    np.testing.assert_array_equal(residual_, alone)


def test_an_action_adds_what_the_position_loops_would():
    action = np.random.default_rng(0).uniform(-1, 1, (COUNT, 12))
    agent = make_agent()
    assert (agent.ticks, agent.clock is not None) == (4, True)
    scale = [WHOLE.env.action.scale[name] for name in WHOLE.robot.joints] * 2
    gain = [WHOLE.robot.gains[name].kp for name in ("hip_yaw", "hip_roll", "hip_pitch")]
    stiffness = np.array(([*gain, *[WHOLE.robot.gains["capstan"].kp] * 2]) * 2)
    expected = joint_efforts(stiffness * motor_angles(np.array(scale) * action))
    physics = BatchedPhysics(WHOLE.robot, WHOLE.env.physics, COUNT)
    physics.reset(np.arange(COUNT), *starts())
    agent.set_velocity_command(np.arange(COUNT), COMMANDS)
    agent.reset(np.arange(COUNT), physics.read())
    right = ~agent.clock.left_stance  # type: ignore[union-attr]
    found = agent.act(action.copy())
    np.testing.assert_allclose(found[~right], expected[~right], atol=1e-12)
    assert not np.allclose(found[right], expected[right]), "reflected where the right foot is next"


def make_env(count: int = COUNT, *overrides: str) -> WalkingEnv:
    whole = config(
        *("experiment=test", "env.action.offset=hzd", "train/walking/disturbance=none"),
        *(f"train.walking.robots={count}", *overrides),
    )
    task: Task = task_of(
        whole.robot, whole.env, whole.train.walking, folder() / STORE, True, underlying()
    )
    return WalkingEnv(task)


def test_the_environment_steps_like_the_rollout():
    """With an action that is not zero: held for a control period, reflected by the same foot."""
    env, everyone = make_env(), np.arange(COUNT)
    env._commands.changing = lambda *_: np.zeros(0, dtype=int)  # type: ignore[method-assign]
    env.agent.set_velocity_command(everyone, COMMANDS)
    env.physics.reset(everyone, *starts())
    env._measured = env.physics.read()
    env.agent.reset(everyone, env._measured)
    action = torch.full((COUNT, 12), 0.02)
    for _ in range(80):
        env.step(action)
    physics = build_physics(WHOLE.robot, WHOLE.env.physics, COUNT, 1, None, underlying())
    controller = PolicyController(lambda _: action, make_agent())
    roll_out(controller, physics, WHOLE.env, starts(), COMMANDS, 1.6)
    np.testing.assert_allclose(env.physics.qpos, physics.qpos, rtol=0, atol=1e-12)
    assert (env.agent.controller.memory.mode == WALK).any()  # type: ignore[union-attr]


def rows(batch, index: np.ndarray) -> dict[str, np.ndarray]:
    """Arrays of a memory, by name, of some robots."""
    found = {}
    for item in fields(batch):
        value = getattr(batch, item.name)
        if isinstance(value, np.ndarray):
            found[item.name] = value[index].copy()
        elif is_dataclass(value):
            found |= {f"{item.name}.{n}": v for n, v in rows(value, index).items()}
    return found


def test_a_reset_of_some_robots_leaves_the_others_alone():
    controller = plain_controller()
    physics = build_physics(WHOLE.robot, WHOLE.env.physics, COUNT, 1, None, underlying())
    physics.reset(np.arange(COUNT), *starts())
    controller.reset(physics.read(), COMMANDS.copy())
    for _ in range(300):
        physics.step(controller.control(physics.read()))
    assert (controller.memory.mode[:3] == WALK).all()
    again, others = np.array([0, 2]), np.array([1, 3])
    walk = controller._steps._walk
    before = rows(controller.memory, others) | rows(walk, others)
    qpos, qvel = starts()
    physics.reset(again, qpos[again], qvel[again])
    state = physics.read()
    yaw = state.yaw[again]
    controller.restart(again, state, COMMANDS[again], yaw, np.array([NOBODY, RIGHT]))
    after = rows(controller.memory, others) | rows(walk, others)
    assert before.keys() == after.keys()
    for name, values in before.items():
        np.testing.assert_array_equal(values, after[name], err_msg=name)
    assert controller.memory.mode[again].tolist() == [SWAY, WALK]
    fresh = plain_controller()
    fresh.allocate(COUNT)
    everyone, nobody = np.arange(COUNT), np.full(COUNT, NOBODY)
    nobody[2] = RIGHT
    fresh.restart(everyone, state, COMMANDS, state.yaw, nobody)
    np.testing.assert_allclose(
        controller.control(state)[again], fresh.control(state)[again], rtol=0, atol=1e-9
    )


def test_the_clock_is_that_of_the_steps():
    """Halted while it sways; then the foot in stance by the clock carries the robot."""
    env, everyone = make_env(), np.arange(COUNT)
    env._commands.changing = lambda *_: np.zeros(0, dtype=int)  # type: ignore[method-assign]
    env.agent.set_velocity_command(everyone, np.tile(COMMANDS[0], (COUNT, 1)))
    env.physics.reset(everyone, *starts())
    env._measured = env.physics.read()
    env.agent.reset(everyone, env._measured)
    clock = env.agent.clock
    assert clock is not None
    assert clock.halted.all()
    loaded = []
    for _ in range(150):
        env.step(torch.zeros(COUNT, 12))
        assert ((clock.phase >= 0) & (clock.phase < 1)).all()
        progress = (2 * clock.phase) % 1
        middle = ~clock.halted & (progress > 0.2) & (progress < 0.8)
        forces = env.physics.read().foot_forces
        stance = np.where(clock.left_stance, LEFT, RIGHT)
        loaded += (forces[everyone, stance] > forces[everyone, 1 - stance])[middle].tolist()
    assert len(loaded) > 100
    assert np.mean(loaded) > 0.98


def test_starts_on_the_gait_begin_with_a_step_that_it_makes():
    env = make_env(32, "train.walking.reset.reference_fraction=1.0")
    memory = env.agent.controller.memory  # type: ignore[union-attr]
    assert (memory.mode == WALK).all()
    assert set(memory.stance) == {LEFT, RIGHT}
    speed = env.physics.read().heading_velocity[:, 0]
    np.testing.assert_allclose(speed, np.clip(env.agent.command[:, 0], 0.2, 0.6), atol=0.3)
    for _ in range(40):
        _, _, done, _ = env.step(torch.zeros(32, 12))
        assert not done.any()


@pytest.fixture
def policy() -> Policy:
    layout = make_agent(1).observer.layout
    torch.manual_seed(0)
    network = PolicyNetwork(sum(layout.values()), 12, (16,), "elu").eval()
    env, robot = WHOLE.env, WHOLE.robot
    plain = underlying().plain()
    return Policy(network, (16,), "elu", layout, None, robot, env, {"seed": 1}, None, plain)


def test_the_policy_file_carries_the_controller(policy, tmp_path):
    save_policy(policy, tmp_path / "policy.pt")
    back = underlying_of(load_policy(tmp_path / "policy.pt").underlying)
    assert back is not None
    own = underlying()
    assert (back.config, back.enforced.constraints) == (own.config, own.enforced.constraints)
    assert back.enforced.reach == own.enforced.reach
    command, stance = COMMANDS[:2], np.array([LEFT, RIGHT])
    found, expected = (one.enforced.gaits.at(command, stance) for one in (back, own))
    for name in ("duration", "coefficients", "gains", "orbit", "placement"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    motion = simulate_policy(policy, WHOLE.robot, WHOLE.env, WHOLE.evaluation.start, 1)
    frame = motion.start(COMMANDS[0])
    for _ in range(20):
        frame = motion.step(COMMANDS[0])
    assert not frame.failed


def test_it_is_evaluated_from_its_file_alone_and_only_where_it_can_be(policy, tmp_path):
    for name in ("walking", "out", "refused", "exported"):
        (tmp_path / name).mkdir()
    save_policy(policy, tmp_path / "walking" / "policy.pt")
    section = {
        "robot": to_dict(WHOLE.robot),
        "env": to_dict(WHOLE.env),
        "evaluation": to_dict(replace(WHOLE.evaluation, trials=1, robots=2)),
        "controller": "policy",
        "command": 0.2,
    }
    inputs = {"walking": [tmp_path / "walking"]}
    summary = residual.run(section, inputs, tmp_path / "out", Job(tmp_path))
    assert summary["success_rate"] == 1.0
    with pytest.raises(UserError, match=r"env\.action\.offset=hzd: expected that controller"):
        stage.run(section, inputs, tmp_path / "refused", Job(tmp_path))
    layout = describe(load_policy(tmp_path / "walking" / "policy.pt"), {})
    assert any("the controller hzd" in line for line in summary_lines(layout))
    with pytest.raises(UserError, match="found one on top of the controller hzd"):
        write_files(tmp_path / "walking" / "policy.pt", {}, tmp_path / "exported")
