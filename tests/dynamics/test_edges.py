"""Feet that turn about an edge: against SymPy's derivation from the places of foot, legs and hip on a free base."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from lagrange import lagrange
from simulations import hybrid_run

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.dynamics.linkage import BASE
from mjbiped.dynamics.modes import FLAT, HEEL, TOE
from mjbiped.engines.hybrid.impacts import lay_flat, stop_swing_foot
from mjbiped.engines.hybrid.motion import enter_mode, rates, stance_force
from mjbiped.engines.hybrid.resets import exchange_legs, write_posture
from mjbiped.engines.hybrid.state import Constants, State
from mjbiped.robots.chain import Array

RELATIVE = 1e-12
"""Rounding of some hundred operations, of the largest term."""
CONDITION = 30.0
"""By how much solving for rates multiplies it: the foot's line is short (measured: 5)."""

ROBOT = mjbiped.FootedCompass(
    leg_mass=4.0, hip_mass=3.0, lower_length=0.55, upper_length=0.4, sole=(0.07, 0.15), foot_mass=0.3, ankle_height=0.06
)
EDGES = pytest.mark.parametrize("edge", [TOE, HEEL])
ANGLES = st.lists(st.floats(-0.8, 0.8), min_size=3, max_size=3).map(np.array)
RATES = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3).map(np.array)
SLOPES = st.floats(-0.3, 0.3)
TORQUES = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))


@cache
def derived(edge: int) -> dict[str, Callable[..., Any]]:
    """Mass matrix, forces of gravity and rates, and places, for (x, z of the edge, stance, swing, foot) as coordinates.

    Angles are from the vertical here. Foot and leg are bodies of their own; the swing foot is a point.
    """
    x, v = sp.Matrix(sp.symbols("x:5")), sp.Matrix(sp.symbols("v:5"))
    foot, leg = ROBOT.foot, ROBOT.bodies.leg[0]
    beside = -foot.ahead if edge == TOE else foot.behind

    def along(angle: sp.Expr, distance: float) -> sp.Matrix:
        return distance * sp.Matrix([sp.sin(angle), sp.cos(angle)])

    ankle = sp.Matrix([x[0], x[1]]) + along(x[4], foot.height) + beside * sp.Matrix([sp.cos(x[4]), -sp.sin(x[4])])
    hip = ankle + along(x[2], leg.length)
    end = hip - along(x[3], leg.length)
    bodies = [
        (foot.mass, foot.inertia, v[4], ankle),
        (leg.mass, leg.inertia, v[2], hip - along(x[2], leg.centre)),
        (ROBOT.hip_mass, 0, 0, hip),
        (leg.mass, leg.inertia, v[3], hip - along(x[3], leg.centre)),
        (foot.mass, 0, 0, end),
    ]
    laws = lagrange(x, v, bodies, ROBOT.gravity)
    found = {
        "M": laws["M"],
        "rest": laws["h"] + laws["g"],
        "hip": hip.jacobian(x),
        "end": end.jacobian(x),
    }
    return {name: sp.lambdify([x, v], expression, cse=True) for name, expression in found.items()}


def walker(edge: int, slope: float, y: Sequence[float] | Array | None = None, **more: Any) -> tuple[Constants, State]:
    """The robot on a slope, in a state."""
    run = hybrid_run(
        Unpowered(), mjbiped.Terrain.level(), robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1, compile=False
    )
    c, w = run.constants, run.state
    w.edge, w.slope, w.sine, w.cosine, w.before = edge, slope, math.sin(slope), math.cos(slope), math.inf
    for name, value in more.items():
        setattr(w, name, value)
    if y is not None:
        swing_foot = [float(y[i]) if edge != FLAT else 0.0 for i in (2, 5)]  # parallel to the other one
        w.y[:8] = [*map(float, y[:3]), swing_foot[0], *map(float, y[3:]), swing_foot[1]]
    enter_mode(c, w)
    return c, w


def moved(c: Constants, w: State, torques: tuple[float, float]) -> tuple[Array, Array]:
    """Accelerations of the state under torques, and the force of the ground, forward and upward."""
    c.torque = lambda *arguments: arguments[-1].__setitem__(slice(2), torques)
    changes = [0.0] * c.size
    rates(c, w, 0.0, w.y, changes)
    along, normal = stance_force(c, w, w.y[:4], w.y[4:8], changes[4:8])
    return np.array(changes[4:7]), np.array([along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine])


def free(q: Array, dq: Array, slope: float) -> tuple[Array, Array]:
    """The coordinates of `derived`, with the edge at rest."""
    return np.array([0.0, 0.0, *(q + slope)]), np.array([0.0, 0.0, *dq])


def constrained(edge: int, x: Array, v: Array, rows: Array) -> Array:
    """Rates after a plastic impact that brings rows . v to zero, by Lagrange's multipliers."""
    M, k = np.array(derived(edge)["M"](x, v)), len(rows)
    whole = np.block([[M, rows.T], [rows, np.zeros((k, k))]])
    return np.linalg.solve(whole, np.concatenate([M @ v, np.zeros(k)]))[:5]


