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

NUMBERS = (-1, math.nan, math.inf, 1e30, "nonsense", True, [], None)
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
    "": (),
    "nonsense": (
        "*.name *.label tracking.experiment store.remote",  # names
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
    ("train.walking.selection.warm_up=6", "selection.warm_up: expected a time in [0, 5.98] s"),
    ("train.standing.network.activation=tanh", "network.activation: expected elu"),
    ("protocols.joystick.profile.warm_up=2.995", "expected a control period longer than ramp"),
    ("train.standing.reset.reference_fraction=0.5", "expected 0 (pre-training has no guide"),
    ("control.mpc_wbc_tuned.substeps=2", "(4) for a control rate of at least 200 Hz, found"),
    ("control.mpc_wbc_observer.observer.delay=0.012", "delay: expected a multiple of 0.005"),
    ("control.hzd.family=mpc", "control.hzd.step.time: expected a value, found none"),
    ("evaluation.disturbance.terrain.curriculum=true", "expected false outside trainings"),
    ("gauge.duration=3.0", "gauge.duration: expected at least 3.1 s, with a push, found 3.0"),
    ("evaluation.speeds=[0.2,0.2000000001]", "evaluation.speeds: expected each once, found"),
    ("protocols.sweep.speeds=[]", "protocols.sweep.speeds: expected at least one speed"),
    ("protocols.joystick.speeds=[1.0]", "protocols.joystick.speeds: expected none with a"),
    ("protocols.heldout.profile.rows=segments", "expected one case where rows are its"),
    ("robot.geometry.axes.hip_yaw=[0.0]", "axes.hip_yaw[1]: expected a value, found none"),
    ("gait.step_time={lower: .4, upper: .3}", "lower ≤ upper"),
    ("gauge.policies={hzd: here}", "gauge.policies: expected a name that no controller has"),
    ("gauge.seed=5", "gauge.seed: expected seeds within"),
    ("gauge.scales.payload=[1,2,3,4,5,6,7,8,9,9.0]", "scales.payload: expected rising values, fou"),
    ("seeds.final.last=1500", "seeds.final: expected first ≤ last, found"),
    ("seeds.final={first: 1500, last: 2500}", "expected no seed of seeds.development (1000 "),
    ("evaluation.seed=1995", "within 20260 to 21259 or 1000 to 1999, found 1995 to"),
    ("study.ablation.evaluation.seed=20260", "evaluation.seed: expected seeds within 1000 to 1999"),
    ("train.walking.seed=20262", "train.walking.seed: expected none of seeds.final (20260 "),
    ("robot.geometry.axes.pitch_direction=[0,0.8,-0.6]", "virtual_knee: expected null with a knee"),
    ("robot.geometry.axes.pitch_direction=[0,0.28,0.96]", "expected within 60° of y"),
    ("robot.geometry.axes.pitch_direction=[0,0.8,0.8]", "pitch_direction: expected a unit vector"),
    ("robot.geometry.ankle_direction=[0,0.8,-0.6]", "virtual_knee: expected null with a knee, a s"),
    ("robot.geometry.knee_direction=[0,0.8,-0.6]", "expected that of y where there is no"),
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
    return LISTS if isinstance(value, (list, tuple)) else NUMBERS[2:-1]


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
        changed = values = replaced(plain[group], place[1:], wrong)
        if isinstance(own, dict) and len(place) > 1 and place[-1] != "family":  # which chooses one
            own, values, group = own[place[1]], values[place[1]], f"{group}.{place[1]}"
        if not isinstance(own, dict) and values is not None:
            from_dict(type(own), values, group)  # quicker than the whole
        whole = from_dict(Config, plain | {str(place[0]): changed})
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
