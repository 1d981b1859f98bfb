"""Tables of event-based foot placement for all gaits of a library, as controllers read them."""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from slider.core.errors import UserError


@dataclass(frozen=True)
class FootPlacement:
    """Foot placement of G gaits of two steps, the second one reflected; S phases.

    At phase s of a step the swing foot is displaced by b = −K(s) (ξ − ξ*(s)),
    ξ = (c_y, ċ_y, ċ_x, c_x) the position and velocity of the centre of mass in the frame of the
    stance sole: x along its line, reflected in right stance.

    Attributes:
        velocities: of the gaits (G, 3) [m/s], [m/s], [rad/s].
        clock: whether the phase is time (G,), else the hip's position.
        phases: (S,) in [0, 1].
        gains: K(s) (G, 2, 2, S, 2, 4) [-], [s], [s], [-]: phase by time or by the hip, step, phase,
            forward and leftward displacement, coordinate. By the hip those for c_x are zero. A gait
            that has the gains for one kind of phase only has them twice, with that exception.
        orbit: ξ*(s) (G, 2, S, 4) on the limit cycle [m], [m/s], [m/s], [m].
        placement: D (G, 2, 10, 2): displacement of the joints, stance leg first, per displacement
            of the swing sole [rad/m, m/m].
        hip: forward position of the base's origin from the stance sole and two derivatives over
            the phase (G, 2, N, 3) at N evenly spaced phases [m].
    """

    velocities: np.ndarray
    clock: np.ndarray
    phases: np.ndarray
    gains: np.ndarray
    orbit: np.ndarray
    placement: np.ndarray
    hip: np.ndarray

    @property
    def hip_share(self) -> np.ndarray:
        """Least forward velocity of the hip (G,), as a share of its mean in the same step."""
        way = np.ptp(self.hip[:, :, [0, -1], 0], axis=2)
        return (self.hip[..., 1].min(axis=2) / way).min(axis=1)

    def save(self, folder: Path) -> None:
        """Write one ``.npy`` per array."""
        for field in fields(self):
            np.save(folder / f"{field.name}.npy", getattr(self, field.name))

    @classmethod
    def load(cls, folder: Path) -> "FootPlacement":
        """Read the arrays that ``save`` wrote.

        Raises:
            UserError: an array is missing.
        """
        try:
            return cls(*(np.load(folder / f"{field.name}.npy") for field in fields(cls)))
        except FileNotFoundError as error:
            missing = f"{Path(error.filename).name} of the foot placement in {folder}"
            raise UserError(f"expected {missing}, found none") from None
