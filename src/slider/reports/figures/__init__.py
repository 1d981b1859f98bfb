"""Figures of robot, gaits and controllers as SVG; only names here, so that plans draw nothing."""

NAMES = ("mapping", "zero_dynamics", "limit_cycles", "velocity_maps")
FILES = tuple(f"{name}.{suffix}" for name in NAMES for suffix in ("svg", "md"))
