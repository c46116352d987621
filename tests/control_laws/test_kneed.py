"""The adaptive law with knees: against the robot's matrices, the compass biped's law, and its references' shape."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mjbiped
from controllers import KneedController
from mjbiped.robots.chain import Array

ROBOT = mjbiped.KneedBiped()
GAIT = mjbiped.find_kneed_gait(ROBOT, math.radians(2.5))
LAW = KneedController(ROBOT, GAIT)
NEAR = st.floats(-0.3, 0.3)
STATES = st.tuples(*[NEAR] * 6)


def tracked(law: KneedController, memory: list[float], t: float) -> Array:
    """Angle, rate and acceleration (columns) of stance leg, swing thigh and swing shank (rows) that are tracked."""
    return np.array(law.reference_of(memory, t)).T


def memory_at(law: KneedController, start: Any = GAIT.start, slope: float = 0.03) -> list[float]:
    """The memory of a step that begins in a state, with an estimate of the slope."""
    memory = [0.0] * law.memory_size
    law.start(memory, tuple(start[:3]), tuple(start[3:]))
    memory[0], memory[1] = math.sin(slope), math.cos(slope)
    return memory


def test_a_locked_knee_tracks_the_gait_with_a_straight_knee() -> None:
    memory, t = memory_at(LAW), 0.8 * GAIT.period
    LAW.on_knee_strike(memory, t, GAIT.start[:3].tolist(), GAIT.start[3:].tolist())
    straight = np.array(GAIT.branch(t, bent=False))[:, [0, 1, 1]]
    np.testing.assert_allclose(tracked(LAW, memory, t), straight.T, rtol=0, atol=1e-12)


@given(STATES, st.floats(0.0, 1.0), st.booleans(), st.one_of(st.just(0.0), st.floats(0.05, 1.0)))
@settings(deadline=None)
def test_errors_obey_linear_equations_where_model_and_slope_are_true(
    away: tuple[float, ...], share: float, locked: bool, flexion: float
) -> None:
    """What (14) is for: ddz1 + (K1 + K2) dz1 + (K1 K2 + 1) z1 = 0, by the robot's own matrices, in both phases.

    So it is on a leg that stands bent since the last touchdown, too.
    """
    slope, t = 0.03, share * GAIT.period
    memory = memory_at(LAW, slope=slope)
    if flexion:
        bent = (*GAIT.end[:2], GAIT.end[1] + flexion)
        LAW.on_touchdown(memory, bent, tuple(GAIT.start[:3] + 0.02), tuple(GAIT.start[3:]))
        memory[0], memory[1] = math.sin(slope), math.cos(slope)
    wanted = tracked(LAW, memory, t)
    if locked:
        q, dq = wanted[:2, 0] + away[:2], wanted[:2, 1] + away[3:5]
        whole = [0, 1, 1]
        LAW.on_knee_strike(memory, t, tuple(q[whole]), tuple(dq[whole]))
        wanted = tracked(LAW, memory, t)[:2]
    else:
        q, dq, whole = wanted[:, 0] + away[:3], wanted[:, 1] + away[3:], [0, 1, 2]
    n, chain = len(q), ROBOT.chains_on(flexion)[len(q)]
    torque = np.array(LAW.torque(memory, t, tuple(q[whole]), tuple(dq[whole])))
    assert n == 3 or torque[2] == 0.0
    ddq = chain.accelerations(ROBOT.input_matrix[:n, :n] @ torque[:n], q, dq, slope)
    z, dz = wanted[:, 0] - q, wanted[:, 1] - dq
    expected = wanted[:, 2] + (5.0 * 12.0 + 1.0) * z + (5.0 + 12.0) * dz
    assert ddq == pytest.approx(expected, abs=1e-9)  # of some 1e2 rad/s^2, with a mass matrix of condition 1e3
    # (17): gamma z2' M^-1 of gravity's parts, which are its vector on level ground and on a wall
    z2 = np.linalg.solve(chain.mass_matrix(q), dz + 5.0 * z)
    parts = [z2 @ chain.gravity_vector(q, angle) for angle in (math.pi / 2, 0.0)]
    assert torque[3:] == pytest.approx(0.3 * np.array(parts), abs=1e-10)


@pytest.mark.parametrize("replanning", ["paper", "additive"])
def test_references_are_smooth_and_begin_where_the_robot_is(replanning: str) -> None:
    law = replace(LAW, replanning=replanning)
    start = GAIT.start + np.array([0.03, -0.02, -0.02, 0.1, -0.2, -0.2])
    memory = memory_at(law, start)
    begun = tracked(law, memory, 0.0)
    assert np.concatenate([begun[:, 0], begun[:, 1]]) == pytest.approx(start, abs=1e-9)
    end = 0.8 * GAIT.period
    h = 1e-5
    for t in np.linspace(2 * h, end - 2 * h, 30):
        before, here, after = (tracked(law, memory, t + k * h) for k in (-1, 0, 1))
        # central differences: third and fourth derivatives of 1e5 times h^2, and rounding over h
        assert (after[:, 0] - before[:, 0]) / (2 * h) == pytest.approx(here[:, 1], abs=1e-6)
        assert (after[:, 1] - before[:, 1]) / (2 * h) == pytest.approx(here[:, 2], abs=1e-5)
    there = tracked(law, memory, end + 1e-12).T
    for found, expected in zip(there, GAIT.branch(end, bent=True), strict=True):
        assert found == pytest.approx(expected, abs=1e-8)
    almost = tracked(law, memory, end - 1e-9).T
    assert almost[:2] == pytest.approx(there[:2], abs=1e-6)


@given(STATES, st.floats(0.0, 1.0))
@settings(deadline=None, derandomize=True)
def test_a_replanned_step_begins_as_the_passive_walker_moves(away: tuple[float, ...], flexion: float) -> None:
    """On the slope of the imitated gait, and on a leg that stands bent too, no motor does anything at first."""
    memory = memory_at(LAW)
    start = GAIT.start + np.array(away) + [0.0, 0.0, 0.0, 0.5, 0.0, 0.0]  # off the limit cycle
    LAW.on_touchdown(memory, (*GAIT.end[:2], GAIT.end[1] + flexion), tuple(start[:3]), tuple(start[3:]))
    memory[0], memory[1] = math.sin(GAIT.slope), math.cos(GAIT.slope)
    torque = LAW.torque(memory, 0.0, tuple(start[:3]), tuple(start[3:]))
    assert torque[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)  # of motions that take some 1e2 N m


def test_a_step_that_was_felt_lifts_the_knee() -> None:
    """5 rad per metre beside the half radian of a re-planned curve, at the bump's top in its middle."""
    q_before = GAIT.end[:3]
    t = 0.4 * GAIT.period
    shanks = []
    for height in (0.0, 0.04):
        memory = memory_at(LAW)
        swing = -math.acos(math.cos(q_before[0]) - height)
        LAW.on_touchdown(memory, (q_before[0], swing, swing), tuple(GAIT.start[:3] + 0.05), tuple(GAIT.start[3:]))
        shanks.append(tracked(LAW, memory, t)[2][0])
    assert shanks[1] - shanks[0] == pytest.approx(5.0 * 0.04, abs=1e-12)


def test_a_bump_that_lowers_the_foot_is_refused() -> None:
    with pytest.raises(mjbiped.InputError, match="knee_bump"):
        replace(LAW, knee_bump=-1.0)
