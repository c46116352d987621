"""The torque that a sole transmits: the centre of pressure stays on it, and nothing is taken that need not be."""

import math

from hypothesis import given
from hypothesis import strategies as st

from mjbiped.rules.sole import bounded, bounded_by_own_force

ends = st.floats(0.0, 0.5)
torques = st.floats(-1e3, 1e3)
ROUNDING = 1e-12  # of the greater of torque and force times length: a few operations on numbers of that size


@given(torques, st.floats(-500.0, 500.0), ends, ends)
def test_the_centre_of_pressure_stays_on_the_sole(torque: float, force: float, behind: float, ahead: float) -> None:
    given_ = bounded(torque, force, behind, ahead)
    pressed = max(force, 0.0)
    assert -ahead * pressed <= given_ <= behind * pressed
    assert given_ == torque or given_ in (-ahead * pressed, behind * pressed)
    if -ahead * pressed <= torque <= behind * pressed:
        assert given_ == torque
    assert bounded(torque, force, math.inf, math.inf) == torque  # without a sole


@given(torques.filter(lambda torque: abs(torque) > 1e-6), st.floats(-100.0, 500.0), st.floats(-1.5, 1.5), ends, ends)
def test_the_bound_is_of_its_own_force(torque: float, rest: float, gain: float, behind: float, ahead: float) -> None:
    """Of the one that the torque makes.

    Of a force rest + gain τ; the gain is at most one over the sole's length, where a torque lifts what it needs.
    """
    transmitted, force = bounded_by_own_force(torque, rest + gain * torque, rest, behind, ahead)
    size = ROUNDING * (abs(torque) * (1.0 + abs(gain)) + abs(rest) + 1.0)
    assert abs(force - (rest + gain * transmitted)) <= size
    if rest <= 0.0:
        assert transmitted == 0.0
        return
    assert -ahead * force - size <= transmitted <= behind * force + size
    assert transmitted == 0.0 or math.copysign(1.0, transmitted) == math.copysign(1.0, torque)
    assert abs(transmitted) <= abs(torque)
    if transmitted != torque:  # no more would be possible
        end = behind if torque > 0.0 else -ahead
        assert abs(transmitted - end * force) <= size
