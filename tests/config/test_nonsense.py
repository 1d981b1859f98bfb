"""Every value of the configuration refuses nonsense of its kind in one line that names it."""

import math
from collections.abc import Iterator
from fnmatch import fnmatch
from typing import Any

import pytest
import yaml

from slider.config.convert import from_dict, to_dict
from slider.config.reference import OPTIONAL
from slider.config.schema import Config
from slider.config.validation import validate
from slider.core.errors import UserError
from slider.env.terms import checked
from tests.config.composed import composed

Place = tuple[str | int, ...]

NUMBERS = (-1, 0, math.nan, math.inf, -math.inf, 1e30, 10**30, "nonsense", True, [], None)
TRUTHS = (3, "nonsense", [], None)
TEXTS = ("", "nonsense", 3, True, [], None)
LISTS = ([], {}, 3, "nonsense", None)
GROUPS = ([], 3, "nonsense", None)

# Leaves, as patterns, that take a value which is nonsense elsewhere, and why.
ALLOWED: dict[Any, tuple[str, ...]] = {
    -1: (
        "*.vx* *.vy* *.yaw_rate *.yaw_rate.lower *.yaw_rate[[]*",  # backward, right
        "*speeds[[]* speeds.table1[[]*",  # backward
        "*.com[[]* *.axes.* *.products[[]* *.lower *.joints.*.upper",  # of both signs
        "*.reward.terms.*.weight *.floor *.on_fall",  # penalties
    ),
    0: (
        "*.vx* *.vy* *.yaw_rate* *speeds[[]* speeds.table1[[]*",  # to stand still
        "*.com[[]* *.axes.* *.products[[]* *.joints.*.lower *.joints.*.upper",
        "*.start.* *.sensing.* *.sensors.* *.delay.* *.centre_of_mass",  # nominal
        "*.push.* *.payload.* *.terrain.*",  # as above
        "*.damping *.armature *.drives.*.inertia",  # none of its own
        "*.kp *.kd *.whole_body.*.weight[[]* *_weight *_coefficient",  # switched off
        "*.reward.terms.*.weight *.reward.terms.*.params.* *.floor *.on_fall",  # as above
        "*.action.scale.* *.termination.terms.*",  # a passive joint; no contact at all
        "*.warm_up *.ramp *.segments[[]0].time *.tracking_*",  # at once, exact
        "gauge.distance",  # survival alone
        "*.iterations *.period *fraction *.lam *.actor_ema",  # never, none
        "*.estimator.lifted *.estimator.force_filter",  # as above
        "*.velocity_filter *.step_time *.halt.* *.acceleration",  # documented: off
        "gait.touchdown.* gait.posture.* gait.contact.min_vertical",  # tight, or no limit
        "*.planner.width_min *.velocity.integral* *.swing.* *.entry.*",  # as above
        "*.step.time_change *.step.time_per_speed* *.step.early *.step.late *.observer.delay",
        "*.hzd.weights.* *.hzd.ahead* *.hzd.lock *.hzd.hip_start.* *.hzd.descent",  # switched off
        "verification.bounds.*",  # exact; no limit
        "hzd.placement.lower hzd.feedback.reach",  # as above
        "gait.decoupling_min",  # none is refused
        "*.seed *.sampler_seed *.seeds[[]* *seeds.*.first seeds.selection",  # counted from
        "*.quality",
    ),
    "": (),
    "nonsense": (
        "*.name *.label tracking.experiment",  # names
        "*.overrides[[]*",  # read when the variant is composed
        "report.sections[[]* study.*.metrics[[]*",  # known to whoever lays out the jobs
    ),
    "[]": (
        "*.extra *.overrides study.*.parameters",  # nothing beside the rest; all
        "report.*speeds protocols.*.speeds",  # nothing drawn; a profile instead
    ),
    None: (
        "finetuning control.*.observer *.friction",  # none, or the robot's
        "robot.capstan robot.virtual_knee robot.provenance.*",  # others are asked for; no tag
        "protocols.*.profile verification.bounds.*",  # constant velocities; reported only
        "study.*.scaling study.*.starts",  # no further variants; own guesses
        "study.*.training study.sensitivity.evaluation",  # the pipeline's policy; gaits alone
    ),
}
MISFITS = [
    ("gait.grid.vx.step=1.0e-9", "gait.grid: expected at most"),
    ("gait.grid.vx=0.33", "grid.vx: expected keys and values or a list, found 0.33"),
    ("train.walking.velocities.vx=[0.3]", "vx: expected keys and values, found [0.3]"),
    ("train.walking.selection.warm_up=6", "selection.warm_up: expected a time in [0, 5.98] s"),
    ("train.standing.network.activation=tanh", "network.activation: expected elu"),
    ("protocols.joystick.profile.warm_up=2.995", "expected a control period longer than ramp"),
    ("train.walking.episode_length=0.001", "episode_length: expected a value ≥ 0.02"),
    ("train.standing.reset.reference_fraction=0.5", "expected 0 (pre-training has no guide"),
    ("control.mpc_wbc_tuned.substeps=2", "(4) for a control rate of at least 200 Hz, found"),
    ("control.mpc_wbc_observer.observer.delay=0.012", "delay: expected a multiple of 0.005"),
    ("control.hzd.family=x", "control.hzd.family: expected 'mpc' or 'hzd', found \"x\""),
    ("control.hzd.family=mpc", "control.hzd.step.time_min: expected a value, found none"),
    ("evaluation.disturbance.delay.upper=0.012", "upper: expected a multiple of 0.005"),
    ("train.walking.disturbance.push.interval=0.13", "push.interval: expected a multiple of"),
    ("evaluation.disturbance.terrain.curriculum=true", "expected false outside trainings"),
    ("gauge.duration=3.0", "gauge.duration: expected at least 3.1 s, with a push, found 3.0"),
    ("gauge.duration=10.01", "gauge.duration: expected a multiple of 0.02, found 10.01"),
    ("evaluation.speeds=[0.2,0.2000000001]", "evaluation.speeds: expected each once, found"),
    ("evaluation.controllers=[prayer]", "evaluation.controllers: expected one of policy,"),
    ("protocols.sweep.speeds=[]", "protocols.sweep.speeds: expected at least one speed"),
    ("protocols.joystick.speeds=[1.0]", "protocols.joystick.speeds: expected none with a"),
    ("protocols.joystick.duration=44.0", "segments[11]: expected a control period longer"),
    ("protocols.heldout.profile.rows=segments", "expected one case where rows are its"),
    ("robot.geometry.axes.hip_yaw=[0.0]", "axes.hip_yaw[1]: expected a value, found none"),
    ("gait.step_time={lower: .4, upper: .3}", "lower ≤ upper"),
    ("gauge.axes=[mud]", "gauge.axes: expected one of slope_up, "),
    ("gauge.controllers=[mine]", "gauge.controllers: expected one of policy, "),
    ("gauge.policies={hzd: here}", "gauge.policies: expected a name that no controller has"),
    ("gauge.seed=5", "gauge.seed: expected seeds within"),
    (f"evaluation.seed={2**63 - 1}", "within 20260 to 21259 or 1000 to 1999, found 92233720368"),
    ("tuning.seed=1999", "tuning.seed: expected seeds within"),  # and the finalists'
    ("gauge.scales.payload=[1,2,3,4,5,6,7,8,9,9.0]", "scales.payload: expected rising values, fou"),
    ("gauge.scales.delay=[.01,.02,.03,.04,.05,.06,.07,.08,.09,.099]", "[9]: expected a multiple"),
    ("seeds.final.last=1500", "seeds.final: expected first ≤ last, found"),
    ("seeds.final={first: 1500, last: 2500}", "expected no seed of seeds.development (1000 "),
    ("evaluation.seed=1995", "within 20260 to 21259 or 1000 to 1999, found 1995 to"),
    ("study.ablation.evaluation.seed=20260", "evaluation.seed: expected seeds within 1000 to 1999"),
    ("finetuning.selection.seed=3", "finetuning.selection.seed: expected seeds"),
    ("train.walking.seed=20262", "train.walking.seed: expected none of seeds.final (20260 "),
    ("study.ablation.training.seeds=[1,21259]", "seeds[1]: expected none of seeds.final"),
    ("gait.posture.knee_max=0.01", 'found {"knee_min": 0.1, "knee_max": 0.01}'),
]
PATTERNS = {wrong: " ".join(lines).split() for wrong, lines in ALLOWED.items()}


