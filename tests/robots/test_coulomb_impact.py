"""The impact of two feet with Coulomb friction, solved exactly: does the departing foot leave the ground freely?

Both impact maps, and both engines with them, take the departing foot for free. This test asks the law itself. Legs
are rigid in the impact (knees are locked), contacts plastic, and for either foot, of impulses p and speeds v after it,

    p_n >= 0,   v_n >= 0,   p_n v_n = 0;   |p_t| <= mu p_n, and p_t = -mu p_n sign(v_t) where it slides.

Sliding does not lift the foot: the law is not associated, unlike MuJoCo's convex one, which drags a foot that leaves
the ground at less than the angle of friction. The law is solved by looking at all ways in which two feet can leave,
stick or slide: each is a linear system, and those whose inequalities hold are the solutions. In the plane a foot slides
in one of two directions, in space in one of many, of which any that is near to the slip's own counts. The momenta are
those of free bodies, apart from the project's own equations; in space they are those of MuJoCo's bodies.
"""

import math
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from engines.conformance.free_bodies import FreeRobot
from numpy.typing import NDArray
from robots.test_space import floating

import mjbiped
from mjbiped import Compass, KneedBiped
from mjbiped.control.registry import make_controller
from mjbiped.engines.space.mujoco import TORSION
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.space import exchanged

Array = NDArray[np.float64]
IN_PLANE = np.array([[1.0], [-1.0]])
_TURNS = np.arange(0.0, 2.0 * math.pi, math.pi / 30)
IN_SPACE = np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
"""Directions in which a foot slides, shape (count, components along the ground)."""
NEAR = 0.9
"""Cosine of the angle between a slip and a direction that stands for it; directions in space are 6 degrees apart."""


class Solution(NamedTuple):
    """One way in which the impact can go: of the departing foot and of the landing one."""

    ways: tuple[str, str]
    rates: Array
    impulses: Array


def solved(pushed: Array, rows: Array, before: Array, friction: float, directions: Array) -> list[Solution]:
    """All solutions of an impact.

    Args:
        pushed: Changes of the rates under impulses on the feet, shape (n, 2 d): d for either foot, normal one first.
        rows: Speeds of both feet for given rates, in the same order, shape (2 d, n).
        before: Rates before the impact, shape (n,).
        friction: Of the ground.
        directions: In which a foot can slide, shape (count, d - 1).
    """
    A, closing, d = rows @ pushed, rows @ before, 1 + directions.shape[1]
    rounding = 1e-11 * np.abs(closing).max()
    found = []
    for ways in product(["leaves", "sticks", *directions], repeat=2):
        K, right = np.eye(2 * d), np.zeros(2 * d)
        for foot, way in enumerate(ways):
            n, t = d * foot, slice(d * foot + 1, d * foot + d)
            if isinstance(way, np.ndarray):
                K[n], right[n], K[t, n] = A[n], -closing[n], friction * way
            elif way == "sticks":
                K[n : n + d], right[n : n + d] = A[n : n + d], -closing[n : n + d]
        impulses = np.asarray(np.linalg.solve(K, right), dtype=np.float64)
        feet = zip(ways, impulses.reshape(2, d), (A @ impulses + closing).reshape(2, d), strict=True)
        if all(holds(way, impulse, speed, friction, rounding) for way, impulse, speed in feet):
            departs, lands = (way if isinstance(way, str) else "slides" for way in ways)
            found.append(Solution((departs, lands), before + pushed @ impulses, impulses))
    return found


def holds(way: str | Array, impulse: Array, speed: Array, friction: float, rounding: float) -> bool:
    """Whether the inequalities of a foot's way hold."""
    if isinstance(way, np.ndarray):
        return bool(impulse[0] >= 0.0 and way @ speed[1:] >= NEAR * np.linalg.norm(speed[1:]) > 0.0)
    if way == "leaves":
        return bool(speed[0] >= -rounding)
    return bool(impulse[0] >= 0.0 and np.linalg.norm(impulse[1:]) <= friction * impulse[0])


