"""Functions of postures, written out for a number of angles: any number, of which a robot need not be one yet."""

import numpy as np
import pytest

from mjbiped.engines.hybrid.tuples import tuples_of


@pytest.mark.parametrize("angles", [1, 2, 3, 5])
def test_states_are_taken_apart_as_their_order_says(angles: int) -> None:
    joints, own = min(angles, 2), 2
    functions = tuples_of(angles, joints, own)
    state = tuple(float(number) for number in range(2 * angles + own + joints))
    assert functions.q(state) == state[:angles]
    assert functions.dq(state) == state[angles : 2 * angles]
    assert functions.still(state) == (0.0,) * angles
    given = (1.0, 2.0, 3.0, 4.0)[: joints + own]
    assert functions.own(given) == given[joints:]
    dq = functions.dq(state)
    turning = np.diff(dq, prepend=0.0)[:joints]
    assert functions.powers(given, dq) == tuple(np.multiply(given[:joints], turning))


@pytest.mark.parametrize("angles", [1, 2, 3, 5])
def test_the_end_of_a_chain_is_the_sum_of_its_segments(angles: int) -> None:
    draw = np.random.default_rng(angles)
    (q, along, beside), slope = draw.uniform(-1.0, 1.0, (3, angles)), 0.1
    functions = tuples_of(angles, 1, 0)
    pose = functions.pose(tuple(q), slope)
    sines, cosines = np.sin(q + slope), np.cos(q + slope)
    expected = [along @ sines + beside @ cosines, along @ cosines - beside @ sines]
    assert functions.reached(along, beside, pose) == pytest.approx(expected, abs=1e-15)
