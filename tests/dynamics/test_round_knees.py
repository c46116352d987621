"""The equations of the biped with knees on round feet: against SymPy's derivation from the places of its masses."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from lagrange import lagrange
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
RELATIVE, ABSOLUTE = 1e-12, 1e-12
"""Rounding of some hundred operations on terms of the order of 10."""

FOUR = st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=4).map(np.array)
RATES = st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4).map(np.array)


@cache
def derived() -> dict[str, Callable[..., object]]:
    """What follows by Lagrange's equations, as functions of angles, rates and slope.

    The angles are those of the parts themselves from the vertical: stance shank and thigh, swing thigh and shank. The
    robot's own differ from them by constants. The stance foot's lowest point rolls; a shank's centre of mass is ahead
    of its line, which is the way from the knee to the arc's centre.
    """
    q, dq, slope = sp.Matrix(sp.symbols("q:4")), sp.Matrix(sp.symbols("dq:4")), sp.Symbol("slope")
    r, arc = ROBOT.foot_radius, ROBOT.shank_length - ROBOT.foot_radius

    def up(angle: sp.Expr) -> sp.Matrix:
        return sp.Matrix([sp.sin(angle), sp.cos(angle)])

    def ahead(angle: sp.Expr) -> sp.Matrix:
        return sp.Matrix([sp.cos(angle), -sp.sin(angle)])

    centre = r * q[0] * sp.Matrix([sp.cos(slope), -sp.sin(slope)])
    knee = centre + arc * up(q[0])
    hip = knee + ROBOT.thigh_length * up(q[1])
    other = hip - ROBOT.thigh_length * up(q[2])
    end = other - arc * up(q[3])
    shank, thigh = (ROBOT.shank_mass, ROBOT.shank_inertia), (ROBOT.thigh_mass, ROBOT.thigh_inertia)
    parts = [
        (*shank, dq[0], knee - ROBOT.shank_centre * up(q[0]) + ROBOT.shank_offset * ahead(q[0])),
        (*thigh, dq[1], hip - ROBOT.thigh_centre * up(q[1])),
        (ROBOT.hip_mass, 0, 0, hip),
        (*thigh, dq[2], hip - ROBOT.thigh_centre * up(q[2])),
        (*shank, dq[3], other - ROBOT.shank_centre * up(q[3]) + ROBOT.shank_offset * ahead(q[3])),
    ]
    expressions = {
        **lagrange(q, dq, parts, ROBOT.gravity),
        "end": end - centre,
        "joints": sp.Matrix.hstack(hip, other),
        "places": sp.Matrix.hstack(*(x for *_, x in parts)),
        "speeds": sp.Matrix.hstack(*(x.jacobian(q) * dq for *_, x in parts)),
    }
    return {name: sp.lambdify((q, dq, slope), expression) for name, expression in expressions.items()}


def parts_at(q: Array, slope: float) -> Array:
    """Angles of the parts themselves, by cosines' law in the triangle of hip, knee and arc's centre."""
    arc, thigh = ROBOT.shank_length - ROBOT.foot_radius, ROBOT.thigh_length
    line = math.sqrt(arc**2 + thigh**2 + 2.0 * arc * thigh * math.cos(ROBOT.stop_angle))
    lean = math.acos((thigh**2 + line**2 - arc**2) / (2.0 * thigh * line))  # of the thigh, forward
    shank = lean - ROBOT.stop_angle
    parts: Array = q + np.array([shank, lean, lean, shank]) + slope
    return parts


def expected(name: str, q: Array, dq: Array, slope: float) -> Array:
    return np.asarray(derived()[name](parts_at(q, slope), dq, slope), dtype=np.float64).squeeze()


def state_of(locked: int, slope: float, y: Array, *, sliding: bool = False) -> tuple[Constants, State]:
    """The robot on a slope, in a state, as its knee is."""
    run = hybrid_run(
        Unpowered(), Terrain.level(), robot=ROBOT, q=y[:3].tolist(), dq=y[3:].tolist(), steps=1, compile=False
    )
    c, w = run.constants, run.state
    w.locked, w.slope, w.sine, w.cosine, w.before = locked, slope, math.sin(slope), math.cos(slope), math.inf
    w.sliding, w.pushed_x, w.pushed_z = sliding, math.sin(slope), math.cos(slope)
    enter_mode(c, w)
    return c, w


def spins(q: Array, dq: Array, about: Array) -> Array:
    """Angular momentum of each part about a point, kg m^2/s: shank, thigh, hip, thigh, shank from the stance foot."""
    places, speeds = expected("places", q, dq, 0.0).T - about, expected("speeds", q, dq, 0.0).T
    masses = np.array([ROBOT.shank_mass, ROBOT.thigh_mass, ROBOT.hip_mass, ROBOT.thigh_mass, ROBOT.shank_mass])
    own = np.array([ROBOT.shank_inertia, ROBOT.thigh_inertia, 0.0, ROBOT.thigh_inertia, ROBOT.shank_inertia])
    turning = own * dq[[0, 1, 1, 2, 3]]
    return masses * (places[:, 1] * speeds[:, 0] - places[:, 0] * speeds[:, 1]) + turning


def lowest(q: Array) -> Array:
    """The stance foot's contact: the arc's centre has rolled by the parts' own angle."""
    return np.array([ROBOT.foot_radius * parts_at(q, 0.0)[0], -ROBOT.foot_radius])


@given(st.floats(0.05, 0.5), RATES)
def test_a_heel_strike_conserves_what_no_impulse_acts_on(half: float, dq: Array) -> None:
    """The robot's momentum about its new contact, the departing leg's about the hip, its shank's about the knee.

    The last one where the knee opens; else the stop pushes the shank back, and both move as one.
    """
    before, rates = np.array([half, half, -half, -half]), dq[[0, 0, 1, 1]]
    after, (c, w) = -before, state_of(LOCKED, 0.0, np.array([half, -half, -half, dq[0], dq[1], dq[1]]))
    exchange_legs(c, w, 0.0)
    new = w.y[3:6]
    assert w.y[:3] == [-half, half, half]
    np.testing.assert_array_equal(new, ROBOT.rates_after_touchdown(np.array([half, -half, -half]), dq[[0, 1, 1]]))
    turning = np.array([new[0], new[0], new[1], new[2]])
    hip, knee = expected("joints", after, turning, 0.0).T
    # the same places, counted from the old stance foot's arc
    shift = expected("places", before, rates, 0.0).T[0] - expected("places", after, turning, 0.0).T[4]
    contact = lowest(after)
    assert np.allclose(shift[1], 0.0, atol=1e-12)
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
    c, w = state_of(FREE, 0.0, np.array([q[0], q[1], q[1], *dq[:3]]))
    strike_knee(c, w)
    assert w.locked == LOCKED
    assert w.y[4] == pytest.approx(w.y[5], abs=1e-12)
    after = np.array(w.y)[[3, 3, 4, 4]]
    np.testing.assert_allclose(ROBOT.knee_impact(w.y[:3], dq[:3])[1], w.y[3:5], rtol=1e-10, atol=1e-10)
    hip, _ = expected("joints", four, before, 0.0).T
    for about, parts in ((lowest(four), slice(None)), (hip, slice(3, None))):
        left = spins(four, before, about)[parts].sum()
        assert left == pytest.approx(spins(four, after, about)[parts].sum(), rel=1e-9, abs=1e-9)
