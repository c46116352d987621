"""The integrator: its order, its error estimate and its dense output, against SciPy's."""

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853

from mjbiped.dynamics import integrate

Numbers = list[float]


def pendulum(stiffness: float, t: float, state: Sequence[float]) -> Numbers:
    """A driven, damped pendulum, and the integral of its rate's square."""
    return [state[1], math.cos(3.0 * t) - stiffness * math.sin(state[0]) - 0.1 * state[1], state[1] * state[1]]


def rates(c: Any, w: Any, t: float, y: Numbers, dy: Numbers) -> None:
    w.asked.append(t)
    dy[:] = pendulum(9.0, t, y)


def one_step(h: float, t: float, y: Sequence[float], tolerance: float = 1e-9) -> tuple[Numbers, Any, float]:
    """State after one step, the blocks that the integrator works on, and the estimated error."""
    n = len(y)
    c = SimpleNamespace(size=n, judged=n - 1, tolerance=tolerance)
    room = {"out": [0.0] * n, "spare": [0.0] * n}
    k, powers = [[0.0] * n for _ in range(integrate.STAGES_WITH_DENSE)], [[0.0] * n for _ in range(integrate.POWERS)]
    w = SimpleNamespace(y=list(y), k=k, dense=powers, asked=[], **room)
    rates(c, w, t, w.y, w.k[0])
    error = integrate.step(rates, c, w, t, h)
    return w.out, (c, w), error


def scipy_step(h: float, t: float, y: Sequence[float]) -> Any:
    terms: Any = {"t_bound": t + 9 * h, "first_step": h, "rtol": 1e-2, "atol": 1e-2}
    solver = DOP853(lambda t, y: np.array(pendulum(9.0, t, tuple(y))), t, np.array(y), **terms)
    solver.step()
    assert solver.t == pytest.approx(t + h, abs=1e-15)  # taken in one step
    return solver


@pytest.mark.parametrize("h", [0.01, 0.1, 0.2])
def test_step_is_that_of_scipy(h: float) -> None:
    """The same method by another implementation: SciPy's step and its dense output."""
    y, t = (0.3, -0.5, 0.2), 0.7
    out, (c, w), _ = one_step(h, t, y)
    theirs = scipy_step(h, t, y)
    assert out == pytest.approx(theirs.y.tolist(), abs=2e-15)  # rounding: sums in another order
    integrate.dense(rates, c, w, t, h)
    output = theirs.dense_output()
    for x in (0.0, 0.2, 0.5, 0.9, 1.0):
        ours = [integrate.value_at(c, w, k, x) for k in range(3)]
        assert ours == pytest.approx(output(t + x * h).tolist(), abs=5e-15)
    # derivative by the share of the step: by central differences of the polynomial, error some 1e-16 / 1e-5
    numerical = (integrate.value_at(c, w, 0, 0.5 + 1e-5) - integrate.value_at(c, w, 0, 0.5 - 1e-5)) / 2e-5
    assert integrate.rate_at(c, w, 0, 0.5) == pytest.approx(numerical, abs=1e-9)


def test_the_places_of_the_stages_are_scipys() -> None:
    _, (_, w), _ = one_step(1.0, 0.0, (0.0, 0.0, 0.0))
    places = np.append(DOP853.C, 1.0)
    assert w.asked == pytest.approx([0.0, *places[1 : integrate.STAGES + 1]], abs=0.0)
    assert tuple(places[list(integrate.IN_ORDER)]) == integrate.PLACES
    assert list(integrate.IN_ORDER) == sorted(integrate.IN_ORDER, key=lambda stage: places[stage])


def test_the_estimate_is_that_of_scipys_formulas() -> None:
    y, t, h, tolerance = (0.3, -0.5, 0.2), 0.7, 0.2, 1e-6
    out, (c, w), error = one_step(h, t, y, tolerance)
    judged = np.array(w.k[: integrate.STAGES + 1])[:, : c.judged]
    scale = tolerance * (1.0 + np.maximum(np.abs(y), np.abs(out)))[: c.judged]
    third, fifth = (np.sum((formula @ judged / scale) ** 2) for formula in (DOP853.E3, DOP853.E5))
    # sums of some ten terms that cancel to 1e-3 of the largest
    assert error == pytest.approx(h * fifth / math.sqrt((fifth + 0.01 * third) * c.judged), rel=1e-9)
