"""How well a share is known from a count."""

import math

Z = 1.959963984540054  # 97.5 % quantile of the normal distribution


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of the probability behind ``successes`` out of ``count``.

    Its ends are the p with |successes / count − p| = z √(p (1 − p) / count), z being ``Z``
    (E. B. Wilson, 1927). The draws are taken as independent.

    Raises:
        ValueError: the count is not positive, or smaller than the successes.
    """
    if not 0 <= successes <= count or count == 0:
        raise ValueError(f"expected 0 to {count} of at least 1, found {successes}")
    return _lower(successes, count), 1.0 - _lower(count - successes, count)


def _lower(successes: int, count: int) -> float:
    """Exactly 0 for no success."""
    spread = Z * math.sqrt(Z**2 + 4 * successes * (1 - successes / count))
    return (2 * successes + Z**2 - spread) / (2 * (count + Z**2))
