"""Typed settings of the model-predictive baseline; see ``docs/explanation/baseline.md``."""

from typing import Literal

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT, Vector3


@dataclass(frozen=True, config=STRICT)
class StepConfig:
    """Steps: times [s], lateral distance of the feet and height of the swing foot [m].

    Attributes:
        time: nominal duration.
        time_min, time_max: range of the adapted duration.
        time_change: the planner may lengthen or shorten the current step by this; 0: never.
        width: lateral distance of the feet.
        apex: height of the swing foot at half time.
        switching: ``contact`` or ``time``; what ends a step.
        early: share of the duration before which a contact does not end the step.
        late: a step without a contact ends this long after its duration.
    """

    time: float
    time_min: float
    time_max: float
    time_change: float
    width: float
    apex: float
    switching: Literal["contact", "time"]
    early: float
    late: float


@dataclass(frozen=True, config=STRICT)
class PlannerConfig:
    """Footstep planner on the linear inverted pendulum.

    Attributes:
        steps: horizon.
        period: time between plans [s].
        speed: whether the command is the ``mean`` speed or that at the ``end`` of a step.
        length_weight: cost of (step − nominal step)² against (velocity error)² [1/s²].
        time_weight: cost of (duration − nominal duration)² [m²/s⁴].
        reach: largest forward step [m].
        width_min, width_max: lateral distance of successive feet [m].
        lock: no new plan in the last moments of a step [s].
        acceleration: with which the reference grows to the command [m/s²].
        integral: share of the last stride's velocity error that is added to the reference.
        integral_limit: largest sum of these [m/s].
    """

    steps: int
    period: float
    speed: Literal["mean", "end"]
    length_weight: float
    time_weight: float
    reach: float
    width_min: float
    width_max: float
    lock: float
    acceleration: float
    integral: float
    integral_limit: float


@dataclass(frozen=True, config=STRICT)
class SwingConfig:
    """End of the swing.

    Attributes:
        compression: how much lower a loaded sole is than one that just touches [m].
        touchdown_velocity: downward, at the end of the step [m/s].
        search_velocity: downward, past the end, until there is contact [m/s].
    """

    compression: float
    touchdown_velocity: float
    search_velocity: float


@dataclass(frozen=True, config=STRICT)
class EntryConfig:
    """Sway in double support.

    Attributes:
        duration: of one sway [s].
        patience: a sway that has not reached the orbit this long after its end is repeated [s].
        tolerance: allowed lack of orbital energy, as a length [m].
        settle: largest forward speed off the reference at the exit [m/s].
        push: largest distance of the centre of pressure from the middle of the feet, used to
            gain forward speed while swaying [m].
    """

    duration: float
    patience: float
    tolerance: float
    settle: float
    push: float


@dataclass(frozen=True, config=STRICT)
class TaskConfig:
    """Proportional [1/s²] and derivative [1/s] gain of a task, and its weights."""

    kp: float
    kd: float
    weight: Vector3


@dataclass(frozen=True, config=STRICT)
class WholeBodyConfig:
    """Whole-body QP.

    Attributes:
        com: centre of mass; its gains hold the height, and the place while swaying.
        base: orientation of the base.
        swing: middle of the swing foot's line.
        swing_rotation: pitch and yaw of the swing foot; the first weight is unused.
        stance: the stance feet do not move; weights of position, pitch and yaw.
        friction: coefficient that the controller counts on.
        force_max: of a contact point [N].
        effort_share: share of the drives' torque limits that is used.
        regularisation: of accelerations [1/(rad/s²)²] and of forces [1/N²].
    """

    com: TaskConfig
    base: TaskConfig
    swing: TaskConfig
    swing_rotation: TaskConfig
    stance: TaskConfig
    friction: float
    force_max: float
    effort_share: float
    regularisation: tuple[float, float]


@dataclass(frozen=True, config=STRICT)
class ObserverConfig:
    """State observer with the nominal robot.

    Attributes:
        delay: until the drives get the torques; it predicts over this time [s].
        position, velocity: shares of the measured difference that the estimate takes over per tick.
    """

    delay: float
    position: float
    velocity: float


@dataclass(frozen=True, config=STRICT)
class MpcConfig:
    """The baseline: footstep planner, swing, entry and whole-body controller.

    Attributes:
        substeps: simulation steps per control tick.
        observer: none: the controller is told what is measured.
    """

    substeps: int
    step: StepConfig
    planner: PlannerConfig
    swing: SwingConfig
    entry: EntryConfig
    whole_body: WholeBodyConfig
    observer: ObserverConfig | None = None


@dataclass(frozen=True, config=STRICT)
class ControlConfig:
    """Settings of the baseline; the evaluation's controller ``mpc_wbc_NAME`` has ``NAME``."""

    literal: MpcConfig
    tuned: MpcConfig
    observer: MpcConfig
