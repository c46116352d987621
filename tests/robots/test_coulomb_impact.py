"""The impact of two feet with Coulomb friction, solved exactly: does the departing foot leave the ground freely?

Both impact maps, and both engines with them, take the departing foot for free. This test asks the law itself. Legs
are rigid in the impact (knees are locked), contacts plastic, and for either foot, of impulses p and speeds v after it,

    p_n >= 0,   v_n >= 0,   p_n v_n = 0;   |p_t| <= mu p_n, and p_t = -mu p_n sign(v_t) where it slides.

Sliding does not lift the foot: the law is not associated, unlike MuJoCo's convex one, which drags a foot that leaves
the ground at less than the angle of friction. In the plane the law is solved by looking at all ways in which two feet
can leave, stick or slide: each is a linear system, and those whose inequalities hold are the solutions. The momenta are
derived here from the bodies' places, apart from the project's own equations.
"""

import math
from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import mjbiped
from mjbiped import Compass, KneedBiped
from mjbiped.robots.robot import Robot

Array = NDArray[np.float64]
FRICTION = 0.8
WAYS = ("leaves", "sticks", "slides forward", "slides backward")
UNEQUAL = KneedBiped(thigh_length=0.45, shank_length=0.55, thigh_centre=0.2, shank_centre=0.3, shank_mass=1.5)
ROBOTS = {"compass": Compass(), "hip mass": Compass(hip_mass=10.0), "knees": KneedBiped(), "unequal links": UNEQUAL}


class Solution(NamedTuple):
    """One way in which the impact can go: of the departing foot and of the landing one."""

    ways: tuple[str, str]
    rates: Array
    impulses: Array
    speeds: Array


def lever_jacobian(legs: Array, levers: tuple[float, float]) -> Array:
    """Speed x, z of a point at levers along both legs from the departing foot, for the rates (foot x, foot z, legs)."""
    (a, b), (s1, s2), (c1, c2) = levers, np.sin(legs), np.cos(legs)
    return np.array([[1.0, 0.0, a * c1, b * c2], [0.0, 1.0, -a * s1, -b * s2]])


def floating_mass_matrix(robot: Robot, legs: Array) -> Array:
    """Of the robot as two rigid legs, its feet free."""
    length = robot.leg_length
    if isinstance(robot, Compass):
        below = [(robot.leg_mass, robot.leg_inertia, robot.upper_length)]  # body, and its distance below the hip
    else:
        assert isinstance(robot, KneedBiped)
        below = [
            (robot.thigh_mass, robot.thigh_inertia, robot.thigh_centre),
            (robot.shank_mass, robot.shank_inertia, robot.thigh_length + robot.shank_centre),
        ]
    hip = lever_jacobian(legs, (length, 0.0))
    matrix: Array = robot.hip_mass * hip.T @ hip
    for mass, inertia, down in below:
        for leg, levers in enumerate(((length - down, 0.0), (length, -down))):
            jacobian = lever_jacobian(legs, levers)
            matrix += mass * jacobian.T @ jacobian
            matrix[2 + leg, 2 + leg] += inertia
    return matrix


def coulomb(robot: Robot, legs: Array, rates: Array, slopes: tuple[float, float], friction: float) -> list[Solution]:
    """All solutions of the impact in which a second foot lands while the first one stands.

    Args:
        robot: With straight legs.
        legs: Departing and landing leg from the vertical, rad.
        rates: Their rates before the impact, rad/s.
        slopes: Of the ground under either foot, rad.
        friction: Coefficient.
    """
    rows = []
    for levers, slope in (((0.0, 0.0), slopes[0]), ((robot.leg_length, -robot.leg_length), slopes[1])):
        jacobian = lever_jacobian(legs, levers)
        normal = normal_of(slope)
        rows += [normal @ jacobian, np.array([normal[1], -normal[0]]) @ jacobian]
    J, M = np.array(rows), floating_mass_matrix(robot, legs)
    pushed = np.linalg.solve(M, J.T)
    A, before = J @ pushed, np.array([0.0, 0.0, *rates])
    closing = J @ before
    rounding = 1e-11 * np.abs(closing).max()
    found = []
    for ways in product(WAYS, WAYS):
        K, right = np.eye(4), np.zeros(4)
        for foot, way in enumerate(ways):
            n, t = 2 * foot, 2 * foot + 1
            if way != "leaves":
                K[n], right[n] = A[n], -closing[n]
            if way == "sticks":
                K[t], right[t] = A[t], -closing[t]
            elif way != "leaves":
                K[t, n] = friction if way == "slides forward" else -friction
        impulses: Array = np.asarray(np.linalg.solve(K, right), dtype=np.float64)
        speeds: Array = A @ impulses + closing
        feet = zip(ways, impulses.reshape(2, 2), speeds.reshape(2, 2), strict=True)
        if all(holds(way, impulse, speed, friction, rounding) for way, impulse, speed in feet):
            after: Array = before + pushed @ impulses
            found.append(Solution(ways, after[2:], impulses, speeds))
    return found


