"""The equations of a planar chain against SymPy's derivation from the masses' positions, MuJoCo, and laws."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from lagrange import RELATIVE, close, lagrange
from simulations import UNEQUAL

from mjbiped.dynamics.linkage import Motion, room
from mjbiped.dynamics.modes import bend_stance_knee, bent_leg, land
from mjbiped.robots.chain import Array
from mjbiped.robots.compass import Compass, acceleration
from mjbiped.robots.kneed import KneedBiped

ROBOTS = [KneedBiped(), KneedBiped.halved_rods(), UNEQUAL]
COMPASSES = [
    Compass(),
    Compass(hip_mass=10.0, leg_inertia=0.0),
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
]


@cache
def derived(n: int) -> dict[str, Callable[..., object]]:
    """Everything that follows from the positions of the masses, as functions of (parameters, q, dq, slope)."""
    mt, ms, mh, lt, ls, ct, cs, jt, js, g, slope = parameters = sp.symbols("mt ms mh lt ls ct cs jt js g slope")
    q, dq = sp.Matrix(sp.symbols(f"q:{n}")), sp.Matrix(sp.symbols(f"dq:{n}"))
    foot, dfoot = sp.Matrix(sp.symbols("x z")), sp.Matrix(sp.symbols("dx dz"))
    angles = {2: (0, 0, 1, 1), 3: (0, 0, 1, 2), 4: (0, 1, 2, 3)}[n]
    stance_shank, stance_thigh, swing_thigh, swing_shank = (q[k] + slope for k in angles)

    def up(length: sp.Expr, angle: sp.Expr) -> sp.Matrix:
        return length * sp.Matrix([sp.sin(angle), sp.cos(angle)])

    knee = foot + up(ls, stance_shank)
    hip = knee + up(lt, stance_thigh)
    swing_knee = hip - up(lt, swing_thigh)
    swing_foot = swing_knee - up(ls, swing_shank)
    bodies = [
        (ms, js, dq[angles[0]], knee - up(cs, stance_shank)),
        (mt, jt, dq[angles[1]], hip - up(ct, stance_thigh)),
        (mh, 0, 0, hip),
        (mt, jt, dq[angles[2]], hip - up(ct, swing_thigh)),
        (ms, js, dq[angles[3]], swing_knee - up(cs, swing_shank)),
    ]
    free, velocities = sp.Matrix([*foot, *q]), sp.Matrix([*dfoot, *dq])
    laws = lagrange(free, velocities, bodies, g)
    pinned, M = {**dict.fromkeys(foot, 0), **dict.fromkeys(dfoot, 0)}, laws["M"][2:, 2:]
    by_christoffel = sp.Matrix(
        2,
        2,
        lambda k, j: sum(
            (sp.diff(M[k, j], q[i]) + sp.diff(M[k, i], q[j]) - sp.diff(M[i, j], q[k])) * dq[i] / 2 for i in range(2)
        ),
    )
    expressions = {
        "M": M,
        "T": laws["T"].subs(pinned),
        "C": by_christoffel,  # of two segments
        "g": laws["g"][2:, :].subs(pinned),
        "h": (laws["h"] + laws["g"])[2:, :].subs(pinned),
        "V": laws["V"].subs(pinned),
        "swing_foot": swing_foot.subs(pinned),
        "free_mass": laws["M"],
        "swing_foot_jacobian": swing_foot.jacobian(free).subs(pinned),
    }
    arguments = (parameters, list(q), list(velocities))
    return {name: sp.lambdify(arguments, expression, cse=True) for name, expression in expressions.items()}


def value(name: str, robot: KneedBiped | Compass, q: Array, rates: Array, slope: float = 0.0) -> Array:
    """One of `derived`; the rates are of the angles, or of the stance foot's place and then of the angles."""
    numbers = [getattr(robot, name) for name in robot.numbers()]
    if isinstance(robot, Compass):  # its legs are thighs, and shanks of no length
        mass, hip, _, upper, inertia, gravity = numbers
        numbers = [mass, 0.0, hip, robot.leg_length, 0.0, upper, 0.0, inertia, 0.0, gravity]
    whole = rates if len(rates) > len(q) else np.concatenate([np.zeros(2), rates])
    return np.squeeze(np.asarray(derived(len(q))[name]((*numbers, slope), q.tolist(), whole.tolist())))


def states(n: int, count: int = 20) -> list[tuple[Array, Array, float]]:
    random = np.random.default_rng(11 + n)
    return [
        (random.uniform(-1.5, 1.5, n), random.uniform(-5, 5, n), float(random.uniform(-0.5, 0.5))) for _ in range(count)
    ]


