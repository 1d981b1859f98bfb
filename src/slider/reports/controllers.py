"""How controllers and commands look wherever people see them."""

OURS, PAPER = "measured", "paper"  # the column ``source`` of Table 1

# Tell apart in print, by colour-blind readers, on light and on dark ground.
PALETTE = ("#2a6fc9", "#e8932c", "#2a9d74", "#b565b5", "#8b8f96", "#c4a000", "#d1495b")
_DASHES = ("solid", "solid", "dot", "dash")  # the first two differ in lightness


def speed(command: float) -> str:
    """Commanded velocity as people write it, such as ``1.0`` or ``0.25`` [m/s]."""
    return f"{command:.1f}" if round(command, 1) == command else f"{command:g}"


def line(index: int, width: float = 1.8) -> dict[str, str | float]:
    """Line of the controller, or other curve, number ``index``: told apart in grey, too."""
    return {"color": colour(index), "width": width, "dash": _DASHES[index % len(_DASHES)]}


def colour(index: int) -> str:
    """Colour of the controller, or other curve, number ``index``."""
    return PALETTE[index % len(PALETTE)]
