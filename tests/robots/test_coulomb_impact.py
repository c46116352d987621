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

import numpy as np
import pytest
from engines.conformance.free_bodies import FreeRobot
from numpy.typing import NDArray

import mjbiped
from mjbiped import Compass, KneedBiped

Array = NDArray[np.float64]
WAYS = ("leaves", "sticks", "slides forward", "slides backward")


def solutions(
    robot: Compass | KneedBiped, legs: Array, rates: Array, slope: float, friction: float
) -> list[tuple[tuple[str, str], Array]]:
    """All solutions of the impact of a robot with straight legs whose second foot comes down while the first stands.

    Args:
        robot: The robot.
        legs: Departing and landing leg from the vertical, rad.
        rates: Their rates before the impact, rad/s.
        slope: Of the ground, rad.
        friction: Of both feet.

    Returns:
        The ways of departing and landing foot, and the rates of both legs after the impact, rad/s.
    """
    bodies, whole = FreeRobot(robot), [0, 1, 1][: len(robot.angles)]  # the knee is straight
    qpos = np.array(robot.posture((0.0, 0.0), 0, legs[whole]))
    before = bodies.rates(qpos, 0, rates[whole], 0.0)[:4]
    feet = [end.jacobian(qpos) * np.exp(1j * slope) for end in bodies.ends]
    # speeds of both feet normal to the ground and along it, for rates of hip and legs
    rows = np.array([part for foot in feet for part in (foot.imag, foot.real)])[:, :4]
    pushed = np.linalg.solve(bodies.mass_matrix(qpos)[:4, :4], rows.T)
    A, closing = rows @ pushed, rows @ before
    rounding, found = 1e-11 * np.abs(closing).max(), []
    for ways in product(WAYS, WAYS):
        K, right = np.eye(4), np.zeros(4)
        for n, way in zip((0, 2), ways, strict=True):
            if way != "leaves":
                K[n], right[n] = A[n], -closing[n]
            if way == "sticks":
                K[n + 1], right[n + 1] = A[n + 1], -closing[n + 1]
            elif way != "leaves":
                K[n + 1, n] = friction if way == "slides forward" else -friction
        impulses = np.asarray(np.linalg.solve(K, right), dtype=np.float64)
        each = zip(ways, impulses.reshape(2, 2), (A @ impulses + closing).reshape(2, 2), strict=True)
        if all(holds(way, impulse, speed, friction, rounding) for way, impulse, speed in each):
            found.append((ways, (before + pushed @ impulses)[2:]))
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
        ((ways, after),) = solutions(gait.robot, q + slope, dq, slope, friction)
        assert ways == ("leaves", "sticks")
        heel = gait.robot.impact if isinstance(gait.robot, Compass) else gait.robot.heel_impact
        # the integration's error, which the reference's table keeps
        assert after == pytest.approx(heel(q, dq)[1][::-1], abs=1e-9)