@pytest.mark.parametrize(
    ("robot", "n"),
    [
        *((robot, 2) for robot in [*COMPASSES, *ROBOTS]),
        *(pytest.param(robot, n, marks=[pytest.mark.slow] * (n == 4)) for robot in ROBOTS for n in (3, 4)),
    ],
)
def test_equations_follow_from_the_lagrangian(robot: KneedBiped | Compass, n: int) -> None:
    chain = robot.chains[n]
    greatest = 25 * float(np.abs(chain.weights).sum()) + float(np.abs(chain.moments).sum())
    for q, dq, slope in states(n):
        M, h = value("M", robot, q, dq, slope), value("h", robot, q, dq, slope)
        close(robot.mass_matrix(q), M)
        close(robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, slope), h, scale=greatest)
        close(robot.gravity_vector(q, slope), value("g", robot, q, dq, slope), scale=greatest)
        close(robot.kinetic_energy(q, dq), value("T", robot, q, dq, slope), scale=greatest)
        close(robot.potential_energy(q, slope), value("V", robot, q, dq, slope), scale=greatest)
        if n == 2:
            close(robot.coriolis_matrix(q, dq), value("C", robot, q, dq, slope), scale=greatest)
        # the condition number of M is up to 1e3
        expected = np.linalg.solve(M, -h)
        close(chain.free_motion(q, dq, slope), expected, relative=1e-10)
        foot = value("swing_foot", robot, q, dq, slope)  # x and z; along the ground and normal to it:
        turn = np.array([[math.cos(slope), -math.sin(slope)], [math.sin(slope), math.cos(slope)]])
        close(robot.swing_foot(q), turn @ foot, scale=robot.leg_length)


@pytest.mark.parametrize("robot", COMPASSES)
def test_the_compass_bipeds_short_equations_and_its_impact(robot: Compass) -> None:
    """The acceleration, and the plastic impulse that stops the swing foot of the free robot."""
    for q, dq, slope in states(2, 50):
        M, h = value("M", robot, q, dq, slope), value("h", robot, q, dq, slope)
        force = robot.input_matrix @ [3.0, -2.0]
        state = map(float, (*q, *dq, math.sin(slope), math.cos(slope), *force))
        # the mass matrix's condition number is up to 30
        close(acceleration(robot.constants, *state), np.linalg.solve(M, force - h), relative=1e-11)
        M, Jc = (value(name, robot, q, dq, slope) for name in ("free_mass", "swing_foot_jacobian"))
        before = np.array([0.0, 0.0, *dq])
        weighted = np.linalg.solve(M, Jc.T)
        after = before - weighted @ np.linalg.solve(Jc @ weighted, Jc @ before)
        q_plus, dq_plus = robot.impact(q, dq)
        np.testing.assert_array_equal(q_plus, q[::-1])
        # two linear systems with condition numbers up to 1e2 each
        close(dq_plus[::-1], after[2:], scale=float(np.abs(before).max()), relative=1e-11)
        assert robot.kinetic_energy(q_plus, dq_plus) <= robot.kinetic_energy(q, dq) * (1 + RELATIVE)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("flexion", [0.0, 0.7])
def test_a_landing_is_the_plastic_impulse_of_the_free_chain(robot: KneedBiped, held: bool, flexion: float) -> None:
    """The struck foot rests, its knee is locked as it was, and that of the other leg, bent or not, if it is held."""
    linkage, motion = robot.linkages[0], Motion(**room())
    bend_stance_knee(motion, robot.thigh_length, robot.shank_length, flexion)
    for q, dq, _ in states(3):
        four, rates = unfolded(robot, flexion, q), dq[[0, 0, 1, 2]]
        M, foot = value("free_mass", robot, four, rates), value("swing_foot_jacobian", robot, four, rates)
        knees = np.array([[0.0, 0, 0, 0, 1, -1], [0, 0, 1, -1, 0, 0]])[: 2 if held else 1]
        Jc, before = np.vstack([foot, knees]), np.concatenate([np.zeros(2), rates])
        weight = np.linalg.solve(M, Jc.T)
        impulses = np.linalg.solve(Jc @ weight, Jc @ before)
        after = before - weight @ impulses
        along, normal, leaves = land(linkage, linkage, motion, [*q, *dq], held)
        # two linear systems with condition numbers up to 1e4
        close([motion.right[k] for k in (3, 0, 1, 2)], after[[5, 4, 3, 2]], relative=1e-9)
        close([along, normal], -impulses[:2], relative=1e-9)
        close(leaves, after[1], scale=float(np.abs(before).max()), relative=1e-9)
        assert after @ M @ after <= (before @ M @ before) * (1 + RELATIVE)


