"""Typed settings of the controllers that are not learned.

See ``docs/explanation/baseline.md`` and ``docs/explanation/hzd.md``.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from slider.config import types as t

POLICY = "policy"  # the learned controller; every other one is named in ``Config.control``
POLICY_LABEL = "policy (ours)"
ONBOARD = "_onboard"  # NAME_onboard: controller NAME with the state estimated by onboard sensors
PAPER_LABELS = {"guided_drl": "guided RL (paper)", "mpc_wbc": "MPC + WBC (paper)"}
"""Controllers of the paper's Table 1; its rows are in ``slider/reports/paper_table1.csv``."""

SMOKE_AGENTS = ("zero", "random")  # of ``slider play``, to check an environment
RESERVED = (POLICY, *SMOKE_AGENTS, *PAPER_LABELS)  # names that no entry of ``control`` may have


class StepConfig(t.Group, kw_only=True):
    """When a step ends."""

    early: t.Share
    """share of the duration before which a contact does not end the step"""
    late: t.Seconds
    """a step without a contact ends this long after its duration"""


class PlannedStepConfig(StepConfig, kw_only=True):
    """Steps of the footstep planner."""

    time: t.Positive[t.Seconds]
    """nominal step duration"""
    width: t.Positive[t.Metres]
    """nominal lateral distance between the feet"""
    time_per_speed: Annotated[t.NonNegative[t.Number], t.Unit("s²/m")] = 0.0
    """increase of the nominal duration per forward reference speed"""
    time_min: t.Positive[t.Seconds]
    """minimum step duration"""
    time_max: t.Positive[t.Seconds]
    """maximum step duration"""
    time_change: t.Seconds
    """amount by which a plan may lengthen or shorten the current step; 0: never"""
    apex: t.Positive[t.Metres]
    """height of the swing foot at mid-step"""
    switching: Literal["contact", "time"]
    """what ends a step: touchdown of the swing foot, or time"""


class PlannerConfig(t.Group):
    """Footstep planner on the linear inverted pendulum."""

    steps: Annotated[t.Count, Field(le=100)]
    """planning horizon, in steps"""
    period: t.Positive[t.Seconds]
    """time between plans"""
    speed: Literal["mean", "end"]
    """the commanded speed is the mean speed of a step, or the speed at its end"""
    length_weight: Annotated[t.NonNegative[t.Number], t.Unit("1/s²")]
    """weight of (step − nominal step)², relative to (velocity error)²"""
    time_weight: Annotated[t.NonNegative[t.Number], t.Unit("m²/s⁴")]
    """weight of (duration − nominal duration)², relative to (velocity error)²"""
    length_max: t.Positive[t.Metres]
    """maximum forward step length"""
    width_min: t.NonNegative[t.Metres]
    """minimum lateral distance of successive footholds, so that the legs do not cross"""
    width_max: t.Positive[t.Metres]
    """maximum lateral distance of successive footholds"""
    lock: t.Positive[t.Seconds]
    """no replanning when less than this remains of a step"""


class VelocityConfig(t.Group):
    """Reference velocity."""

    acceleration: t.Positive[t.MetresPerSecond2]
    """acceleration of the reference towards the commanded velocity"""
    integral: t.Share
    """share of the last stride's velocity error that is added to the reference"""
    integral_limit: t.NonNegative[t.MetresPerSecond]
    """bound of the integral term, per component"""
    integral_after: t.Seconds
    """no integral action before this time after a change of the commanded velocity"""


class SwingConfig(t.Group):
    """End of the swing phase."""

    compression: t.NonNegative[t.Metres]
    """how much lower a loaded sole is than one that just touches the ground"""
    touchdown_velocity: t.NonNegative[t.MetresPerSecond]
    """downward velocity of the swing foot at the end of the step"""
    search_velocity: t.NonNegative[t.MetresPerSecond]
    """downward velocity after the end of the step, until there is contact"""


class EntryConfig(t.Group):
    """Lateral sway in double support, from rest into the periodic orbit of the centre of mass."""

    duration: t.Positive[t.Seconds]
    """duration of one sway"""
    patience: t.Seconds
    """a sway that has not reached the orbit this long after its end is repeated"""
    tolerance: t.NonNegative[t.Metres]
    """lateral distance by which the first step may end outside the orbit"""
    speed_tolerance: t.NonNegative[t.MetresPerSecond]
    """largest deviation of the forward speed from its reference when the first step starts"""
    push: t.NonNegative[t.Metres]
    """largest offset of the centre of pressure from the middle of the feet, to gain speed"""


class TaskConfig(t.Group):
    """Gains and weights of a task."""

    kp: Annotated[t.NonNegative[t.Number], t.Unit("1/s²")]
    kd: Annotated[t.NonNegative[t.Number], t.Unit("1/s")]
    weight: t.Vector3[t.NonNegative[t.Number]]
    """weight per axis; for ``stance``: position, pitch and yaw"""


