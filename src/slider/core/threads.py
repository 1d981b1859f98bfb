"""Threads of a training: its physics has several, its networks one each."""

MOST = 4


def threads(cores: int) -> int:
    """Half of the cores, from two to :data:`MOST`: with more the networks take most of the time."""
    return min(cores, max(2, min(cores // 2, MOST)))