def holds(way: str, impulse: Array, speed: Array, friction: float, rounding: float) -> bool:
    """Whether the inequalities of a foot's way hold."""
    (p_n, p_t), (v_n, v_t) = impulse, speed
    if way == "leaves":
        return bool(v_n >= -rounding)
    if way == "sticks":
        return bool(p_n >= 0.0 and abs(p_t) <= friction * p_n)
    return bool(p_n >= 0.0 and (v_t > 0.0) == (way == "slides forward"))


def normal_of(slope: float) -> Array:
    """Of ground, out of it."""
    return np.array([math.sin(slope), math.cos(slope)])


def departing_speed(robot: Robot, legs: Array, after: Array) -> Array:
    """Speed x, z of the departing foot while the landed one stands, m/s."""
    length = robot.leg_length
    return np.asarray(-lever_jacobian(legs, (length, -length))[:, 2:] @ after)


def friction_asked(robot: Robot, legs: Array, before: Array, after: Array, slope: float) -> float:
    """Ratio |p_t| / p_n of the impulse at the landing foot: all of the change of momentum, where the other one is free.

    `after` are the speeds of the departing foot and the rates of the legs.
    """
    impulse = (floating_mass_matrix(robot, legs) @ (after - np.array([0.0, 0.0, *before])))[:2]
    normal = normal_of(slope)
    return float(abs(impulse @ [normal[1], -normal[0]]) / (impulse @ normal))


def mapped(robot: Robot, legs: Array, rates: Array) -> Array:
    """Rates of departing and landing leg after the robot's own impact map."""
    assert isinstance(robot, Compass | KneedBiped)
    _, after = robot.heel_impact(legs, rates) if isinstance(robot, KneedBiped) else robot.impact(legs, rates)
    return np.asarray(after[::-1])


@pytest.mark.parametrize("name", ROBOTS)
@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    half=st.floats(0.08, 0.45),
    slopes=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)),
    rates=st.tuples(st.floats(0.2, 2.5), st.floats(-2.0, 2.5)),
)
def test_the_foot_leaves_freely_where_the_map_lifts_it(
    name: str, half: float, slopes: tuple[float, float], rates: tuple[float, float]
) -> None:
    """If after the map it moves off its ground, and the other foot asks for no more friction than there is.

    Then that is the one solution; else it is none.
    """
    robot, middle = ROBOTS[name], 0.5 * sum(slopes)
    legs, dq = np.array([half + middle, middle - half]), np.array(rates)
    foot = lever_jacobian(legs, (robot.leg_length, -robot.leg_length))[:, 2:] @ dq
    assume(foot @ normal_of(slopes[1]) < -1e-3)  # it comes down
    after = mapped(robot, legs, dq)
    departing = departing_speed(robot, legs, after)
    lifts = float(departing @ normal_of(slopes[0]))
    asked = friction_asked(robot, legs, dq, np.concatenate([departing, after]), slopes[1])
    assume(abs(lifts) > 1e-9)
    assume(abs(asked - FRICTION) > 1e-9)
    solutions = coulomb(robot, legs, dq, slopes, FRICTION)
    free = [found for found in solutions if found.ways == ("leaves", "sticks")]
    assert bool(free) == (lifts > 0.0 and asked < FRICTION)
    if free:
        assert len(solutions) == 1
        assert free[0].rates == pytest.approx(after, abs=1e-11 * np.abs([*dq, *after]).max())


@pytest.mark.parametrize("friction", [0.3, FRICTION, 3.0])
@pytest.mark.parametrize("slope_deg", [0.5, 2.0, 2.5])
def test_on_the_gaits_the_foot_leaves_freely_at_any_friction(slope_deg: float, friction: float) -> None:
    slope = math.radians(slope_deg)
    gaits: list[mjbiped.Gait | mjbiped.KneedGait] = [mjbiped.find_passive_gait(Compass(), slope)]
    if slope_deg == 2.5:
        gaits.append(mjbiped.find_kneed_gait(KneedBiped(), slope))
    for gait in gaits:
        q, dq, _ = (part[:2] for part in gait.reference(gait.period))
        (found,) = coulomb(gait.robot, q + slope, dq, (slope, slope), friction)
        assert found.ways == ("leaves", "sticks")
        # the integration's error, which the reference's table keeps
        assert found.rates == pytest.approx(mapped(gait.robot, q, dq), abs=1e-9)
