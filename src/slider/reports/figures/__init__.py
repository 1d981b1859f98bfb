"""Pictures of robot and gait library; one module per figure, drawn by the stage ``figures``."""

NAMES = (
    "capstan",
    "mapping",
    "zero_dynamics",
    "limit_cycles",
    "gait_tiles",
    "velocity_maps",
    "convergence",
    "smoothness",
)
FORMATS = ("svg", "png", "md")
STABILITY = ("spectral_radius", "basins", "phase_portraits")
FILES = tuple(f"{name}.{suffix}" for name in NAMES for suffix in FORMATS)
STABILITY_FILES = tuple(f"{name}.{suffix}" for name in STABILITY for suffix in FORMATS)
