"""The impact of two feet with Coulomb friction, solved exactly: does the departing foot leave the ground freely?

Both impact maps, and both engines with them, take the departing foot for free. This test asks the law itself. Legs
are rigid in the impact (knees are locked), contacts plastic, and for either foot, of impulses p and speeds v after it,

    p_n >= 0,   v_n >= 0,   p_n v_n = 0;   |p_t| <= mu p_n, and p_t = -mu p_n sign(v_t) where it slides.

Sliding does not lift the foot: the law is not associated, unlike MuJoCo's convex one, which drags a foot that leaves
the ground at less than the angle of friction. In the plane the law is solved by looking at all ways in which two feet
can leave, stick or slide: each is a linear system, and those whose inequalities hold are the solutions. The momenta are
those of free bodies, apart from the project's own equations.
"""

import math
from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from engines.conformance.free_bodies import FreeRobot
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import mjbiped
from mjbiped import Compass, KneedBiped

Array = NDArray[np.float64]
FRICTION = 0.8
WAYS = ("leaves", "sticks", "slides forward", "slides backward")
LINKS = {"thigh_length": 0.45, "shank_length": 0.55, "thigh_centre": 0.2, "shank_centre": 0.3, "shank_mass": 1.5}
ROBOTS: dict[str, Compass | KneedBiped] = {
    "compass": Compass(),
    "hip mass": Compass(hip_mass=10.0),
    "knees": KneedBiped(),
    "unequal links": KneedBiped(**LINKS),
}


class Solution(NamedTuple):
    """One way in which the impact can go: of the departing foot and of the landing one."""

    ways: tuple[str, str]
    rates: Array
    impulses: Array


class Landing:
    """A robot with straight legs whose second foot comes down while the first one stands.

    Args:
        robot: The robot.
        legs: Departing and landing leg from the vertical, rad.
        rates: Their rates before the impact, rad/s.
        slopes: Of the ground under either foot, rad.
    """

    def __init__(
        self, robot: Compass | KneedBiped, legs: Array, rates: Array, slopes: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self.robot, self.bodies, self.legs, self.dq = robot, FreeRobot(robot), legs, rates
        self.qpos = np.array(robot.posture((0.0, 0.0), 0, self.whole(legs)))
        self.before = self.bodies.rates(self.qpos, 0, self.whole(rates), 0.0)
        feet = [
            end.jacobian(self.qpos) * np.exp(1j * slope) for end, slope in zip(self.bodies.ends, slopes, strict=True)
        ]
        self.turn = np.exp(1j * slopes[1])
        self.rows = np.array([part for foot in feet for part in (foot.imag, foot.real)])[:, :4]
        """Speeds of both feet normal to their ground and along it, for rates of hip and legs."""

    def whole(self, legs: Array) -> Array:
        """Numbers of stance and swing leg as those of all angles, the knee being straight."""
        return legs[[0, 1, 1][: len(self.robot.angles)]]

    def mapped(self) -> tuple[Array, float, float]:
        """By the robot's own map: rates of both legs, departing foot's speed, and friction that the other asks for."""
        heel = self.robot.heel_impact if isinstance(self.robot, KneedBiped) else self.robot.impact
        _, after = heel(self.legs, self.dq)
        v = self.bodies.rates(self.qpos, 1, self.whole(after), 0.0)
        impulse = self.bodies.momentum(self.qpos, v - self.before) * self.turn
        return np.asarray(after[::-1]), float(self.rows[0] @ v[:4]), abs(impulse.real) / impulse.imag

    def solutions(self, friction: float) -> list[Solution]:
        """All solutions of the impact."""
        pushed = np.linalg.solve(self.bodies.mass_matrix(self.qpos)[:4, :4], self.rows.T)
        A, closing = self.rows @ pushed, self.rows @ self.before[:4]
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
            impulses = np.asarray(np.linalg.solve(K, right), dtype=np.float64)
            feet = zip(ways, impulses.reshape(2, 2), (A @ impulses + closing).reshape(2, 2), strict=True)
            if all(holds(way, impulse, speed, friction, rounding) for way, impulse, speed in feet):
                found.append(Solution(ways, (self.before[:4] + pushed @ impulses)[2:], impulses))
        return found


def holds(way: str, impulse: Array, speed: Array, friction: float, rounding: float) -> bool:
    """Whether the inequalities of a foot's way hold."""
    (p_n, p_t), (v_n, v_t) = impulse, speed
    if way == "leaves":
        return bool(v_n >= -rounding)
    if way == "sticks":
        return bool(p_n >= 0.0 and abs(p_t) <= friction * p_n)
    return bool(p_n >= 0.0 and (v_t > 0.0) == (way == "slides forward"))


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
    middle, dq = 0.5 * sum(slopes), np.array(rates)
    landing = Landing(ROBOTS[name], np.array([half + middle, middle - half]), dq, slopes)
    assume(landing.rows[2] @ landing.before[:4] < -1e-3)  # it comes down
    after, lifts, asked = landing.mapped()
    assume(abs(lifts) > 1e-9)
    assume(abs(asked - FRICTION) > 1e-9)
    solutions = landing.solutions(FRICTION)
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
        landing = Landing(gait.robot, q + slope, dq, (slope, slope))
        (found,) = landing.solutions(friction)
        assert found.ways == ("leaves", "sticks")
        # the integration's error, which the reference's table keeps
        assert found.rates == pytest.approx(landing.mapped()[0], abs=1e-9)
