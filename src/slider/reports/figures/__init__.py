"""Figures of robot, gaits and controllers, each as SVG; names here, so that plans draw nothing."""

NAMES = (
    "mapping",
    "zero_dynamics",
    "limit_cycles",
    "gait_tiles",
    "velocity_maps",
)
FORMATS = ("svg", "md")
FILES = tuple(f"{name}.{suffix}" for name in NAMES for suffix in FORMATS)