@pytest.fixture(scope="module")
def config() -> Config:
    return composed(*OPTIONAL)


@pytest.fixture(scope="module")
def plain(config) -> dict[str, Any]:
    return to_dict(config)


def places(node: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Places below a node with what is there; of a long list the first and the last item."""
    items = enumerate(node) if isinstance(node, (list, tuple)) else ()
    for name, value in node.items() if isinstance(node, dict) else items:
        if isinstance(name, str) or name in (0, len(node) - 1):
            yield (*place, name), value
            yield from places(value, (*place, name))


def nonsense(value: Any) -> tuple[Any, ...]:
    if isinstance(value, bool):
        return TRUTHS
    if isinstance(value, (int, float)):
        return NUMBERS
    if isinstance(value, str):
        return TEXTS
    if isinstance(value, dict):
        return GROUPS
    return LISTS if isinstance(value, (list, tuple)) else NUMBERS[4:-1]


def key(place: Place) -> str:
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in place).removeprefix(".")


def allowed(place: Place, wrong: Any) -> bool:
    if isinstance(wrong, (bool, dict)):
        return False
    name = "[]" if isinstance(wrong, list) else wrong
    return any(fnmatch(key(place), pattern) for pattern in PATTERNS.get(name, ()))


def replaced(node: Any, place: Place, value: Any) -> Any:
    """A copy of nested values with another one at a place."""
    if not place:
        return value
    copy = dict(node) if isinstance(node, dict) else list(node)
    copy[place[0]] = replaced(copy[place[0]], place[1:], value)
    return copy


def complaint(config: Config, plain: dict[str, Any], place: Place, wrong: Any) -> str:
    """What the group of a place says of a wrong value, or else the whole configuration."""
    group = str(place[0])
    try:
        own = getattr(config, group)
        values = replaced(plain[group], place[1:], wrong)
        if not isinstance(own, dict) and values is not None:
            from_dict(type(own), values, group)  # quicker than the whole
        whole = from_dict(Config, plain | {group: values})
        validate(whole)
        checked(whole)
    except UserError as error:
        return str(error)
    return "nothing"


def is_clear(place: Place, text: str) -> bool:
    """One line about the key, or about the group around it that does not fit together."""
    found, separator, _ = text.partition(": expected ")
    names = [index for index, part in enumerate(place) if isinstance(part, str)]
    around = key(place[: names[-2] + 1 if len(names) > 1 else 1])  # of an item, that of its list
    lacking = found.startswith((f"{key(place)}[", f"{key(place)}."))  # an item, or a value
    own = found == key(place) or lacking
    names = own or (found.startswith(around) and key(place).startswith(found))
    return bool(separator) and "\n" not in text and names


# Of groups whose members have one schema, those that differ in what is there.
DIFFERENT = {
    "control": ("mpc_wbc_observer", "hzd"),
    "protocols": ("sweep", "joystick", "heldout"),
    "study": ("seeds", "sensitivity", "gait_starts"),
}


@pytest.mark.parametrize("group", list(Config.__dataclass_fields__))
def test_nonsense_is_refused_in_one_line(group, config, plain):
    accepted = []
    members = {name: plain[group][name] for name in DIFFERENT.get(group, plain[group])}
    for place, value in places({group: members}):
        for wrong in nonsense(value):
            if allowed(place, wrong):
                continue
            text = complaint(config, plain, place, wrong)
            if not is_clear(place, text):
                accepted.append(f"{key(place)}={wrong}: {text}")
    assert accepted == []


@pytest.mark.parametrize(("change", "message"), MISFITS)
def test_values_that_do_not_fit_together_are_one_line(change, message, config, plain):
    name, _, value = change.partition("=")
    text = complaint(config, plain, tuple(name.split(".")), yaml.safe_load(value))
    assert message in text
    assert "\n" not in text


def test_every_exception_has_a_leaf(plain):
    keys = [key(place) for place, _ in places(plain)]
    for patterns in PATTERNS.values():
        for pattern in patterns:
            assert any(fnmatch(name, pattern) for name in keys), pattern
