"""Survival statistics against closed forms, SciPy's own fit, and samples of a known distribution."""

import dataclasses
import math

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

import mjbiped
from controllers import PassiveController
from mjbiped.analysis.survival import Survival, ratio


def drawn(mean: float, walks: int, most: int, seed: int) -> Survival:
    """Walks that fall without memory: geometric numbers of steps."""
    steps = np.random.default_rng(seed).geometric(1.0 / mean, walks)
    return Survival(tuple(np.minimum(steps, most).tolist()), tuple((steps <= most).tolist()))


walks_of = st.lists(st.tuples(st.integers(1, 1000), st.booleans()), min_size=2, max_size=40)


@settings(max_examples=25, deadline=None)
@given(walks_of)
def test_the_mean_is_the_exponential_fit_of_greatest_likelihood(walks: list[tuple[int, bool]]) -> None:
    survival = Survival(*map(tuple, zip(*walks, strict=True)))
    if not survival.falls:
        assert survival.mean == math.inf
        return
    steps, fell = np.array(survival.steps, dtype=float), np.array(survival.fell)
    data = scipy.stats.CensoredData(steps[fell], right=steps[~fell])
    _, scale = scipy.stats.expon.fit(data, floc=0.0)
    # SciPy maximises the censored likelihood numerically, to about the root of its tolerance
    assert survival.mean == pytest.approx(scale, rel=1e-3)
    low, high = survival.interval
    assert low < survival.mean < high
    # 1 / (1 - eigenvalue) counts the step that fails, the mean does not
    assert 1.0 / (1.0 - survival.eigenvalue) == pytest.approx(survival.mean + 1.0, rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(walks_of)
def test_the_curve_is_the_product_of_the_shares_that_go_on(walks: list[tuple[int, bool]]) -> None:
    survival = Survival(*map(tuple, zip(*walks, strict=True)))
    at, share, low, high = survival.curve()
    expected = 1.0
    for step, got in zip(at[1:], share[1:], strict=True):
        going = sum(made >= step for made, _ in walks)
        fallen = sum(made == step and fell for made, fell in walks)
        expected *= 1.0 - fallen / going
        assert got == pytest.approx(expected, abs=1e-12)  # products of rounded quotients
    assert at[0] == 0.0
    assert (low <= share + 1e-12).all()
    assert (share <= high + 1e-12).all()
    assert (np.diff(share) <= 1e-12).all()


def test_the_interval_holds_the_mean_as_often_as_it_says() -> None:
    """400 studies of 20 walks: a binomial share of 0.95 has a standard error of 0.011; four of them are allowed."""
    mean, held = 120.0, 0
    for seed in range(400):
        low, high = drawn(mean, 20, 500, seed).interval
        held += low <= mean <= high
    assert held / 400 == pytest.approx(0.95, abs=0.044)


def test_without_a_fall_the_lower_end_is_that_of_no_event() -> None:
    survival = Survival((1000,) * 20, (False,) * 20)
    low, high = survival.interval
    assert (survival.mean, high) == (math.inf, math.inf)
    # no fall in T steps with a probability of exp(-T / mean) = 0.025
    assert low == pytest.approx(20_000 / -math.log(0.025), rel=1e-12)
    np.testing.assert_array_equal(survival.curve()[1], 1.0)


def test_ratios_of_paired_walks() -> None:
    worse = drawn(50.0, 60, 1000, 1)
    better = Survival(tuple(3 * steps for steps in worse.steps), worse.fell)
    # three times as many steps on each of the same grounds: paired, there is no spread at all
    assert ratio(better, worse) == pytest.approx((3.0, 3.0, 3.0), rel=1e-12)
    middle, low, high = ratio(drawn(500.0, 60, 1000, 2), worse)
    assert low < 10.0 < high
    assert low < middle < high
    # 95 % of a ratio whose logarithm deviates by sqrt(1/60 + 1/60)
    assert math.log(high / low) == pytest.approx(2.0 * 1.96 * math.sqrt(2.0 / 60.0), rel=0.2)
    never = Survival((1000,) * 60, (False,) * 60)
    assert ratio(never, worse) == (math.inf, never.interval[0] / worse.interval[1], math.inf)


def test_walks_that_did_not_fall_are_censored() -> None:
    outcomes = ["finished", "left the terrain", "fell", "stalled", "slipped", "diverged", "unresolved"]
    done = mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=5)
    survival = Survival.of([dataclasses.replace(done, outcome=outcome) for outcome in outcomes])
    assert survival.steps == (5,) * 7
    assert survival.fell == (False, False, True, True, True, True, True)


def test_what_is_no_set_of_walks_is_refused() -> None:
    with pytest.raises(mjbiped.InputError, match="at least one walk"):
        Survival((), ())
    with pytest.raises(mjbiped.InputError, match="got 2 walks and 1 ends"):
        Survival((1, 2), (True,))
    with pytest.raises(mjbiped.InputError, match="same grounds"):
        ratio(Survival((1,), (True,)), Survival((1, 2), (True, False)))


def test_the_transient_counts_neither_steps_nor_falls() -> None:
    survival = Survival((3, 10, 25, 1000), (True, True, True, False)).after(10)
    assert survival == Survival((0, 0, 15, 990), (False, True, True, False))
    assert survival.mean == 1005 / 2
    assert math.isnan(Survival((3,), (True,)).after(10).mean)


def test_eigenvalue_and_misfit_of_a_known_chain() -> None:
    """The first ten steps never fail, then one in 50 does: after them the eigenvalue is 0.98, and the curve fits."""
    ends = np.random.default_rng(5).geometric(0.02, 4000) - 1
    known = Survival(tuple((ends + 10).tolist()), (True,) * len(ends))
    settled = known.after(10)
    # falls in 200 000 steps: a standard error of 1 / sqrt(4000) of 0.02; four of them
    assert settled.eigenvalue == pytest.approx(0.98, abs=4 * 0.02 / math.sqrt(4000))
    # Kolmogorov's distance of 4000 samples is below 1.95 / sqrt(4000) with a probability of 0.999
    assert settled.misfit < 1.95 / math.sqrt(4000) < known.misfit
