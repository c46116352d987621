"""Impacts of the biped with knees on round feet: what they conserve, by the places of its masses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from simulations import hybrid_run

from mjbiped.control.controller import Unpowered
from mjbiped.dynamics.modes import FREE, LOCKED, RESTING
from mjbiped.engines.hybrid.impacts import strike_knee
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import exchange_legs
from mjbiped.engines.hybrid.state import Constants, State
from mjbiped.robots.chain import Array
from mjbiped.robots.round import RoundKneed
from mjbiped.terrain.terrain import Terrain

ROBOT = RoundKneed(hip_mass=3.0, stop_angle=0.3, shank_offset=0.03, foot_radius=0.17, thigh_length=0.5)

FOUR = st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=4).map(np.array)
RATES = st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4).map(np.array)


def levers() -> NDArray[np.complex128]:
    """Levers x + i z of shank, thigh, hip, thigh, shank and swing knee over the stance foot's arc, by the part's angle.

    A part that is upright has its lever's real part upward and the imaginary one backward: a shank's centre of mass is
    ahead of its line, which is the way from the knee to the arc's centre.
    """
    arc, thigh = ROBOT.shank_length - ROBOT.foot_radius, ROBOT.thigh_length
    shank = -ROBOT.shank_centre - 1j * ROBOT.shank_offset
    return np.array(
        [
            [arc + shank, 0.0, 0.0, 0.0],
            [arc, thigh - ROBOT.thigh_centre, 0.0, 0.0],
            [arc, thigh, 0.0, 0.0],
            [arc, thigh, -ROBOT.thigh_centre, 0.0],
            [arc, thigh, -thigh, shank],
            [arc, thigh, -thigh, 0.0],
        ]
    )


def parts_at(q: Array) -> Array:
    """Angles of the parts themselves, by cosines' law in the triangle of hip, knee and arc's centre."""
    arc, thigh = ROBOT.shank_length - ROBOT.foot_radius, ROBOT.thigh_length
    line = math.sqrt(arc**2 + thigh**2 + 2.0 * arc * thigh * math.cos(ROBOT.stop_angle))
    lean = math.acos((thigh**2 + line**2 - arc**2) / (2.0 * thigh * line))  # of the thigh, forward
    shank = lean - ROBOT.stop_angle
    parts: Array = q + np.array([shank, lean, lean, shank])
    return parts


def moving(q: Array, dq: Array) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Places and speeds of the points of `levers`, x + i z, on level ground on which the stance foot rolls."""
    angles = parts_at(q)
    up = 1j * np.exp(-1j * angles)
    return ROBOT.foot_radius * angles[0] + levers() @ up, ROBOT.foot_radius * dq[0] + levers() @ (-1j * dq * up)


def state_of(locked: int, y: Array) -> tuple[Constants, State]:
    """The robot on level ground, in a state, as its knee is."""
    run = hybrid_run(
        Unpowered(), Terrain.level(), robot=ROBOT, q=y[:3].tolist(), dq=y[3:].tolist(), steps=1, compile=False
    )
    c, w = run.constants, run.state
    w.locked, w.before = locked, math.inf
    enter_mode(c, w)
    return c, w


def spins(q: Array, dq: Array, about: complex) -> Array:
    """Angular momentum of each part about a point, kg m^2/s: shank, thigh, hip, thigh, shank from the stance foot."""
    places, speeds = (each[:5] for each in moving(q, dq))
    masses = np.array([ROBOT.shank_mass, ROBOT.thigh_mass, ROBOT.hip_mass, ROBOT.thigh_mass, ROBOT.shank_mass])
    own = np.array([ROBOT.shank_inertia, ROBOT.thigh_inertia, 0.0, ROBOT.thigh_inertia, ROBOT.shank_inertia])
    turning: Array = own * dq[[0, 1, 1, 2, 3]] - masses * ((places - about).conj() * speeds).imag
    return turning


def lowest(q: Array) -> complex:
    """The stance foot's contact: the arc's centre has rolled by the parts' own angle."""
    return complex(ROBOT.foot_radius * parts_at(q)[0], -ROBOT.foot_radius)


@given(st.floats(0.05, 0.5), RATES)
def test_a_heel_strike_conserves_what_no_impulse_acts_on(half: float, dq: Array) -> None:
    """The robot's momentum about its new contact, the departing leg's about the hip, its shank's about the knee.

    The last one where the knee opens; else the stop pushes the shank back, and both move as one.
    """
    before, rates = np.array([half, half, -half, -half]), dq[[0, 0, 1, 1]]
    after, (c, w) = -before, state_of(LOCKED, np.array([half, -half, -half, dq[0], dq[1], dq[1]]))
    exchange_legs(c, w, 0.0)
    new = w.y[3:6]
    assert w.y[:3] == [-half, half, half]
    np.testing.assert_array_equal(new, ROBOT.rates_after_touchdown(np.array([half, -half, -half]), dq[[0, 1, 1]]))
    turning = np.array([new[0], new[0], new[1], new[2]])
    _, _, hip, _, last, knee = moving(after, turning)[0]
    # the same places, counted from the old stance foot's arc
    shift = moving(before, rates)[0][0] - last
    contact = lowest(after)
    assert abs(shift.imag) < 1e-12
    total = spins(before, rates, contact + shift).sum()
    assert total == pytest.approx(spins(after, turning, contact).sum(), rel=1e-9, abs=1e-9)
    leg = spins(before, rates, hip + shift)[:2].sum()
    assert leg == pytest.approx(spins(after, turning, hip)[3:].sum(), rel=1e-9, abs=1e-9)
    was, now = spins(before, rates, knee + shift)[0], spins(after, turning, knee)[4]
    if w.locked == FREE:
        assert new[2] > new[1]
        assert now == pytest.approx(was, rel=1e-9, abs=1e-9)
    else:
        assert w.locked == RESTING
        assert new[2] == pytest.approx(new[1], abs=1e-12)
        assert now - was > -1e-9  # the stop turns the shank back, as flexion does


@given(FOUR, RATES)
def test_a_knee_strike_conserves_what_no_impulse_acts_on(q: Array, dq: Array) -> None:
    """The robot's momentum about its contact, and the swing leg's about the hip."""
    four, before = q[[0, 0, 1, 1]], dq[[0, 0, 1, 2]]
    c, w = state_of(FREE, np.array([q[0], q[1], q[1], *dq[:3]]))
    strike_knee(c, w)
    assert w.locked == LOCKED
    assert w.y[4] == pytest.approx(w.y[5], abs=1e-12)
    after = np.array(w.y)[[3, 3, 4, 4]]
    np.testing.assert_allclose(ROBOT.knee_impact(w.y[:3], dq[:3])[1], w.y[3:5], rtol=1e-10, atol=1e-10)
    hip = moving(four, before)[0][2]
    for about, parts in ((lowest(four), slice(None)), (hip, slice(3, None))):
        left = spins(four, before, about)[parts].sum()
        assert left == pytest.approx(spins(four, after, about)[parts].sum(), rel=1e-9, abs=1e-9)