def agree(found: Any, expected: Any, scale: Any) -> None:
    """Check for equality but for rounding of numbers as large as the scale."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=RELATIVE * float(np.max(np.abs(scale))))


@EDGES
@given(q=ANGLES, dq=RATES, slope=SLOPES, torques=TORQUES, push=st.floats(-9, 9))
def test_accelerations_and_the_force_of_the_ground_are_lagranges(
    edge: int, q: Array, dq: Array, slope: float, torques: tuple[float, float], push: float
) -> None:
    c, w = walker(edge, slope, [*q, *dq], push=push)
    ddq, force = moved(c, w, torques)
    x, v = free(q, dq, slope)
    laws = derived(edge)
    M, rest = np.array(laws["M"](x, v)), np.array(laws["rest"](x, v))[:, 0]
    forces = push * np.array(laws["hip"](x, v))[0] + [0.0, 0.0, torques[0] - torques[1], torques[1], -torques[0]]
    residual = M @ [0.0, 0.0, *ddq] + rest - forces
    terms = np.abs(M) @ [0.0, 0.0, *np.abs(ddq)] + np.abs(rest)
    agree(residual[2:], 0.0, terms)  # the equations of motion, with the edge held
    agree(force, residual[:2], terms)  # what holds the edge


@EDGES
@given(q=ANGLES, dq=RATES, slope=SLOPES)
def test_a_foot_comes_down_flat_as_multipliers_say(edge: int, q: Array, dq: Array, slope: float) -> None:
    q = np.array([q[0], q[1], 0.0])
    c, w = walker(edge, slope, [*q, *dq])
    lay_flat(c, w)
    x, v = free(q, dq, slope)
    after = constrained(edge, x, v, np.eye(5)[[0, 1, 4]])
    agree(w.y[4:6], after[2:4], CONDITION * (1.0 + np.abs(dq)))
    assert (w.y[2], w.y[6], w.edge, w.levers[BASE][2], w.levers[BASE + 1][2]) == (0.0, 0.0, FLAT, 0.0, 0.0)


@EDGES
@given(q=ANGLES, dq=RATES, slope=SLOPES, new=SLOPES)
def test_the_other_foot_lands_while_this_one_has_tipped(
    edge: int, q: Array, dq: Array, slope: float, new: float
) -> None:
    c, w = walker(edge, slope, [*q, *dq])
    exchange_legs(c, w, new)
    x, v = free(q, dq, slope)
    after = constrained(edge, x, v, np.array(derived(edge)["end"](x, v)))
    speeds = CONDITION * (1.0 + np.abs(dq))
    agree([w.y[5], w.y[4]], after[2:4], speeds)
    agree(np.array(w.y[:3]) + new, [q[1] + slope, q[0] + slope, new], 1.0)
    assert w.edge == FLAT


@EDGES
@given(q=ANGLES, dq=RATES, slope=SLOPES)
def test_a_face_stops_the_swing_foot_along_its_normal(edge: int, q: Array, dq: Array, slope: float) -> None:
    c, w = walker(edge, slope, [*q, *dq], pushed_x=-1.0, pushed_z=0.0)
    stop_swing_foot(c, w)
    impulse = w.right[w.size]
    x, v = free(q, dq, slope)
    end = np.array(derived(edge)["end"](x, v))
    after = constrained(edge, x, v, np.vstack([np.eye(5)[:2], end[:1]]))
    speeds = CONDITION * (1.0 + np.abs(dq))
    agree(w.y[4:7], after[2:], speeds)
    M = np.array(derived(edge)["M"](x, v))
    agree((M @ (after - v))[2:], -impulse * end[0, 2:], np.abs(M) * speeds.max())


@given(q=ANGLES, dq=RATES, slope=SLOPES, torques=TORQUES)
def test_a_flat_foot_is_the_compass_biped(q: Array, dq: Array, slope: float, torques: tuple[float, float]) -> None:
    q, dq = q * [1.0, 1.0, 0.0], dq * [1.0, 1.0, 0.0]
    c, w = walker(FLAT, slope, [*q, *dq])
    one = ROBOT.mechanism
    expected = one.ground_force(q[:2], dq[:2], torques, slope)
    ddq, found = moved(c, w, torques)
    forces = one.input_matrix @ torques - one.coriolis_matrix(q[:2], dq[:2]) @ dq[:2] - one.gravity_vector(q[:2], slope)
    M = one.mass_matrix(q[:2])
    agree(M @ ddq[:2], forces, np.abs(M) @ np.abs(ddq[:2]) + np.abs(forces))
    agree(found, expected, [*expected, 100.0 * ROBOT.weight])
    assert ddq[2] == 0.0
    exchange_legs(c, w, slope)
    agree(w.y[4:6], one.impact(q[:2], dq[:2])[1], CONDITION * (1.0 + np.abs(dq)))


def test_a_posture_has_parallel_feet() -> None:
    c, w = walker(TOE, 0.1, [-0.2, 0.3, 0.05, 0.0, 0.0, 0.0])
    write_posture(c, w, w.y)
    assert w.posture[2:6] == pytest.approx((-0.1, 0.4, 0.25, -0.25))
    w.y[3], w.stance = 0.07, 1  # as it lands on steeper ground
    write_posture(c, w, w.y)
    assert w.posture[2:6] == pytest.approx((0.4, -0.1, -0.23, 0.25))