def solutions(robot: Compass | KneedBiped, legs: Array, rates: Array, slope: float, friction: float) -> list[Solution]:
    """All solutions of the impact of a robot with straight legs whose second foot comes down while the first stands.

    Args:
        robot: The robot.
        legs: Departing and landing leg from the vertical, rad.
        rates: Their rates before the impact, rad/s.
        slope: Of the ground, rad.
        friction: Of both feet.

    Returns:
        Each with the rates of both legs after the impact, rad/s.
    """
    bodies, whole = FreeRobot(robot), [0, 1, 1][: len(robot.angles)]  # the knee is straight
    qpos = np.array(robot.posture((0.0, 0.0), 0, legs[whole]))
    before = bodies.rates(qpos, 0, rates[whole], 0.0)[:4]
    feet = [end.jacobian(qpos) * np.exp(1j * slope) for end in bodies.ends]
    # speeds of both feet normal to the ground and along it, for rates of hip and legs
    rows = np.array([part for foot in feet for part in (foot.imag, foot.real)])[:, :4]
    pushed = np.linalg.solve(bodies.mass_matrix(qpos)[:4, :4], rows.T)
    return [each._replace(rates=each.rates[2:]) for each in solved(pushed, rows, before, friction, IN_PLANE)]


@pytest.mark.parametrize("friction", [0.3, 0.8, 3.0])
@pytest.mark.parametrize("slope_deg", [0.5, 2.0, 2.5])
def test_on_the_gaits_the_foot_leaves_freely_at_any_friction(slope_deg: float, friction: float) -> None:
    slope = math.radians(slope_deg)
    gaits: list[mjbiped.Gait | mjbiped.KneedGait] = [mjbiped.find_passive_gait(Compass(), slope)]
    if slope_deg == 2.5:
        gaits.append(mjbiped.find_kneed_gait(KneedBiped(), slope))
    for gait in gaits:
        q, dq, _ = (part[:2] for part in gait.reference(gait.period))
        (found,) = solutions(gait.robot, q + slope, dq, slope, friction)
        assert found.ways == ("leaves", "sticks")
        heel = gait.robot.impact if isinstance(gait.robot, Compass) else gait.robot.heel_impact
        # the integration's error, which the reference's table keeps
        assert found.rates == pytest.approx(heel(q, dq)[1][::-1], abs=1e-9)


@pytest.mark.parametrize(
    ("robot", "terrain"),
    [
        (mjbiped.Compass3D(), mjbiped.Terrain.level()),
        (mjbiped.Compass3D(), mjbiped.Terrain.incline(3.0)),
        (mjbiped.Compass3D(), mjbiped.Terrain.incline(0.0, lateral_deg=3.0)),
        (mjbiped.Kneed3D(), mjbiped.Terrain.incline(2.0, lateral_deg=1.0)),
    ],
    ids=["level", "down", "lateral", "knees"],
)
def test_in_space_the_foot_leaves_freely_while_friction_holds_the_yaw(robot: InSpace, terrain: mjbiped.Terrain) -> None:
    """Knees and yaw are held; the impulse that holds the yaw keeps within the torsional friction of 0.05 m."""
    walk = mjbiped.walk(make_controller("adaptive", robot, {}), terrain, engine="hybrid", steps=1, sample_period=None)
    steps, n = walk.touchdowns, len(robot.bodies.leg)
    straight = [0] * n + [1] * n + [-1]  # of the angles of the record, one for each segment
    q, dq = steps["q_before"][-1][straight], steps["dq_before"][-1][straight]
    model, data, to_joints = floating(robot, q, dq)
    mass, jacobian = np.zeros((model.nv, model.nv)), np.zeros((2, 3, model.nv))
    mujoco.mj_fullM(model, data, mass)
    for foot, side in zip(jacobian, ("right", "left"), strict=True):  # departing, landing
        mujoco.mj_jacGeom(model, data, foot, None, model.geom(f"{side}_foot").id)
    rows = jacobian[:, [2, 0, 1]].reshape(6, -1)
    names = ["yaw", *(f"{side}_knee" for side in ("left", "right") if n > 1)]
    held = np.eye(model.nv)[[model.joint(name).dofadr[0] for name in names]]
    whole = np.block([[mass, held.T], [held, np.zeros((len(held), len(held)))]])
    answer = np.linalg.solve(whole, np.vstack([rows.T, np.zeros((len(held), 6))]))
    (found,) = solved(answer[: -len(held)], rows, data.qvel, 0.8, IN_SPACE)
    assert found.ways == ("leaves", "sticks")
    angles = np.linalg.lstsq(to_joints[3:], found.rates[3:], rcond=None)[0]
    rates = exchanged(np.asarray(angles, dtype=np.float64))
    # MuJoCo's hip without a mass has 1e-6 kg
    np.testing.assert_allclose(rates[[0, *range(n, 2 * n), -1]], steps["dq"][-1], rtol=0, atol=1e-6)
    assert abs(answer[model.nv] @ found.impulses) < TORSION * found.impulses[3]
