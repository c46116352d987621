"""The return map of knees on round feet, whose heel strike bends the departing knee."""

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import InputError
from mjbiped.limit_cycles.basin import Fate, basin_of_attraction
from mjbiped.limit_cycles.periodic import first_gait
from mjbiped.limit_cycles.return_map import ReturnMap

ROBOT, SLOPE = mjbiped.RoundKneed(), 0.0456


def test_the_knee_may_bend_at_once_but_not_forwards() -> None:
    with pytest.raises(InputError, match="the swing leg is straight"):
        ReturnMap(ROBOT, SLOPE).walk([-0.3, 0.3, 0.3, 1.0, 0.5, 0.4], 1)
    with pytest.raises(InputError, match="the swing leg is straight"):
        ReturnMap(mjbiped.KneedBiped(), SLOPE).walk([-0.3, 0.3, 0.3, 1.0, 0.5, 0.6], 1)


@pytest.mark.slow
def test_its_gait_and_its_multipliers_are_the_finders() -> None:
    """SciPy's integration, differentiated by 1e-4, and the engine's own, by other differences."""
    gait, found = mjbiped.find_kneed_gait(ROBOT, SLOPE), first_gait(ROBOT, SLOPE)
    np.testing.assert_allclose(found.states[0], gait.start, rtol=0, atol=1e-9)
    assert found.periods[0] == pytest.approx(gait.period, abs=1e-10)
    np.testing.assert_allclose(np.sort_complex(found.multipliers), np.sort_complex(gait.multipliers), rtol=0, atol=1e-6)


@pytest.mark.slow
def test_what_begins_near_the_gait_settles_on_it() -> None:
    gait = mjbiped.find_kneed_gait(ROBOT, SLOPE)
    near = gait.start[3] * np.array([0.3, 0.99, 1.01]), gait.start[4] + np.array([-0.05, 0.0, 0.05])
    fates = basin_of_attraction(ROBOT, SLOPE, stance_rates=near[0], swing_rates=near[1]).fates
    assert (fates[:, 1:] == Fate.SETTLED).all()
    assert (fates[:, 0] == Fate.FELL).all()
