"""McGeer's machine with knees: how well its numbers are known."""

from dataclasses import replace

import numpy as np
import pytest

from mjbiped.gaits.kneed import find_kneed_gait
from scripts.validation.published import MCGEER_KNEED, MCGEER_KNEED_ROBOT, MCGEER_KNEED_SLOPE
from scripts.validation.round_knees import gait, multipliers


@pytest.mark.slow
def test_multipliers_of_three_numbers_are_those_of_four_but_for_zero() -> None:
    """By the finder's integration and by another one; both differentiate by 1e-4."""
    *three, none = multipliers()
    np.testing.assert_allclose(three, gait().multipliers, rtol=0, atol=1e-6)
    assert abs(none) < 1e-9


@pytest.mark.slow
def test_the_digits_of_the_shanks_offset_allow_what_is_claimed() -> None:
    def numbers(offset: float) -> np.ndarray:
        found = find_kneed_gait(replace(MCGEER_KNEED_ROBOT, shank_offset=offset), MCGEER_KNEED_SLOPE).multipliers
        return np.array([abs(found[0]), abs(np.angle(found[0])), found[2].real])

    claimed = [MCGEER_KNEED[name].tolerance for name in ("modulus", "angle", "real")]
    here = numbers(-0.010)
    for offset in (-0.011, -0.009):
        assert (np.abs(numbers(offset) - here) > 0.98 * np.array(claimed)).all()
