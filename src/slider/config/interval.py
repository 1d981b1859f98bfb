"""A range of values."""

from pydantic.dataclasses import dataclass

from slider.config.strict import STRICT


@dataclass(frozen=True, config=STRICT)
class Interval:
    """Closed interval."""

    lower: float
    upper: float
