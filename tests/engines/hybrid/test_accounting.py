"""The book-keeping of a step: no change of a power's sign is missed, and all that is kept is what samples say."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.engines.hybrid.accounting import _total_variation

ONE: Any = SimpleNamespace(size=1)


def test_absolute_work_is_that_of_a_fine_quadrature() -> None:
    # in the first step of either an integration step of some 0.1 s holds a dip of the ankle's power that lasts 0.01 s
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_reference(robot, clearance=0.04), replanning="additive")
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


@pytest.mark.parametrize("turn", [0.03, 0.4, 0.97])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_turn_counts_in_the_first_and_in_the_last_sixteenth_of_a_step_too(turn: float, sign: float) -> None:
    """The work turn^2 - (x - turn)^2 rises by turn^2, and falls by (1 - turn)^2; in Hermite's form a x + x (1 - x)."""
    a = 2.0 * turn - 1.0
    dense = [[sign * a], [sign], *[[0.0]] * 5]
    w: Any = SimpleNamespace(y=[0.0], out=[sign * a], dense=dense)
    assert _total_variation(ONE, w, 0) == pytest.approx(turn**2 + (1.0 - turn) ** 2, rel=1e-9)
