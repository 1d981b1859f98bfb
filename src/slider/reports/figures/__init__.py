"""Pictures of the gait library; one module per figure, drawn by the stage ``figures``."""

NAMES = (
    "limit_cycles",
    "gait_tiles",
    "velocity_maps",
    "convergence",
    "mapping",
    "smoothness",
)
FORMATS = ("svg", "png", "md")
FILES = tuple(f"{name}.{suffix}" for name in NAMES for suffix in FORMATS)
