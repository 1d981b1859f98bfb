"""Quantities, the columns of frames: title, unit, and how their numbers are printed."""

import math
from dataclasses import dataclass

NONE = "–"
_MOST_DECIMALS = 6  # a robot that stands still has errors of 1e-10 m²/s²


@dataclass(frozen=True)
class Quantity:
    """A column of the reports; the unit of a share starts with %.

    ``scale`` is the shown number per stored one, which is in SI units, or a share of 1; ``digits``
    is the format of numbers, by default three digits, or percent with one decimal.
    """

    title: str
    unit: str = ""
    scale: float = 1.0
    digits: str = ""

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @property
    def share(self) -> bool:
        """Whether it is shown in percent."""
        return self.unit.startswith("%")

    def text(self, value: float) -> str:
        """A number as it is printed; – for NaN."""
        if math.isnan(value):
            return NONE
        if math.isinf(value):
            return "∞"
        shown = self.scale * value
        if self.digits:
            return f"{shown:{self.digits}}"
        if self.share:
            text = f"{shown:.1f}".removesuffix(".0")
            return "< 0.1" if 0 < shown < 0.05 else "0" if text == "-0" else text
        text = f"{shown:.{decimals(abs(shown))}f}"
        return text if float(text) else "0"

    def between(self, value: float, low: float, high: float) -> str:
        """A number with its 95 % interval, such as ``99.6 [99, 99.8]``."""
        if math.isnan(value) or math.isnan(low):
            return self.text(value)
        return f"{self.text(value)} [{self.text(low)}, {self.text(high)}]"

    def ranged(self, value: float, low: float, high: float) -> str:
        """A number and what it lies between, such as ``0.15 (0.10–0.20)``, unless all look same."""
        text, least, greatest = map(self.text, (value, low, high))
        return text if least == greatest else f"{text} ({least}–{greatest})"


def decimals(value: float) -> int:
    """Decimals that show three digits of a value, as the paper does, unless it is next to none."""
    if value <= 0:
        return 3
    return min(max(0, 2 - math.floor(math.log10(value))), _MOST_DECIMALS)


def speed_text(speed: float) -> str:
    """Commanded speed as people write it, such as ``1.0`` or ``0.25`` [m/s]."""
    return f"{speed:.1f}" if round(speed, 1) == speed else f"{speed:g}"