class WholeBodyConfig(t.Group):
    """Whole-body QP.

    Tasks: ``com``, with gains for the height and, while swaying, the horizontal position; ``base``,
    the base orientation; ``stance``, stance feet that do not move.
    """

    com: TaskConfig
    base: TaskConfig
    stance: TaskConfig
    friction: t.Positive[t.Factor]
    """friction coefficient that the controller assumes"""
    force_max: t.Positive[t.Newtons]
    """bound of each force component at a contact point"""
    effort_share: t.Positive[t.Share]
    """share of the drives' torque limits that the controller may use"""
    regularisation: tuple[
        Annotated[t.Positive[t.Number], t.Unit("1/(rad/s²)²")],
        Annotated[t.Positive[t.Number], t.Unit("1/N²")],
    ]
    """weights of the regularisation of accelerations and of contact forces"""


class SteppingBodyConfig(WholeBodyConfig):
    """Whole-body QP with tasks of the swing foot.

    ``swing``: position of the middle of the foot; ``swing_rotation``: its pitch and yaw (the first
    weight is unused).
    """

    swing: TaskConfig
    swing_rotation: TaskConfig


class ObserverConfig(t.Group):
    """State observer that simulates the nominal robot."""

    delay: t.Seconds
    """actuation delay, over which the observer predicts the state"""
    position: t.Positive[t.Share]
    """observer gain of positions: share of the innovation added to the estimate per tick"""
    velocity: t.Positive[t.Share]
    """observer gain of velocities"""


class ModelBasedConfig(t.Group, kw_only=True):
    """Settings shared by controllers with a whole-body QP."""

    substeps: Annotated[t.Count, Field(le=1000)]
    """simulation steps per control tick"""
    height: t.Positive[t.Factor]
    """pendulum height, relative to the height of the centre of mass in the nominal pose"""
    step: StepConfig
    velocity: VelocityConfig
    entry: EntryConfig
    whole_body: WholeBodyConfig
    observer: ObserverConfig | None = None
    """null: the controller receives the measured state"""
    label: str = ""
    """name in tables and figures"""


class MpcConfig(ModelBasedConfig, kw_only=True):
    """A model-predictive controller: footstep planner, swing and whole-body control."""

    family: Literal["mpc"]
    """kind of controller: footsteps planned on an inverted pendulum"""
    step: Annotated[PlannedStepConfig, t.ordered("time_min", "time", "time_max")]
    planner: Annotated[PlannerConfig, t.ordered("width_min", "width_max")]
    swing: SwingConfig
    whole_body: SteppingBodyConfig


class OutputWeights(t.Group):
    """QP weights of the outputs' accelerations, relative to those of the stance foot's motion."""

    torso: t.Vector3[t.NonNegative[t.Number]]
    """yaw, roll, pitch"""
    stance_slide: t.NonNegative[t.Number]
    stance_ankle: t.NonNegative[t.Number]
    """small, since the foot's length limits the ankle torque"""
    swing_leg: t.Vector3[t.NonNegative[t.Number]]
    """yaw, roll, pitch"""
    swing_slide: t.NonNegative[t.Number]
    swing_foot: t.NonNegative[t.Number]
    """pitch"""


class ChangeConfig(t.Group):
    """Largest change from the mean velocity of a step to the gait velocity of the next one."""

    faster: t.Positive[t.MetresPerSecond]
    slower: t.Positive[t.MetresPerSecond]


class HzdControlConfig(ModelBasedConfig, kw_only=True):
    """Hybrid zero dynamics: the constraints of ``hzd``, enforced by a QP, with foot placement."""

    family: Literal["hzd"]
    """kind of controller: virtual constraints of the gait library"""
    weights: OutputWeights
    ahead: t.Seconds
    """look-ahead: a step's gait is chosen for the reference velocity this much later"""
    change: ChangeConfig
    fastest: t.Positive[t.MetresPerSecond]
    """maximum forward velocity of a gait; few faster ones walk (reports/gait_walks.csv)"""
    hip_start: t.Interval[t.Number]
    """initial phases of a step for which the hip position is the phase variable, else time"""
    hip_rate: t.Interval[t.Positive[t.Number]]
    """bounds of the hip's phase rate, relative to the gait's; steps that start outside use time"""
    yaw_acceleration: Annotated[t.Positive[t.Number], t.Unit("rad/s²")]
    """acceleration of the walk's yaw rate towards the commanded one"""
    lock: t.Share
    """phase from which the foothold is no longer changed"""
    settling: t.Positive[t.Seconds]
    """time constant of the low-pass filter on the foothold"""
    descent: t.NonNegative[t.MetresPerSecond]
    """downward velocity of a foot without contact, after the end of its step and in standing"""


FAMILIES: dict[str, type[MpcConfig] | type[HzdControlConfig]] = {
    "mpc": MpcConfig,
    "hzd": HzdControlConfig,
}
AnyControl = Annotated[MpcConfig | HzdControlConfig, Field(discriminator="family")]


def _told_apart(controls: dict[str, AnyControl]) -> dict[str, AnyControl]:
    """Reject controllers with a reserved name, or without a unique label."""
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
