"""Independent checks of solved gaits: other dynamics, other integrators, another robot."""
