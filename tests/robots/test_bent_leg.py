"""Legs that stand and strike with bent knees: against the chain of four segments, and against angular momentum."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from simulations import UNEQUAL

from mjbiped.dynamics.modes import bent_leg
from mjbiped.robots.kneed import KneedBiped

Array = NDArray[np.float64]
ROBOTS = [
    KneedBiped(),
    KneedBiped.halved_rods(),
    UNEQUAL,
]
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


@given(st.floats(0.1, 2.0), st.floats(0.1, 2.0), flexions, angles)
@settings(deadline=None, derandomize=True)
def test_the_line_of_a_leg_goes_from_its_foot_to_its_hip(upper: float, lower: float, flexion: float, q: float) -> None:
    length, lean = bent_leg(upper, lower, flexion)
    shank, thigh = q + lean, q + lean - flexion
    hip = lower * np.array([math.sin(shank), math.cos(shank)]) + upper * np.array([math.sin(thigh), math.cos(thigh)])
    np.testing.assert_allclose(length * np.array([math.sin(q), math.cos(q)]), hip, rtol=0, atol=1e-14)


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


def momenta(robot: KneedBiped, q: Array, dq: Array, foot: complex, drift: complex) -> tuple[float, float]:
    """Angular momentum of the robot about the struck foot, and of the first leg about the hip, kg m^2/s.

    Of the masses' places and velocities, as complex numbers; the first foot moves.

    Args:
        robot: The robot.
        q: Angles of first shank, first thigh, second thigh, second shank.
        dq: Their rates.
        foot: Place of the first leg's foot.
        drift: Its velocity.
    """
    up = np.exp(1j * (math.pi / 2 - q))  # from below upward along each segment
    turn = -1j * dq * up
    lower, upper = robot.shank_length, robot.thigh_length
    low, high = lower - robot.shank_centre, upper - robot.thigh_centre
    place: dict[str, complex] = {}
    speed: dict[str, complex] = {}
    for there, way, start in ((place, up, foot), (speed, turn, drift)):
        there["shank"] = start + low * way[0]
        there["thigh"] = start + lower * way[0] + high * way[1]
        there["hip"] = start + lower * way[0] + upper * way[1]
        there["second thigh"] = there["hip"] - robot.thigh_centre * way[2]
        there["second shank"] = there["hip"] - upper * way[2] - robot.shank_centre * way[3]
        there["struck"] = there["hip"] - upper * way[2] - lower * way[3]
    masses = {
        "shank": (robot.shank_mass, robot.shank_inertia, 0),
        "thigh": (robot.thigh_mass, robot.thigh_inertia, 1),
        "hip": (robot.hip_mass, 0.0, 0),
        "second thigh": (robot.thigh_mass, robot.thigh_inertia, 2),
        "second shank": (robot.shank_mass, robot.shank_inertia, 3),
    }

    def about(point: complex, names: list[str]) -> float:
        total = 0.0
        for name in names:
            mass, inertia, segment = masses[name]
            arm = place[name] - point
            total += mass * (np.conj(arm) * speed[name]).imag - inertia * dq[segment]
        return float(total)

    return about(place["struck"], list(masses)), about(place["hip"], ["shank", "thigh"])


@given(robots, flexions, flexions, st.lists(angles, min_size=2, max_size=2), st.lists(rates, min_size=3, max_size=3))
@settings(deadline=None, derandomize=True)
def test_an_impact_keeps_the_angular_momenta_about_the_struck_foot_and_the_hip(
    robot: KneedBiped, stands: float, strikes: float, q: list[float], dq: list[float]
) -> None:
    """Nothing else has to be known of it: both legs are rigid, and these are two equations for their two rates."""
    before = unfolded(robot, stands, np.array([q[0], q[1], q[1] + strikes]))
    new, old, shank = robot.rates_after_touchdown([q[0], q[1], q[1] + strikes], dq, stands)
    assert shank == old
    length = np.array([robot.shank_length, robot.thigh_length, -robot.thigh_length, -robot.shank_length])
    after = np.array([old, old, new, new])
    turn = -1j * after * np.exp(1j * (math.pi / 2 - before))
    found = momenta(robot, before, after, 0j, -(length @ turn))  # the struck foot rests
    expected = momenta(robot, before, np.array(dq)[[0, 0, 1, 2]], 0j, 0j)
    # condition numbers of up to 1e2
    scale = robot.total_mass * robot.leg_length**2 * (1 + np.abs(dq).max())
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * scale)
