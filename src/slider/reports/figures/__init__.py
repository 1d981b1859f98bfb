"""Pictures of the gait library; one module per figure, drawn by the stage ``figures``.

Those of stability are drawn by the stage ``stability_figures``.
"""

NAMES = (
    "limit_cycles",
    "gait_tiles",
    "velocity_maps",
    "convergence",
    "knee_map_error",
    "smoothness",
)
FORMATS = ("svg", "png", "md")
STABILITY = ("spectral_radius", "basins", "phase_portraits")
FILES = tuple(f"{name}.{suffix}" for name in NAMES for suffix in FORMATS)
STABILITY_FILES = tuple(f"{name}.{suffix}" for name in STABILITY for suffix in FORMATS)
