"""The integrator, written out for a number of components: its order, its error estimate and its dense output."""

import inspect
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853

from mjbiped.numerics.dormand_prince import (
    POWERS,
    STAGE_PLACES,
    STAGES,
    STAGES_WITH_DENSE,
    dense_at,
    dense_rate_at,
    unrolled,
)

Numbers = list[float]


def pendulum(stiffness: float, t: float, state: tuple[float, ...]) -> tuple[float, ...]:
    """A driven, damped pendulum, and the integral of its rate's square."""
    return (state[1], math.cos(3.0 * t) - stiffness * math.sin(state[0]) - 0.1 * state[1], state[1] * state[1])


def one_step(h: float, t: float, y: Sequence[float], tolerance: float = 1e-9) -> tuple[Numbers, Numbers, float]:
    """State after one step, its stages, and the estimated error."""
    scheme = unrolled(3, untested=1, arguments=("stiffness",))
    k, out = [0.0] * (3 * STAGES_WITH_DENSE), [0.0] * 3
    scheme.begin(pendulum, 9.0, t, list(y), k)
    error = scheme.step(pendulum, 9.0, t, h, list(y), k, out, tolerance, 2.0)
    return out, k, error


def scipy_step(h: float, t: float, y: Sequence[float]) -> Any:
    solver = DOP853(
        lambda t, y: np.array(pendulum(9.0, t, tuple(y))),
        t,
        np.array(y),
        t_bound=t + 9 * h,
        first_step=h,
        rtol=1e-2,
        atol=1e-2,
    )
    solver.step()
    assert solver.t == pytest.approx(t + h, abs=1e-15)  # taken in one step
    return solver


@pytest.mark.parametrize("h", [0.01, 0.1, 0.2])
def test_step_is_that_of_scipy(h: float) -> None:
    """The same method by another implementation: SciPy's step and its dense output."""
    y, t = (0.3, -0.5, 0.2), 0.7
    out, k, _ = one_step(h, t, y)
    theirs = scipy_step(h, t, y)
    assert out == pytest.approx(theirs.y.tolist(), abs=2e-15)  # rounding: sums in another order
    dense = [0.0] * (3 * POWERS)
    unrolled(3, untested=1, arguments=("stiffness",)).dense(pendulum, 9.0, t, h, list(y), k, out, dense)
    output = theirs.dense_output()
    for x in (0.0, 0.2, 0.5, 0.9, 1.0):
        ours = [dense_at(dense, 3, c, y[c], x) for c in range(3)]
        assert ours == pytest.approx(output(t + x * h).tolist(), abs=5e-15)
    # derivative by the share of the step: by central differences of the polynomial, error some 1e-16 / 1e-5
    numerical = (dense_at(dense, 3, 0, y[0], 0.5 + 1e-5) - dense_at(dense, 3, 0, y[0], 0.5 - 1e-5)) / 2e-5
    assert dense_rate_at(dense, 3, 0, 0.5) == pytest.approx(numerical, abs=1e-9)


def test_order_of_the_step_is_eight() -> None:
    """Halving the step divides the error over a fixed time by 2^8, until rounding."""

    def at_the_end(steps: int) -> Numbers:
        y, t, h = [0.3, -0.5, 0.0], 0.0, 2.0 / steps
        for _ in range(steps):
            y, t = one_step(h, t, y)[0], t + h
        return y

    exact = np.array(at_the_end(400))
    errors = [np.abs(np.array(at_the_end(steps)) - exact).max() for steps in (8, 16, 32)]
    # the error's next term, of order 9, is as great as the leading one here; the last error is 100 times rounding
    assert 8.0 <= math.log2(errors[0] / errors[1]) < 9.0
    assert 8.0 <= math.log2(errors[1] / errors[2]) < 9.0


def test_estimated_error_scales_with_tolerance_and_leaves_the_untested_out() -> None:
    y = (0.3, -0.5, 0.2)
    coarse, fine = (one_step(0.2, 0.0, y, tolerance)[2] for tolerance in (1e-6, 1e-9))
    assert fine == pytest.approx(1e3 * coarse, rel=1e-12)  # the estimate is homogeneous in 1 / tolerance
    # another start of the integral, which enters no rate and is not tested
    assert one_step(0.2, 0.0, (0.3, -0.5, 7.0))[2] == one_step(0.2, 0.0, y)[2]
    exact = np.array(y)
    for _ in range(100):
        exact = np.array(one_step(0.002, 0.002 * _, exact.tolist())[0])
    error = np.abs(np.array(one_step(0.2, 0.0, y)[0]) - exact)[:2].max()
    assert error < coarse * 1e-6 * 1.5  # an estimate of order 7 or less is above the step's error of order 8


def nothing(t: float, state: tuple[float, ...]) -> tuple[float, ...]:
    del t, state
    return (0.0,)


def test_a_state_at_rest_has_no_error() -> None:
    assert one_step(0.1, 0.0, (0.0, 0.0, 0.0))[2] > 0.0
    scheme = unrolled(1, untested=0, arguments=())
    k = [0.0] * STAGES_WITH_DENSE
    assert scheme.step(nothing, 0.0, 0.1, [1.0], k, [0.0], 1e-9, 1.0) == 0.0


def test_source_can_be_read() -> None:
    """A traceback in a law goes through the written-out step: Python must find its lines."""
    scheme = unrolled(2, untested=0, arguments=("a", "b"))
    assert inspect.getsource(scheme.step).startswith("def step(rates, a, b, t, h, y, k, out, tolerance, tested):")
    assert inspect.getsource(scheme.step).count("rates(") == STAGES


def test_the_places_of_the_stages_are_scipys() -> None:
    assert (*DOP853.C[:STAGES], 1.0) == STAGE_PLACES
