"""Equations of motion, energy and impact map against SymPy's derivation from the Lagrangian, and against physics."""

import math
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import cache

import numpy as np
import pytest
import sympy as sp
from lagrange import RELATIVE, Body, close, lagrange

from mjbiped.robots.compass import Array, Compass, acceleration

ROBOTS = [
    Compass(),
    Compass(hip_mass=10.0, leg_inertia=0.0),
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
]


@cache
def derived() -> dict[str, Callable[..., Array]]:
    """Everything that follows from the positions of the masses, as functions of (parameters, q, dq, slope)."""
    m, mH, a, b, J, g, slope = parameters = sp.symbols("m m_H a b J g slope")
    q = sp.Matrix(sp.symbols("q1 q2"))
    dq = sp.Matrix(sp.symbols("dq1 dq2"))
    x, z = sp.symbols("x z")
    dx, dz = sp.symbols("dx dz")
    theta1, theta2 = q[0] + slope, q[1] + slope

    def direction(angle: sp.Expr) -> sp.Matrix:
        return sp.Matrix([sp.sin(angle), sp.cos(angle)])

    def bodies(hip: sp.Matrix) -> list[Body]:
        first, second = hip - b * direction(theta1), hip - b * direction(theta2)
        return [(m, J, dq[0], first), (mH, 0, 0, hip), (m, J, dq[1], second)]

    # stance foot pinned at the origin
    hip = (a + b) * direction(theta1)
    laws = lagrange(q, dq, bodies(hip), g)
    M, C = laws["M"], sp.zeros(2, 2)
    for k in range(2):
        for j in range(2):
            for i in range(2):  # Christoffel symbols
                christoffel = sp.diff(M[k, j], q[i]) + sp.diff(M[k, i], q[j]) - sp.diff(M[i, j], q[k])
                C[k, j] += christoffel * dq[i] / 2

    # unpinned robot: the hip is free
    free = sp.Matrix([x, z, *q])
    velocities = sp.Matrix([dx, dz, *dq])
    centre = sp.Matrix([x, z])
    feet = [centre - (a + b) * direction(theta) for theta in (theta1, theta2)]

    arguments = (parameters, list(q), list(dq))
    expressions = {
        **laws,
        "h": laws["h"] + laws["g"],  # without C
        "C": C,
        "hip_jacobian": hip.jacobian(q),
        "swing_foot": hip - (a + b) * direction(theta2),
        "free_mass": lagrange(free, velocities, bodies(centre), g)["M"],
        "swing_foot_jacobian": feet[1].jacobian(free),
    }
    return {name: sp.lambdify(arguments, expression, cse=True) for name, expression in expressions.items()}


def value(name: str, robot: Compass, q: Array, dq: Array, slope: float) -> Array:
    numbers = (robot.leg_mass, robot.hip_mass, robot.lower_length, robot.upper_length, robot.leg_inertia)
    return np.squeeze(np.asarray(derived()[name]((*numbers, robot.gravity, slope), q.tolist(), dq.tolist())))


def states(count: int = 50) -> list[tuple[Array, Array, float]]:
    random = np.random.default_rng(7)
    return [
        (random.uniform(-1.5, 1.5, 2), random.uniform(-5, 5, 2), float(random.uniform(-0.5, 0.5))) for _ in range(count)
    ]


def accelerate(robot: Compass, q: Array, dq: Array, slope: float, force: Array) -> Array:
    (q1, q2), (dq1, dq2), (force1, force2) = q.tolist(), dq.tolist(), force.tolist()
    sine, cosine = math.sin(slope), math.cos(slope)
    return np.array(acceleration(robot.constants, q1, q2, dq1, dq2, sine, cosine, force1, force2))


@pytest.mark.parametrize("robot", ROBOTS)
def test_equations_follow_from_the_lagrangian(robot: Compass) -> None:
    for q, dq, slope in states():
        close(robot.mass_matrix(q), value("M", robot, q, dq, slope))
        close(robot.coriolis_matrix(q, dq), value("C", robot, q, dq, slope), scale=robot.constants[1] * 5)
        close(robot.gravity_vector(q, slope), value("g", robot, q, dq, slope))
        h = robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, slope)
        close(h, value("h", robot, q, dq, slope), scale=robot.constants[3] + 25 * robot.constants[1])
        close(robot.kinetic_energy(q, dq), value("T", robot, q, dq, slope))
        close(robot.potential_energy(q, slope), value("V", robot, q, dq, slope), scale=robot.constants[3])
        foot = value("swing_foot", robot, q, dq, slope)  # x and z; along the ground and normal to it:
        turn = np.array([[math.cos(slope), -math.sin(slope)], [math.sin(slope), math.cos(slope)]])
        close(robot.swing_foot(q), turn @ foot, scale=robot.leg_length)


@pytest.mark.parametrize("robot", ROBOTS)
def test_acceleration_solves_the_equation_of_motion(robot: Compass) -> None:
    for q, dq, slope in states():
        force = robot.input_matrix @ [3.0, -2.0]
        ddq = accelerate(robot, q, dq, slope, force)
        expected = np.linalg.solve(value("M", robot, q, dq, slope), force - value("h", robot, q, dq, slope))
        close(ddq, expected, relative=1e-11)  # the mass matrix's condition number is up to 30


@pytest.mark.parametrize("robot", ROBOTS)
def test_impact_is_the_plastic_impulse_of_the_free_robot(robot: Compass) -> None:
    for q, dq, slope in states():
        M = value("free_mass", robot, q, dq, slope)
        Jc = value("swing_foot_jacobian", robot, q, dq, slope)
        before = np.concatenate([value("hip_jacobian", robot, q, dq, slope) @ dq, dq])
        weighted = np.linalg.solve(M, Jc.T)
        after = before - weighted @ np.linalg.solve(Jc @ weighted, Jc @ before)
        q_plus, dq_plus = robot.impact(q, dq)
        np.testing.assert_array_equal(q_plus, q[::-1])
        # two linear systems with condition numbers up to 1e2 each
        close(dq_plus[::-1], after[2:], scale=float(np.abs(before).max()), relative=1e-11)
        # the foot has stopped, and the impulse does no more than take energy away
        close(Jc @ after, np.zeros(2), scale=float(np.abs(before).max()), relative=1e-11)
        assert robot.kinetic_energy(q_plus, dq_plus) <= robot.kinetic_energy(q, dq) * (1 + RELATIVE)


def test_defaults_are_table_one() -> None:
    robot = Compass()
    assert asdict(robot) == {
        "leg_mass": 5.0,
        "hip_mass": 0.0,
        "lower_length": 0.5,
        "upper_length": 0.5,
        "leg_inertia": 5 / 12,
        "gravity": 9.81,
        "sole": None,
    }
    assert robot == Compass(**asdict(robot))
    assert (robot.leg_length, robot.total_mass) == (1.0, 10.0)
    assert robot.weight == pytest.approx(98.1, rel=RELATIVE)
    assert robot.leg_inertia == pytest.approx(0.4167, abs=5e-5)  # Table I's digits
    np.testing.assert_array_equal(robot.input_matrix, [[1, -1], [0, 1]])
    assert all(type(number) is float for number in Compass(leg_mass=3, hip_mass=np.float32(1)).constants)  # type: ignore[arg-type]
    assert Compass(leg_inertia=None).leg_inertia == robot.leg_inertia  # type: ignore[arg-type]
    assert replace(robot, leg_mass=1).leg_inertia == robot.leg_inertia
