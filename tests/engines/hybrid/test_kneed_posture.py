"""Where hip, legs and swing foot of the biped with knees are, straight or bent, against the drawn robot's limbs."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL, hybrid_simulation

from mjbiped.engines.hybrid import kneed_posture
from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.simulation import HybridSimulation
from mjbiped.numerics.dormand_prince import dense_at
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

ROBOTS = [KneedBiped(), UNEQUAL]
angles = st.floats(-0.8, 0.8)
flexions = st.one_of(st.just(0.0), st.floats(0.05, 1.2))


@cache
def of(robot: KneedBiped) -> HybridSimulation:
    return hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=robot)


@given(st.sampled_from(ROBOTS), st.tuples(angles, angles, flexions), flexions, st.sampled_from([0.0, 1.0]), angles)
@settings(deadline=None, derandomize=True)
def test_hip_legs_and_foot_are_those_of_the_drawn_robot(
    robot: KneedBiped, posture: tuple[float, float, float], bent: float, stance: float, slope: float
) -> None:
    line, thigh, flexion = posture
    constants, b = of(robot).constants, of(robot).buffers
    b.w[at.STANCE], b.w[at.SLOPE], b.w[at.FOOT_X], b.w[at.FOOT_Z] = stance, slope, 0.7, -0.3
    kneed_posture.stand(constants.robot, bent)
    state = [line, thigh, thigh + flexion]
    pose = kneed_posture.pose(b, state)
    qpos = [*kneed_posture.hip(constants, b, pose), *kneed_posture.sides(constants.robot, b.w, *state)]
    length, _ = bent_leg(robot.thigh_length, robot.shank_length, bent)
    hip = [0.7 + length * math.sin(line + slope), -0.3 + length * math.cos(line + slope)]
    assert qpos[:2] == pytest.approx(hip, abs=1e-13)  # sums of some metres
    legs = robot.limbs(qpos)
    standing, swinging = legs[int(stance), -1], legs[1 - int(stance), -1]
    assert standing == pytest.approx([0.7, -0.3], abs=1e-13)
    assert swinging == pytest.approx(kneed_posture.swing_foot(constants, b, pose), abs=1e-13)
    assert robot.flexion(qpos, stance) == bent
    assert robot.flexion(qpos, 1.0 - stance) == pytest.approx(flexion, abs=1e-15)


@given(st.sampled_from(ROBOTS), flexions, flexions)
@settings(deadline=None, derandomize=True)
def test_a_leg_stands_as_if_it_had_never_stood_otherwise(robot: KneedBiped, first: float, then: float) -> None:
    changed, fresh = (kneed_posture.constants_of(robot) for _ in range(2))
    for flexion in (first, then):
        kneed_posture.stand(changed, flexion)
    if then:
        kneed_posture.stand(fresh, then)
    for name, array, other in zip(changed._fields, changed, fresh, strict=True):
        # straight again, the sums of cosines of zero are the chain's own but for rounding
        np.testing.assert_allclose(array, other, rtol=0, atol=1e-13 * max(1.0, np.abs(other).max()), err_msg=name)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("bent", [0.0, 0.4])
def test_the_weights_of_the_knee_strike_lock_the_swing_knee(robot: KneedBiped, bent: float) -> None:
    """Those of three segments, of whose last two rows the sum stays: one body."""
    constants = kneed_posture.constants_of(robot)
    kneed_posture.stand(constants, bent)
    free = constants.free_weights
    np.testing.assert_allclose(constants.knee_before, [free[0], free[1] + free[2]], rtol=0, atol=1e-15)


def test_compiled_functions_take_the_same_numbers_in_one_block() -> None:
    plain, block = (kneed_posture.constants_of(UNEQUAL, compiled) for compiled in (False, True))
    for name in plain._fields:
        np.testing.assert_array_equal(
            np.asarray(block[name]).reshape(np.shape(getattr(plain, name))), getattr(plain, name)
        )


def test_within_a_step_the_pose_follows_the_dense_output() -> None:
    simulation = hybrid_simulation(Terrain.incline(2.5), (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33))
    b = simulation.buffers
    b.dense[:] = np.random.default_rng(0).normal(size=np.shape(b.dense)).tolist()
    assert kneed_posture.pose_between(b, 0.0) == pytest.approx(kneed_posture.pose(b, b.y), abs=1e-15)
    x, n = 0.3, len(b.y)
    state = [dense_at(b.dense, n, index, b.y[index], x) for index in range(3)]
    assert kneed_posture.pose_between(b, x) == kneed_posture.pose(b, state)
    assert kneed_posture.pose(b, state)[::2] == pytest.approx(np.sin(np.add(state, b.w[at.SLOPE])).tolist(), abs=1e-15)
