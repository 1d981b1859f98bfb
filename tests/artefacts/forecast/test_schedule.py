"""The share done and the time left, on schedules that are known by hand and on a recorded run."""

import pytest

from slider.artefacts.forecast.schedule import Forecast, Work


def chain_and_fillers(cores: int) -> Forecast:
    """A chain of 10, 20 and 30 s beside four jobs of 15 s."""
    chain = {
        "a": Work("chain", 10.0, (), 1),
        "b": Work("chain", 20.0, ("a",), 1),
        "c": Work("chain", 30.0, ("b", "there already"), 1),
    }
    return Forecast(chain | {f"f{k}": Work("filler", 15.0) for k in range(4)}, cores)


@pytest.mark.parametrize(("cores", "left"), [(1, 120.0), (2, 60.0), (3, 60.0), (7, 60.0)])
def test_the_time_left_is_that_of_the_schedule(cores, left):
    assert chain_and_fillers(cores).left(0.0) == pytest.approx(left)


def test_the_urgent_job_starts_first_and_one_that_does_not_fit_holds_nobody_up():
    late = {"a": Work("a", 10.0, (), 0), "b": Work("b", 30.0, (), 1)}
    assert Forecast(late | {"c": Work("c", 20.0, (), 0)}, 2).left(0.0) == pytest.approx(30.0)
    wide = {"one": Work("one", 10.0), "wide": Work("wide", 5.0, (), 1, threads=2)}
    found = Forecast(wide | {"runs": Work("runs", 8.0)}, 2)
    found.begin("runs", 0.0)
    assert found.left(0.0) == pytest.approx(15.0)  # `one` takes the free core, then `wide` both


def test_cores_that_a_job_uses_beside_its_own_are_not_free():
    works = {"wide": Work("wide", 10.0, uses=1.5), "a": Work("a", 10.0), "b": Work("b", 1.0)}
    assert Forecast(works, 2).left(0.0) == pytest.approx((15.0 + 10.0 + 1.0) / 2)
    assert Forecast(works, 3).left(0.0) == pytest.approx(10.0)


def test_a_running_job_counts_by_its_time_and_by_its_own_words():
    found = chain_and_fillers(1)
    found.begin("a", 100.0)
    assert found.left(104.0) == pytest.approx(116.0)
    assert found.share(104.0) == pytest.approx(4.0 / 120.0)
    found.shares = {"a": 0.2}  # 4 s were a fifth of it
    assert found.left(104.0) == pytest.approx(16.0 + 110.0)


def test_a_slower_machine_is_noticed_by_kind_and_by_all():
    found = chain_and_fillers(1)
    now = 0.0
    for recipe in ("f0", "f1", "f2"):
        found.begin(recipe, now)
        found.end(recipe, now := now + 30.0)
    others = 2.0**0.5  # one kind of two that is twice as slow, beside the expectation
    own = (90.0 + 20.0 * others) / (45.0 + 20.0)
    chain = (0.0 + 20.0 * others) / 20.0
    assert found.left(now) == pytest.approx(15.0 * own + 60.0 * chain)


def test_an_earlier_result_says_nothing_of_the_pace():
    found = chain_and_fillers(1)
    found.begin("f0", 0.0)
    found.end("f0", 0.5, reused=True)
    assert found.left(0.5) == pytest.approx(105.0)


def test_the_share_never_falls_and_is_whole_only_at_the_end():
    found = chain_and_fillers(1)
    now, shares = 0.0, []
    for recipe, took in (("f0", 15), ("a", 40), ("b", 200), ("f1", 1), ("f2", 90), ("f3", 2)):
        found.begin(recipe, now)
        found.end(recipe, now := now + took)
        shares.append(found.share(now))
    assert shares == sorted(shares)
    assert shares[-1] < 1.0
    found.begin("c", now)
    found.end("c", now + 1.0)
    assert found.share(now + 1.0) == 1.0
    assert (found.done, found.total) == (7, 7)
    assert found.left(now + 1.0) == 0.0
    assert not found.awaits(["a", "c", "there already"])
