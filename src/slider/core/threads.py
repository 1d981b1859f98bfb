"""Threads of a training: its physics has several, its networks one."""

MOST = 4
_PHYSICS = 0.5  # of a training's time on one thread, simulates


def threads(cores: int) -> int:
    """Half of the cores, at most :data:`MOST`: from then on the networks take most of the time."""
    return max(1, min(cores // 2, MOST))


def duration(threads: int) -> float:
    """Wall time of a training, in parts of that on one thread (Amdahl's law)."""
    return 1.0 - _PHYSICS + _PHYSICS / threads
