"""Wilson's interval against its definition, published values and its edges."""

import math

import pytest

from slider.evaluation.proportions import Z, wilson


@pytest.mark.parametrize(
    ("successes", "count", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),  # Newcombe 1998, Statistics in Medicine 17, table I, method 3
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_published_values(successes, count, low, high):
    assert wilson(successes, count) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize(("successes", "count"), [(1, 3), (50, 100), (997, 1000)])
def test_the_ends_are_z_standard_errors_away(successes, count):
    for end in wilson(successes, count):
        error = math.sqrt(end * (1 - end) / count)
        assert abs(successes / count - end) == pytest.approx(Z * error)


@pytest.mark.parametrize("count", [1, 7, 100, 1000])
def test_none_and_all_have_one_exact_end(count):
    """The other one is z² / (count + z²) away."""
    far = Z**2 / (count + Z**2)
    assert wilson(0, count)[0] == 0.0
    assert wilson(0, count)[1] == pytest.approx(far)
    assert wilson(count, count)[1] == 1.0
    assert wilson(count, count)[0] == pytest.approx(1 - far)


def test_what_is_no_share_is_refused():
    for successes, count in ((0, 0), (3, 2), (-1, 2)):
        with pytest.raises(
            ValueError, match=f"^expected 0 to {count} of at least 1, found {successes}$"
        ):
            wilson(successes, count)
