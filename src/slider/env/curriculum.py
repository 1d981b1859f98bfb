"""Commands that grow with success."""

from slider.config.train import CurriculumConfig


class Curriculum:
    """The share of the command ranges that is in use.

    Args:
        config: where the share begins and how it grows.
        window: number of episodes after which success is judged.
    """

    def __init__(self, config: CurriculumConfig, window: int) -> None:
        self._config, self._window = config, window
        self.share = config.start
        self._ended = self._fallen = 0

    @property
    def enabled(self) -> bool:
        """Whether there is anything to grow."""
        return self._config.start < 1.0

    def note(self, ended: int, fallen: int) -> None:
        """Count episodes that ended, ``fallen`` of them in a fall; judge a full window."""
        self._ended += ended
        self._fallen += fallen
        if not self.enabled or self._ended < self._window:
            return
        if 1.0 - self._fallen / self._ended >= self._config.success:
            self.share = min(1.0, self.share + self._config.growth)
        self._ended = self._fallen = 0
