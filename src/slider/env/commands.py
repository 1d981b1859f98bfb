"""Commanded velocities of training episodes, and their growth with success."""

from slider.config.train import CommandConfig, CurriculumConfig
from slider.core.arrays import NUMPY, Array, Random, asarray, namespace, put, which, zeros


class CommandSampler:
    """Draws vx, vy [m/s] and yaw rate [rad/s], beside the array ``like``."""

    def __init__(self, config: CommandConfig, control_period: float, like: Array = NUMPY) -> None:
        self._config = config
        ranges = (config.vx, config.vy, config.yaw_rate)
        self._lower = asarray([r.lower for r in ranges], like)
        self._upper = asarray([r.upper for r in ranges], like)
        self._change = control_period / config.period if config.period > 0 else 0.0

    def sample(self, rng: Random, count: int, share: Array | float = 1.0) -> Array:
        """New commands (count, 3) within a share of the ranges; a fraction of them is zero."""
        commands = rng.uniform(share * self._lower, share * self._upper, (count, 3))
        put(commands, which(rng.uniform(size=count) < self._config.standing_fraction), 0.0)
        return commands

    def changing(self, rng: Random, num_robots: int) -> Array:
        """Index of the robots that get a new command in this control step."""
        if self._change == 0.0:
            return which(zeros(0, self._lower) != 0)
        return which(rng.uniform(size=num_robots) < self._change)


class Curriculum:
    """The share of the command ranges that is in use.

    It is known where episodes are counted: on the device of ``like``.

    Args:
        config: where the share begins and how it grows.
        window: number of episodes after which the share may grow.
        like: an array beside those of the episodes.

    Attributes:
        share: (1,).
    """

    def __init__(self, config: CurriculumConfig, window: int, like: Array = NUMPY) -> None:
        self._config, self._window = config, window
        self.share = zeros(1, like) + config.start
        self._ended, self._fallen = zeros(1, like), zeros(1, like)

    @property
    def enabled(self) -> bool:
        """Whether there is anything to grow."""
        return self._config.start < 1.0

    def note(self, ended: Array, fallen: Array) -> None:
        """Count episodes of robots (N,) that ended, some in a fall; grow after a good window."""
        if not self.enabled:
            return
        xp = namespace(self.share)
        self._ended += (1.0 * ended).sum()
        self._fallen += (1.0 * fallen).sum()
        full = self._ended >= self._window
        good = full & (1.0 - self._fallen / self._ended.clip(min=1.0) >= self._config.success)
        grown = (self.share + self._config.growth).clip(max=1.0)
        self.share = xp.where(good, grown, self.share)
        for count in (self._ended, self._fallen):
            put(count, which(full), 0.0)
