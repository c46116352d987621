"""The equations of a linkage that rolls: against SymPy's derivation from the places of the masses, chains, and laws."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from lagrange import lagrange

from mjbiped.dynamics.linkage import Linkage, Motion, ground_force, room, stand
from mjbiped.robots.bodies import linkage_with
from mjbiped.robots.chain import Array, chain_by

RELATIVE = 1e-12
"""Rounding of some hundred operations on terms that differ by a factor of 1e2 at most."""

LEVERS = (((0.4, 0.05), (0.0, 0.0)), ((0.8, 0.1), (0.0, 0.0)), ((0.8, 0.1), (-0.5, 0.07)))
"""Along and ahead, of each body by segment, m: off the lines, so that nothing is symmetric."""
MASSES, INERTIAS, RADIUS, GRAVITY = (3.0, 7.0, 2.0), (0.2, 0.0, 0.3), 0.17, 9.81

ANGLES = st.lists(st.floats(-1.2, 1.2), min_size=2, max_size=2).map(np.array)
RATES = st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=2).map(np.array)
SLOPES = st.floats(-0.3, 0.3)


def linkage() -> Linkage:
    bodies = [
        (mass, inertia, segment, np.array([complex(*lever) for lever in levers]))
        for mass, inertia, segment, levers in zip(MASSES, INERTIAS, (0, -1, 1), LEVERS, strict=True)
    ]
    end = np.array([0.8 + 0.1j, -0.8 - 0.1j])
    return linkage_with(bodies, end, end, np.zeros(2, dtype=complex), angles=2, radius=RADIUS, gravity=GRAVITY)


@cache
def derived() -> dict[str, Callable[..., object]]:
    """What follows from the places of the masses by Lagrange's equations, as functions of (q, dq, slope)."""
    q, dq, slope = sp.Matrix(sp.symbols("q:2")), sp.Matrix(sp.symbols("dq:2")), sp.Symbol("slope")
    centre = RADIUS * q[0] * sp.Matrix([sp.cos(slope), -sp.sin(slope)])
    places = [
        centre
        + sum(
            (
                along * sp.Matrix([sp.sin(angle + slope), sp.cos(angle + slope)])
                + ahead * sp.Matrix([sp.cos(angle + slope), -sp.sin(angle + slope)])
                for (along, ahead), angle in zip(levers, q, strict=True)
            ),
            sp.zeros(2, 1),
        )
        for levers in LEVERS
    ]
    turning = (dq[0], sp.Integer(0), dq[1])
    expressions = lagrange(q, dq, list(zip(MASSES, INERTIAS, turning, places, strict=True)), GRAVITY)
    momentum = expressions.pop("momentum")
    expressions |= {"momentum by rates": momentum.jacobian(dq), "momentum by angles": momentum.jacobian(q)}
    return {name: sp.lambdify((q, dq, slope), expression) for name, expression in expressions.items()}


def expected(name: str, q: Array, dq: Array, slope: float) -> Array:
    return np.asarray(derived()[name](q, dq, slope), dtype=np.float64).squeeze()


@given(ANGLES, RATES, SLOPES)
def test_equations_of_motion_are_those_of_lagrange(q: Array, dq: Array, slope: float) -> None:
    made = chain_by(linkage(), (0, 1))
    np.testing.assert_allclose(made.mass_matrix(q), expected("M", q, dq, slope), rtol=RELATIVE, atol=1e-12)
    np.testing.assert_allclose(made.coriolis_matrix(q, dq) @ dq, expected("h", q, dq, slope), rtol=RELATIVE, atol=1e-11)
    np.testing.assert_allclose(made.gravity_vector(q, slope), expected("g", q, dq, slope), rtol=RELATIVE, atol=1e-11)
    assert made.potential_energy(q, slope) == pytest.approx(float(expected("V", q, dq, slope)), rel=RELATIVE, abs=1e-11)


@given(ANGLES, RATES, RATES, SLOPES)
def test_the_ground_bears_momentum_and_weight(q: Array, dq: Array, forces: Array, slope: float) -> None:
    ddq = chain_by(linkage(), (0, 1)).accelerations(forces, q, dq, slope)
    force = ground_force_of(q, dq, ddq, slope)
    pull = forces - expected("h", q, dq, slope) - expected("g", q, dq, slope)
    np.testing.assert_allclose(ddq, np.linalg.solve(expected("M", q, dq, slope), pull), rtol=1e-10, atol=1e-10)
    change = expected("momentum by rates", q, dq, slope) @ ddq + expected("momentum by angles", q, dq, slope) @ dq
    # conditioned like M: rounding of some 1e3 terms
    np.testing.assert_allclose(force, change + np.array([0.0, GRAVITY * sum(MASSES)]), rtol=1e-10, atol=1e-9)


def ground_force_of(q: Array, dq: Array, ddq: Array, slope: float) -> Array:
    """The linkage's force of the ground, forward and upward."""
    made = linkage()
    motion = Motion(free=2, sine=math.sin(slope), cosine=math.cos(slope), **room())
    stand(made, motion)
    along, normal = ground_force(made, motion, q.tolist(), dq.tolist(), ddq.tolist())
    sine, cosine = math.sin(slope), math.cos(slope)
    return np.array([along * cosine + normal * sine, normal * cosine - along * sine])
