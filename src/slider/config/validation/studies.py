"""Rules of the studies."""

from slider.config.parameters import choose, parameters
from slider.config.schema import Config
from slider.config.studies import ScalingConfig
from slider.config.validation.checks import named, one_of, require


def check_studies(config: Config) -> None:
    """Variants and parameters that exist, and results to compare."""
    named("study", config.study)
    for name, study in config.study.items():
        key = f"study.{name}"
        named(f"{key}.variants", study.variants)
        for variant in study.run:
            one_of(f"{key}.run", variant, study.variants)
        if study.scaling is not None:
            _scaling(study.scaling, config, f"{key}.scaling")
        compared = study.gaits or study.evaluation is not None
        require(compared, key, "gaits=true or an evaluation", "neither")
        possible = study.gaits or study.starts is None
        require(possible, f"{key}.starts", "null without gaits", "starts")
        possible = study.evaluation is not None or study.training is None
        require(possible, f"{key}.training", "null without an evaluation", "a training")


def _scaling(scaling: ScalingConfig, config: Config, key: str) -> None:
    items = parameters(config.robot)
    for tag in scaling.provenance:
        one_of(f"{key}.provenance", tag, dict.fromkeys(item.provenance for item in items))
    expected = f"numbers of the robot tagged {' or '.join(scaling.provenance)}"
    for path in scaling.parameters:
        require(
            bool(choose(items, scaling.provenance, [path])), f"{key}.parameters", expected, path
        )
