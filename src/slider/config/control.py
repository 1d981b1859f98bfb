"""Typed settings of the controllers that are not learned.

See ``docs/explanation/baseline.md`` and ``docs/explanation/hzd.md``.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from slider.config import types as t

POLICY = "policy"  # the learned controller; every other one is named in ``Config.control``
POLICY_LABEL = "policy (ours)"
ONBOARD = "_onboard"  # NAME_onboard: controller NAME, which receives the state estimated on board
PAPER_LABELS = {"guided_drl": "guided RL (paper)", "mpc_wbc": "MPC + WBC (paper)"}
"""Controllers of the paper's Table 1; its rows are in ``slider/reports/paper_table1.csv``."""

SMOKE_AGENTS = ("zero", "random")  # of ``slider play``, to check an environment; they see nothing
RESERVED = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names with a meaning of their own


class StepConfig(t.Group, kw_only=True):
    """Ends of steps."""

    early: t.Share
    """share of the duration before which a contact does not end the step"""
    late: t.Seconds
    """a step without a contact ends this long after its duration"""


class PlannedStepConfig(StepConfig, kw_only=True):
    """Steps of the footstep planner."""

    time: t.Positive[t.Seconds]
    """nominal duration"""
    width: t.Positive[t.Metres]
    """lateral distance of the feet"""
    time_per_speed: Annotated[t.NonNegative[t.Number], t.Unit("s²/m")] = 0.0
    """growth of the nominal duration with the forward reference speed"""
    time_min: t.Positive[t.Seconds]
    """least duration that is adapted to"""
    time_max: t.Positive[t.Seconds]
    """greatest duration that is adapted to"""
    time_change: t.Seconds
    """the planner may lengthen or shorten the current step by this; 0: never"""
    apex: t.Positive[t.Metres]
    """height of the swing foot at half time"""
    switching: Literal["contact", "time"]
    """what ends a step"""


class PlannerConfig(t.Group):
    """Footstep planner on the linear inverted pendulum."""

    steps: Annotated[t.Count, Field(le=100)]
    """horizon"""
    period: t.Positive[t.Seconds]
    """time between plans"""
    speed: Literal["mean", "end"]
    """whether the commanded speed is the mean, or that at the end of a step"""
    length_weight: Annotated[t.NonNegative[t.Number], t.Unit("1/s²")]
    """cost of (step − nominal step)² against (velocity error)²"""
    time_weight: Annotated[t.NonNegative[t.Number], t.Unit("m²/s⁴")]
    """cost of (duration − nominal duration)²"""
    length_max: t.Positive[t.Metres]
    """largest forward step"""
    width_min: t.NonNegative[t.Metres]
    """least lateral distance of successive feet: they do not cross"""
    width_max: t.Positive[t.Metres]
    """greatest lateral distance of successive feet"""
    lock: t.Positive[t.Seconds]
    """no new plan in the last moments of a step"""


class VelocityConfig(t.Group):
    """Reference velocity."""

    acceleration: t.Positive[t.MetresPerSecond2]
    """with which the reference grows to the commanded velocity"""
    integral: t.Share
    """share of the last stride's velocity error that is added to the reference"""
    integral_limit: t.NonNegative[t.MetresPerSecond]
    """largest sum of these"""
    integral_after: t.Seconds
    """no integral action before this time after a change of the commanded velocity"""


class SwingConfig(t.Group):
    """End of the swing."""

    compression: t.NonNegative[t.Metres]
    """how much lower a loaded sole is than one that just touches"""
    touchdown_velocity: t.NonNegative[t.MetresPerSecond]
    """downward, at the end of the step"""
    search_velocity: t.NonNegative[t.MetresPerSecond]
    """downward, past the end, until there is contact"""


class EntryConfig(t.Group):
    """Sway in double support into the lateral orbit."""

    duration: t.Positive[t.Seconds]
    """of one sway"""
    patience: t.Seconds
    """a sway that has not reached the orbit this long after its end is repeated"""
    tolerance: t.NonNegative[t.Metres]
    """how far beyond its orbit the first step may end sideways"""
    speed_tolerance: t.NonNegative[t.MetresPerSecond]
    """largest forward speed off the reference at the exit"""
    push: t.NonNegative[t.Metres]
    """largest distance of the centre of pressure from the middle of the feet, to gain speed"""


class TaskConfig(t.Group):
    """Gains of a task, and its weights."""

    kp: Annotated[t.NonNegative[t.Number], t.Unit("1/s²")]
    kd: Annotated[t.NonNegative[t.Number], t.Unit("1/s")]
    weight: t.Vector3[t.NonNegative[t.Number]]
    """per axis; of stance: position, pitch and yaw"""


class WholeBodyConfig(t.Group):
    """Whole-body QP.

    Tasks: ``com``, whose gains hold the height, and the place while swaying; ``base``, its
    orientation; ``stance``, feet that do not move.
    """

    com: TaskConfig
    base: TaskConfig
    stance: TaskConfig
    friction: t.Positive[t.Factor]
    """coefficient that the controller counts on"""
    force_max: t.Positive[t.Newtons]
    """of a contact point"""
    effort_share: t.Positive[t.Share]
    """share of the drives' torque limits that is used"""
    regularisation: tuple[
        Annotated[t.Positive[t.Number], t.Unit("1/(rad/s²)²")],
        Annotated[t.Positive[t.Number], t.Unit("1/N²")],
    ]
    """of accelerations and of forces"""


