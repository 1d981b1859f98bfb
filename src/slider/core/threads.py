"""Threads of a training: its physics has several, its networks one each."""

MOST = 4
_PHYSICS = 0.45  # of a training's time on one thread, simulates
_CRITIC = 0.13  # of it saves the critic's own thread


def threads(cores: int) -> int:
    """Half of the cores, from two to :data:`MOST`: with more the networks take most of the time."""
    return min(cores, max(2, min(cores // 2, MOST)))


def duration(threads: int) -> float:
    """Wall time of a training on idle cores, in parts of that on one thread."""
    return 1.0 - _PHYSICS + _PHYSICS / threads - (_CRITIC if threads > 1 else 0.0)
