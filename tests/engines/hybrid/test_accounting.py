"""The book-keeping of absolute work: no change of a power's sign is missed, however short it lasts."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController
from mjbiped.engines.hybrid.accounting import _turns
from mjbiped.numerics.dormand_prince import STAGE_PLACES, TESTED_STAGES


def rates(power: np.polynomial.Polynomial) -> list[float]:
    """What a step leaves of a power: that of its stages, of which four are not kept."""
    return [float(power(place)) if k in (0, *TESTED_STAGES) else 0.0 for k, place in enumerate(STAGE_PLACES)]


@given(st.floats(0.03, 0.97), st.floats(1e-3, 0.2), st.floats(-3.0, 3.0), st.sampled_from([-1.0, 1.0]))
def test_two_changes_of_sign_between_two_stages_are_seen(middle: float, width: float, tilt: float, sign: float) -> None:
    first, last = middle - width / 2.0, middle + width / 2.0
    assume(first > 0.0 and last < 1.0)
    dip = np.polynomial.Polynomial.fromroots([first, last])
    shape = dip + 0.02 * tilt * dip**2
    assert _turns(rates(sign * shape), 1, 0, 0.1)


@given(st.floats(0.3, 3.0), st.floats(-1.0, 1.0))
def test_a_power_far_from_zero_does_not_turn(least: float, lean: float) -> None:
    power = np.polynomial.Polynomial([least + 1.0 + abs(lean), lean, 1.0])
    assert not _turns(rates(power), 1, 0, 0.1)


@pytest.mark.parametrize("clearance", [0.04, pytest.param(0.07, marks=pytest.mark.slow)])
def test_absolute_work_is_that_of_a_fine_quadrature(clearance: float) -> None:
    # in the first step of either an integration step of some 0.1 s holds a dip of the ankle's power that lasts 0.01 s
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_reference(robot, clearance=clearance), replanning="additive")
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1, sample_period=2e-5)
    end = walk.touchdowns["time"][0]
    time, torque, rate = (np.asarray(walk.samples[name]) for name in ("time", "torque", "dq"))
    within = time < end
    power = torque * np.column_stack([rate[:, 0], rate[:, 1] - rate[:, 0]])
    expected = 0.0
    for each in np.abs(power[within]).T:
        expected += np.trapezoid(each, time[within]) + each[-1] * (end - time[within][-1])
    # trapezia of 20 us leave 1e-8 of it, and the last piece, of less than that, 1e-8 more; a missed dip is 1e-4
    assert walk.touchdowns["work_absolute"][0] == pytest.approx(expected, rel=1e-6)
