"""Gaits of any period: fixed points of the n-fold return map, their multipliers, and branches of them."""

import math

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import GaitError
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles.periodic import find_periodic_gait, first_gait, follow
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot

TABLE_ONE = Compass()


WITH_KNEES = [
    (mjbiped.KneedBiped(), math.radians(2.5)),
    (mjbiped.KneedBiped(sole=(0.1, 0.1)), math.radians(2.5)),
    (mjbiped.RoundKneed(), 0.0456),
]


@pytest.mark.parametrize(
    ("robot", "slope"),
    [(TABLE_ONE, math.radians(2.0)), *(pytest.param(*case, marks=pytest.mark.slow) for case in WITH_KNEES)],
)
def test_period_one_is_the_gait_of_the_boundary_value_problem(robot: Robot, slope: float) -> None:
    """Two programs: SciPy's integrator and root finder, and the compiled return map with Newton's method."""
    gait, found = passive_gait_of(robot, slope), first_gait(robot, slope)
    # the root finder's tolerance is 1e-12 in scaled numbers; the shanks of round feet move fast
    exact = 1e-9 if robot.knee_opens else 1e-10 if len(robot.angles) == 3 else 1e-11
    np.testing.assert_allclose(found.states[0], gait.start, rtol=0, atol=exact)
    assert found.periods[0] == pytest.approx(gait.period, abs=exact)
    rolled = robot.radius * (gait.end[0] - gait.start[0])  # the gait's step length counts the rolling of round feet
    assert found.step_lengths[0] == pytest.approx(gait.step_length - rolled, abs=exact)
    # differences of fourth order in both, with different steps
    np.testing.assert_allclose(np.sort_complex(found.multipliers), np.sort_complex(gait.multipliers), rtol=0, atol=1e-6)
    assert found.doubling == pytest.approx(np.prod(1 + gait.multipliers).real, abs=1e-6)


def test_branch_ends_where_gaits_end() -> None:
    """Table I has none on 28 degrees, as `find_passive_gait` says."""
    found = list(follow(first_gait(TABLE_ONE, math.radians(5)), np.radians([20.0, 28.0, 29.0]).tolist()))
    assert len(found) == 1


@pytest.mark.slow
def test_a_landing_on_a_bent_knee_is_off_the_section() -> None:
    """Where the swing leg rests at first, the foot comes down before the knee is straight."""
    robot, slope = mjbiped.KneedBiped(), math.radians(2.5)
    bent = robot.after_touchdown(np.array([[-0.2, passive_gait_of(robot, slope).start[3], 0.0]]))
    landed = ReturnMap(robot, slope).walk(bent[0], 1)
    assert landed.outcome == "walking"
    assert abs(landed.states[0, :2].sum()) > 1e-6
    with pytest.raises(GaitError, match="falls or stalls"):
        find_periodic_gait(robot, slope, bent)