class SteppingBodyConfig(WholeBodyConfig):
    """Whole-body QP with the swing foot's tasks.

    ``swing``: middle of its line; ``swing_rotation``: its pitch and yaw (the first weight is
    unused).
    """

    swing: TaskConfig
    swing_rotation: TaskConfig


class ObserverConfig(t.Group):
    """State observer with the nominal robot."""

    delay: t.Seconds
    """until the drives get the torques; it predicts over this time"""
    position: t.Positive[t.Share]
    """share of the measured difference that the estimate takes over per tick"""
    velocity: t.Positive[t.Share]
    """the same of velocities"""


class ModelBasedConfig(t.Group, kw_only=True):
    """What controllers with a whole-body QP share."""

    substeps: Annotated[t.Count, Field(le=1000)]
    """simulation steps per control tick"""
    height: t.Positive[t.Factor]
    """of the pendulum, as a share of that of the centre of mass in the nominal pose"""
    step: StepConfig
    velocity: VelocityConfig
    entry: EntryConfig
    whole_body: WholeBodyConfig
    observer: ObserverConfig | None = None
    """null: the controller receives what is measured"""
    label: str = ""
    """what tables and figures call it"""


class MpcConfig(ModelBasedConfig, kw_only=True):
    """A model-predictive controller: footstep planner, swing and whole-body control."""

    family: Literal["mpc"]
    """how it walks: footsteps planned on a pendulum"""
    step: Annotated[PlannedStepConfig, t.ordered("time_min", "time", "time_max")]
    planner: Annotated[PlannerConfig, t.ordered("width_min", "width_max")]
    swing: SwingConfig
    whole_body: SteppingBodyConfig


class OutputWeights(t.Group):
    """Weights of the outputs' accelerations in the QP, against those of a stance foot's motion."""

    torso: t.Vector3[t.NonNegative[t.Number]]
    """yaw, roll, pitch"""
    stance_slide: t.NonNegative[t.Number]
    stance_ankle: t.NonNegative[t.Number]
    """small: the foot's length bounds what it can do"""
    swing_leg: t.Vector3[t.NonNegative[t.Number]]
    """yaw, roll, pitch"""
    swing_slide: t.NonNegative[t.Number]
    swing_foot: t.NonNegative[t.Number]
    """pitch"""


class ChangeConfig(t.Group):
    """Largest difference of a step's gait from the mean velocity of the step before."""

    faster: t.Positive[t.MetresPerSecond]
    slower: t.Positive[t.MetresPerSecond]


class HzdControlConfig(ModelBasedConfig, kw_only=True):
    """Hybrid zero dynamics: the constraints of ``hzd``, enforced by a QP, with foot placement."""

    family: Literal["hzd"]
    """how it walks: virtual constraints of the gait library"""
    weights: OutputWeights
    ahead: t.Seconds
    """a step's gait is for the reference velocity this much later"""
    change: ChangeConfig
    fastest: t.Positive[t.MetresPerSecond]
    """forward velocity of a gait: few faster ones walk (reports/gait_walks.csv)"""
    hip_start: t.Interval[t.Number]
    """phases at which a step can begin by the hip"""
    hip_rate: t.Interval[t.Positive[t.Number]]
    """of the phase by the hip, as a share of the gait's; a step beyond them begins by time"""
    yaw_acceleration: Annotated[t.Positive[t.Number], t.Unit("rad/s²")]
    """with which the yaw rate of a walk follows the commanded one"""
    lock: t.Share
    """no change of the foothold from this phase on"""
    settling: t.Positive[t.Seconds]
    """time constant with which the foothold follows"""
    descent: t.NonNegative[t.MetresPerSecond]
    """of a foot without contact: past the end of its step, and while standing"""


FAMILIES: dict[str, type[MpcConfig] | type[HzdControlConfig]] = {
    "mpc": MpcConfig,
    "hzd": HzdControlConfig,
}
AnyControl = Annotated[MpcConfig | HzdControlConfig, Field(discriminator="family")]


def _told_apart(controls: dict[str, AnyControl]) -> dict[str, AnyControl]:
    """Controllers with names and labels of their own."""
    labels = {POLICY_LABEL: POLICY, **{label: name for name, label in PAPER_LABELS.items()}}
    for name, control in controls.items():
        expected = f"another name than {', '.join(RESERVED)} and those that end with {ONBOARD}"
        t.require(name not in RESERVED and not name.endswith(ONBOARD), name, expected, name)
        label, owner = control.label, labels.setdefault(control.label, name)
        possible = label and label.isprintable() and owner == name
        expected = f"one line that is not the label of {owner} (a file without one inherits it)"
        t.require(possible, f"{name}.label", expected, repr(label))
    return controls


Controls = Annotated[t.Named[AnyControl], AfterValidator(_told_apart)]
