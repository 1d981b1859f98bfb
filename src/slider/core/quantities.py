"""Quantities, which are columns of data frames: title, unit and number format."""

import math
from dataclasses import dataclass

NONE = "–"
_MOST_DECIMALS = 6  # a robot that stands still has errors of 1e-10 m²/s²


@dataclass(frozen=True)
class Quantity:
    """A column of the reports; the unit of a share starts with %.

    ``scale`` is the ratio of displayed to stored values, which are in SI units or shares of 1.
    ``digits`` is the number format, by default three digits, or percent with one decimal.
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
        """Whether the quantity is shown in percent."""
        return self.unit.startswith("%")

    def text(self, value: float) -> str:
        """Formatted value; – for NaN."""
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
        """Value with its 95 % confidence interval, such as ``99.6 [99, 99.8]``."""
        if math.isnan(value) or math.isnan(low):
            return self.text(value)
        return f"{self.text(value)} [{self.text(low)}, {self.text(high)}]"

    def ranged(self, value: float, low: float, high: float) -> str:
        """Value with its range, such as ``0.15 (0.10–0.20)``; without it if its ends look equal."""
        text, least, greatest = map(self.text, (value, low, high))
        return text if least == greatest else f"{text} ({least}–{greatest})"


def decimals(value: float) -> int:
    """Number of decimals for three significant digits, as in the paper; limited for tiny values."""
    if value <= 0:
        return 3
    return min(max(0, 2 - math.floor(math.log10(value))), _MOST_DECIMALS)


def speed_text(speed: float) -> str:
    """Commanded speed [m/s] as text, such as ``1.0`` or ``0.25``."""
    return f"{speed:.1f}" if round(speed, 1) == speed else f"{speed:g}"
