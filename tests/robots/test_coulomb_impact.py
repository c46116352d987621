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
from numpy.typing import NDArray

import mjbiped
from mjbiped import Compass, KneedBiped

Array = NDArray[np.float64]
WAYS = ("leaves", "sticks", "slides forward", "slides backward")


class Solution(NamedTuple):
    """One way in which the impact can go: of the departing foot and of the landing one."""

    ways: tuple[str, str]
    rates: Array


class Landing:
    """A robot with straight legs whose second foot comes down while the first one stands.

    Args:
        robot: The robot.
        legs: Departing and landing leg from the vertical, rad.
        rates: Their rates before the impact, rad/s.
        slopes: Of the ground under either foot, rad.
    """

    def __init__(self, robot: Compass | KneedBiped, legs: Array, rates: Array, slopes: tuple[float, float]) -> None:
        self.robot, self.bodies = robot, FreeRobot(robot)
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
                found.append(Solution(ways, (self.before[:4] + pushed @ impulses)[2:]))
        return found


def holds(way: str, impulse: Array, speed: Array, friction: float, rounding: float) -> bool:
    """Whether the inequalities of a foot's way hold."""
    (p_n, p_t), (v_n, v_t) = impulse, speed
    if way == "leaves":
        return bool(v_n >= -rounding)
    if way == "sticks":
        return bool(p_n >= 0.0 and abs(p_t) <= friction * p_n)
    return bool(p_n >= 0.0 and (v_t > 0.0) == (way == "slides forward"))


@pytest.mark.parametrize("friction", [0.3, 0.8, 3.0])
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
        heel = gait.robot.impact if isinstance(gait.robot, Compass) else gait.robot.heel_impact
        # the integration's error, which the reference's table keeps
        assert found.rates == pytest.approx(heel(q, dq)[1][::-1], abs=1e-9)
