"""How controllers are called and coloured wherever people see them."""

OURS, PAPER = "measured", "paper"  # the column ``source`` of Table 1

_LABELS = {
    (OURS, "policy"): "policy (ours)",
    (OURS, "mpc_wbc_literal"): "MPC + WBC, literal",
    (OURS, "mpc_wbc_tuned"): "MPC + WBC, tuned",
    (OURS, "mpc_wbc_observer"): "MPC + WBC, with observer",
    (PAPER, "guided_drl"): "guided RL (paper)",
    (PAPER, "mpc_wbc"): "MPC + WBC (paper)",
}
# Tell apart in print, by colour-blind readers, on light and on dark ground.
PALETTE = ("#2a6fc9", "#e8932c", "#2a9d74", "#b565b5", "#8b8f96", "#c4a000", "#d1495b")
_DASHES = ("solid", "solid", "dot", "dash")  # the first two differ in lightness


def label(controller: str, source: str = OURS) -> str:
    """What people call a controller; one without a label keeps its name."""
    name = controller.replace("_", " ")
    return _LABELS.get((source, controller), name if source == OURS else f"{name} ({source})")


def speed(command: float) -> str:
    """Commanded velocity as people write it, such as ``1.0`` or ``0.25`` [m/s]."""
    return f"{command:.1f}" if round(command, 1) == command else f"{command:g}"


def line(index: int, width: float = 1.8) -> dict[str, str | float]:
    """Line of the controller, or other curve, number ``index``: told apart in grey, too."""
    return {"color": colour(index), "width": width, "dash": _DASHES[index % len(_DASHES)]}


def colour(index: int) -> str:
    """Colour of the controller, or other curve, number ``index``."""
    return PALETTE[index % len(PALETTE)]
