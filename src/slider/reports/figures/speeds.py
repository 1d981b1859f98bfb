"""Which forward velocities stand for a whole library in a figure."""

import numpy as np

from slider.library.reader import GaitLibrary


def forward_gaits(library: GaitLibrary, count: int) -> np.ndarray:
    """Indices of at most ``count`` gaits straight ahead, evenly spread, slowest to fastest.

    Straight ahead is the leftward velocity nearest to zero that the library has.
    """
    vx, vy = library.velocities.T
    straight = np.flatnonzero(np.abs(vy) == np.abs(vy).min())
    # One row: where −0.05 and 0.05 are equally near, the first of them.
    straight = straight[vy[straight] == vy[straight[0]]]
    ordered = straight[np.argsort(vx[straight])]
    wanted = np.linspace(vx[ordered[0]], vx[ordered[-1]], count)
    return ordered[np.unique(np.abs(vx[ordered] - wanted[:, None]).argmin(axis=1))]