def test_a_chain_about_its_end_is_the_same_robot_seen_from_the_other_foot() -> None:
    """Both legs are alike: the weights about the end, in reverse order, are those about the stance foot."""
    for robot in ROBOTS:
        for n in (2, 4):
            chain = robot.chains[n]
            close(chain.about_end[::-1, ::-1], chain.weights)


RIGID = {
    3: np.array([[1.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    2: np.array([[1.0, 0], [1, 0], [0, 1], [0, 1]]),
}


robots, angles, rates = st.sampled_from(ROBOTS), st.floats(-1.5, 1.5), st.floats(-8, 8)
flexions = st.floats(0.0, 1.5)


def unfolded(robot: KneedBiped, flexion: float, q: Array) -> Array:
    """Angles of all four segments where the stance leg has a line's angle."""
    _, lean = bent_leg(robot.thigh_length, robot.shank_length, flexion)
    return np.array([q[0] + lean, q[0] + lean - flexion, q[1], q[-1]])


@pytest.mark.parametrize("n", [2, 3])
@given(robots, flexions, st.lists(angles, min_size=3, max_size=3), st.lists(rates, min_size=3, max_size=3), angles)
@settings(deadline=None, derandomize=True)
def test_it_is_the_chain_of_four_whose_stance_knee_is_locked(
    n: int, robot: KneedBiped, flexion: float, q: list[float], dq: list[float], slope: float
) -> None:
    """M, C dq, g and the place of the foot: E'ME and so on, of the matrices that SymPy derives again."""
    chain, E = robot.chains_on(flexion)[n], RIGID[n]
    angles, rates = np.array(q[:n]), np.array(dq[:n])
    four, turning = unfolded(robot, flexion, angles), E @ rates
    weights, moments = np.abs(robot.chains[4].weights).max(), np.abs(robot.chains[4].moments).max()
    # rounding of some dozen operations
    np.testing.assert_allclose(
        chain.mass_matrix(angles), E.T @ robot.mass_matrix(four) @ E, rtol=0, atol=1e-13 * weights
    )
    np.testing.assert_allclose(
        chain.coriolis_matrix(angles, rates) @ rates,
        E.T @ robot.coriolis_matrix(four, turning) @ turning,
        rtol=0,
        atol=1e-12 * weights * (1 + rates @ rates),
    )
    np.testing.assert_allclose(
        chain.gravity_vector(angles, slope), E.T @ robot.gravity_vector(four, slope), rtol=0, atol=1e-13 * moments
    )
    np.testing.assert_allclose(chain.end(angles), robot.swing_foot(four), rtol=0, atol=1e-14)


@pytest.mark.parametrize("locked", [False, True])
@given(robots, flexions, st.lists(angles, min_size=3, max_size=3), st.lists(rates, min_size=3, max_size=3))
@settings(deadline=None, derandomize=True)
def test_the_ground_force_is_that_on_the_chain_of_four(
    locked: bool, robot: KneedBiped, flexion: float, q: list[float], dq: list[float]
) -> None:
    slope, torque, E = 0.07, np.array([3.0, -7.0, 1.5]), RIGID[2 if locked else 3]
    angles, rates = np.array(q), np.array(dq)
    if locked:
        angles[2], rates[2] = angles[1], rates[1]
    n = E.shape[1]
    four, turning = unfolded(robot, flexion, angles[:n]), E @ rates[:n]
    ankle, hip, knee = torque
    forces = np.array([0.0, ankle - hip, hip - knee, knee])  # on the four segments
    pull = forces - robot.coriolis_matrix(four, turning) @ turning - robot.gravity_vector(four, slope)
    ddq = E @ np.linalg.solve(E.T @ robot.mass_matrix(four) @ E, E.T @ pull)
    moments, angle = robot.chains[4].moments / robot.gravity, four + slope  # of mass, kg m
    forward = moments @ (np.cos(angle) * ddq - np.sin(angle) * turning**2)
    expected = forward, robot.weight - moments @ (np.sin(angle) * ddq + np.cos(angle) * turning**2)
    found = robot.ground_force(angles, rates, torque, slope, locked=locked, stance_flexion=flexion)
    scale = robot.weight * (1 + rates @ rates)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * scale)  # condition numbers up to 1e2
