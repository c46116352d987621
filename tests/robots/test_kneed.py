"""The biped with knees: what it is made of, the strike of a knee, and the torque that holds the stance knee."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL

from mjbiped.dynamics.modes import bent_leg
from mjbiped.robots.kneed import KneedBiped, stance_knee_torque

ROBOTS = [KneedBiped(), KneedBiped.halved_rods(), UNEQUAL]


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_knee_impact_is_the_impulse_that_stops_the_knee(robot: KneedBiped) -> None:
    """By a multiplier: an impulse between thigh and shank, equal and opposite, that makes their rates equal."""
    random = np.random.default_rng(3)
    for _ in range(20):
        q1, q2 = random.uniform(-1, 1, 2)
        q, dq = np.array([q1, q2, q2]), random.uniform(-5, 5, 3)
        M, between = robot.mass_matrix(q), np.array([0.0, 1.0, -1.0])
        turn = np.linalg.solve(M, between)
        expected = dq - turn * (between @ dq) / (between @ turn)
        q_plus, dq_plus = robot.knee_impact(q, dq)
        np.testing.assert_array_equal(q_plus, [q1, q2])
        # linear systems with condition numbers up to 1e3
        np.testing.assert_allclose(dq_plus, expected[:2], rtol=0, atol=1e-11)
        assert expected[2] == pytest.approx(expected[1], abs=1e-11)
        # what the impulse cannot change: the momentum about the stance foot, and that of the swing leg about the hip
        after = robot.mass_matrix(q_plus) @ dq_plus
        before = M @ dq
        scale = 1e-11 * np.abs(robot.chains[3].weights).max()
        assert after.sum() == pytest.approx(before.sum(), abs=scale)
        assert after[1] == pytest.approx(before[1] + before[2], abs=scale)
        assert robot.kinetic_energy(q_plus, dq_plus) < robot.kinetic_energy(q, dq)


def test_the_flexion_is_that_of_the_named_leg() -> None:
    robot = KneedBiped()
    qpos = [robot.posture((0.0, 0.0), stance, (-0.2, 0.3, 0.7), 0.1) for stance in (0, 1)]
    assert robot.flexion(qpos, [0, 1]) == pytest.approx([0.1, 0.1], abs=1e-15)  # the stance leg's
    assert robot.flexion(qpos, [1, 0]) == pytest.approx([0.4, 0.4], abs=1e-15)


triples = st.tuples(*[st.floats(-1.2, 1.2)] * 3)
fast = st.tuples(*[st.floats(-5, 5)] * 3)
strong = st.tuples(*[st.floats(-60, 60)] * 3)


@given(st.sampled_from(ROBOTS), triples, fast, strong, st.floats(-0.3, 0.3), st.booleans(), st.floats(0.0, 1.2))
@settings(deadline=None, derandomize=True)
def test_it_is_the_multiplier_of_the_lock(
    robot: KneedBiped,
    q: tuple[float, float, float],
    dq: tuple[float, float, float],
    torque: tuple[float, float, float],
    slope: float,
    locked: bool,
    flexion: float,
) -> None:
    """The chain of four segments, its motors between them, with a row for each joint that keeps its angle."""
    rates = (dq[0], dq[1], dq[1]) if locked else dq
    found = stance_knee_torque(robot, q, rates, torque, slope, locked=locked, stance_flexion=flexion)
    _, lean = bent_leg(robot.thigh_length, robot.shank_length, flexion)
    angles = np.array([q[0] + lean, q[0] + lean - flexion, q[1], q[2]])
    turning = np.array([rates[0], *rates])
    ankle, hip, knee = torque
    forces = np.array([ankle, 0.0, 0.0, 0.0]) + hip * np.array([0, -1, 1, 0]) + knee * np.array([0, 0, -1, 1])
    forces -= robot.coriolis_matrix(angles, turning) @ turning + robot.gravity_vector(angles, slope)
    held = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])[: 2 if locked else 1]  # thigh on, shank back
    none = np.zeros((len(held), len(held)))
    whole = np.block([[robot.mass_matrix(angles), -held.T], [held, none]])
    multipliers = np.linalg.solve(whole, np.concatenate([forces, np.zeros(len(held))]))[4:]
    # rounding of some dozens of operations, of the largest force, through a condition number of up to 1e3
    assert found == pytest.approx(multipliers[0], abs=1e-9 * (1.0 + np.abs(forces).max()))


def test_the_halved_rods_are_the_legs_of_table_one() -> None:
    thigh, shank = KneedBiped.halved_rods().bodies.leg
    assert (thigh.mass + shank.mass, thigh.length + shank.length) == (5.0, 1.0)
    assert thigh.inertia + shank.inertia + 5.0 * 0.25**2 == pytest.approx(5.0 / 12)
