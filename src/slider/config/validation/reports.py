"""Rules of the page, and of the studies beside the way to Table 1."""

from slider.config.parameters import choose, parameters
from slider.config.report import ReportConfig
from slider.config.schema import Config
from slider.config.studies import AblationConfig
from slider.config.validation.checks import named, one_of, period, require


def check_ablation(ablation: AblationConfig) -> None:
    """Known variants."""
    named("ablation.variants", ablation.variants)
    for name in ablation.run:
        one_of("ablation.run", name, ablation.variants)


def check_sensitivity(config: Config) -> None:
    """Parameters that there are, and something to look at."""
    settings, found = config.sensitivity, parameters(config.robot)
    for tag in settings.provenance:
        one_of("sensitivity.provenance", tag, dict.fromkeys(item.provenance for item in found))
    expected = f"numbers of the robot tagged {' or '.join(settings.provenance)}"
    for path in settings.parameters:
        chosen = choose(found, settings.provenance, [path])
        require(len(chosen) > 0, "sensitivity.parameters", expected, path)
    steady, end = settings.warm_up, settings.duration
    period("sensitivity.warm_up", steady, end, config.env.control_period)
    expected = "one of gaits and policy true"
    require(settings.gaits or settings.policy, "sensitivity", expected, "both false")


def check_report(report: ReportConfig, control_period: float) -> None:
    """Frames of the videos; whoever lays out the jobs knows which sections there are."""
    _frame_rate(report.video.frame_rate, control_period, "report.video.frame_rate")


def _frame_rate(rate: int, control_period: float, key: str) -> None:
    """Every frame shows the end of a control step."""
    steps = 1.0 / (control_period * rate)
    expected = f"a divisor of the control rate ({1 / control_period:g} 1/s)"
    require(steps >= 1 and abs(steps - round(steps)) < 1e-9, key, expected, rate)
