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
from simulations import hybrid_run

from mjbiped.control.controller import Unpowered
from mjbiped.dynamics.linkage import Motion, ground_force, room, stand
from mjbiped.robots.bodies import linkage_with
from mjbiped.robots.chain import Array, Chain, chain_by
from mjbiped.robots.compass import Compass
from mjbiped.robots.round import RoundCompass
from mjbiped.terrain.terrain import Terrain

RELATIVE = 1e-12
"""Rounding of some hundred operations on terms that differ by a factor of 1e2 at most."""

LEVERS = (((0.4, 0.05), (0.0, 0.0)), ((0.8, 0.1), (0.0, 0.0)), ((0.8, 0.1), (-0.5, 0.07)))
"""Along and ahead, of each body by segment, m: off the lines, so that nothing is symmetric."""
MASSES, INERTIAS, RADIUS, GRAVITY = (3.0, 7.0, 2.0), (0.2, 0.0, 0.3), 0.17, 9.81

ANGLES = st.lists(st.floats(-1.2, 1.2), min_size=2, max_size=2).map(np.array)
RATES = st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=2).map(np.array)
SLOPES = st.floats(-0.3, 0.3)


def linkage() -> Chain:
    bodies = [
        (mass, inertia, segment, np.array([complex(*lever) for lever in levers]))
        for mass, inertia, segment, levers in zip(MASSES, INERTIAS, (0, -1, 1), LEVERS, strict=True)
    ]
    end = np.array([0.8 + 0.1j, -0.8 - 0.1j])
    made = linkage_with(bodies, end, end, np.zeros(2, dtype=complex), angles=2, radius=RADIUS, gravity=GRAVITY)
    return chain_by(made, (0, 1))


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
    made = linkage()
    np.testing.assert_allclose(made.mass_matrix(q), expected("M", q, dq, slope), rtol=RELATIVE, atol=1e-12)
    np.testing.assert_allclose(made.coriolis_matrix(q, dq) @ dq, expected("h", q, dq, slope), rtol=RELATIVE, atol=1e-11)
    np.testing.assert_allclose(made.gravity_vector(q, slope), expected("g", q, dq, slope), rtol=RELATIVE, atol=1e-11)
    assert made.potential_energy(q, slope) == pytest.approx(float(expected("V", q, dq, slope)), rel=RELATIVE, abs=1e-11)


@given(ANGLES, RATES, RATES, SLOPES)
def test_the_ground_bears_momentum_and_weight(q: Array, dq: Array, forces: Array, slope: float) -> None:
    ddq = linkage().accelerations(forces, q, dq, slope)
    force = ground_force_of(q, dq, ddq, slope)
    pull = forces - expected("h", q, dq, slope) - expected("g", q, dq, slope)
    np.testing.assert_allclose(ddq, np.linalg.solve(expected("M", q, dq, slope), pull), rtol=1e-10, atol=1e-10)
    change = expected("momentum by rates", q, dq, slope) @ ddq + expected("momentum by angles", q, dq, slope) @ dq
    # conditioned like M: rounding of some 1e3 terms
    np.testing.assert_allclose(force, change + np.array([0.0, GRAVITY * sum(MASSES)]), rtol=1e-10, atol=1e-9)


def ground_force_of(q: Array, dq: Array, ddq: Array, slope: float) -> Array:
    """The linkage's force of the ground, forward and upward."""
    bodies = [
        (mass, inertia, segment, np.array([complex(*lever) for lever in levers]))
        for mass, inertia, segment, levers in zip(MASSES, INERTIAS, (0, -1, 1), LEVERS, strict=True)
    ]
    end = np.array([0.8 + 0.1j, -0.8 - 0.1j])
    made = linkage_with(bodies, end, end, np.zeros(2, dtype=complex), angles=2, radius=RADIUS, gravity=GRAVITY)
    motion = Motion(free=2, sine=math.sin(slope), cosine=math.cos(slope), **room())
    stand(made, motion)
    along, normal = ground_force(made, motion, q.tolist(), dq.tolist(), ddq.tolist())
    sine, cosine = math.sin(slope), math.cos(slope)
    return np.array([along * cosine + normal * sine, normal * cosine - along * sine])


@given(ANGLES, RATES)
def test_coriolis_matrix_passes_no_energy(q: Array, dq: Array) -> None:
    """dM/dt - 2 C is skew: dM/dt by the complex-free difference quotient of a quadratic's exact midpoint."""
    made, h = linkage(), 1e-6
    change = (made.mass_matrix(q + h * dq) - made.mass_matrix(q - h * dq)) / (2 * h)
    skew = change - 2.0 * made.coriolis_matrix(q, dq)
    # truncation h^2 |dq|^3 M ~ 1e-8, rounding 1e-9
    np.testing.assert_allclose(skew, -skew.T, atol=1e-6)


@given(st.floats(0.1, 0.5), RATES, st.floats(0.0, 0.6))
def test_a_heel_strike_conserves_angular_momentum(half: float, dq: Array, radius: float) -> None:
    """That of the robot about the place where the foot strikes, and that of the leg that leaves about the hip."""
    robot, q = RoundCompass(hip_mass=4.0, foot_radius=radius), np.array([half, -half])
    after, back = robot.rates_after_touchdown(q, dq), q[::-1]
    length, lower, upper = robot.leg_length, robot.lower_length, robot.upper_length
    masses = np.array([robot.leg_mass, robot.hip_mass, robot.leg_mass])

    def moving(angles: Array, rates: Array) -> tuple[Array, Array]:
        """Places from the stance foot's contact and velocities of stance leg, hip and swing leg."""
        up, ahead = np.stack([np.sin(angles), np.cos(angles)], -1), np.stack([np.cos(angles), -np.sin(angles)], -1)
        centre, rolling = np.array([0.0, radius]), np.array([radius * rates[0], 0.0])
        levers = [(lower - radius, 0.0), (length - radius, 0.0), (length - radius, -upper)]
        places = np.array([centre + a * up[0] + b * up[1] for a, b in levers])
        return places, np.array([rolling + a * rates[0] * ahead[0] + b * rates[1] * ahead[1] for a, b in levers])

    def spin(places: Array, speeds: Array, about: Array) -> Array:
        arm = places - about
        return masses * (arm[:, 1] * speeds[:, 0] - arm[:, 0] * speeds[:, 1])

    before_places, before = moving(q, dq)
    after_places, behind = moving(back, after)
    # the new contact is as far ahead of the old one as both arcs' centres are apart
    contact = np.array([2.0 * (length - radius) * math.sin(half), 0.0])
    own = robot.leg_inertia * np.array([dq[0], 0.0, dq[1]])
    new = robot.leg_inertia * np.array([after[0], 0.0, after[1]])
    total = spin(before_places, before, contact) + own
    assert total.sum() == pytest.approx((spin(after_places, behind, np.zeros(2)) + new).sum(), rel=1e-9, abs=1e-9)
    left = (spin(before_places, before, before_places[1]) + own)[0]
    assert left == pytest.approx((spin(after_places, behind, after_places[1]) + new)[2], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("robot", "closed"), [(Compass(hip_mass=2.0), True), (RoundCompass(), False)])
def test_two_straight_legs_on_a_point_have_the_short_equations(robot: Compass | RoundCompass, closed: bool) -> None:
    run = hybrid_run(Unpowered(), Terrain.level(), robot=robot, q=(-0.2, 0.2), dq=(1.0, 1.0), compile=False)
    assert run.state.closed == closed
