"""Where hip, legs and swing foot of the biped with knees are, straight or bent, against the drawn robot's limbs."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL, hybrid_simulation

from mjbiped.engines.hybrid.events import pose_within
from mjbiped.engines.hybrid.state import Walk, hip, pose_of, swing_foot
from mjbiped.numerics.dormand_prince import dense_at
from mjbiped.numerics.records import in_one_block
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.kneed_equations import constants_of, limbs, stand
from mjbiped.terrain.terrain import Terrain

ROBOTS = [KneedBiped(), UNEQUAL]
angles = st.floats(-0.8, 0.8)
flexions = st.one_of(st.just(0.0), st.floats(0.05, 1.2))


@cache
def of(robot: KneedBiped) -> Walk:
    return hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=robot).plain


@given(st.sampled_from(ROBOTS), st.tuples(angles, angles, flexions), flexions, st.sampled_from([0, 1]), angles)
@settings(deadline=None, derandomize=True)
def test_hip_legs_and_foot_are_those_of_the_drawn_robot(
    robot: KneedBiped, posture: tuple[float, float, float], bent: float, stance: int, slope: float
) -> None:
    line, thigh, flexion = posture
    s, w = of(robot), of(robot).w
    w.stance, w.slope, w.foot_x, w.foot_z = stance, slope, 0.7, -0.3
    stand(s.c.robot, bent)
    pose = s.laws.pose((line, thigh, thigh + flexion), slope)
    qpos = [*hip(s, pose), *limbs(s.c.robot, w, (line, thigh, thigh + flexion))]
    length, _ = bent_leg(robot.thigh_length, robot.shank_length, bent)
    place = [0.7 + length * math.sin(line + slope), -0.3 + length * math.cos(line + slope)]
    assert qpos[:2] == pytest.approx(place, abs=1e-13)  # sums of some metres
    legs = robot.limbs(qpos)
    standing, swinging = legs[stance, -1], legs[1 - stance, -1]
    assert standing == pytest.approx([0.7, -0.3], abs=1e-13)
    assert swinging == pytest.approx(swing_foot(s, pose), abs=1e-13)
    assert robot.flexion(qpos, stance) == bent
    assert robot.flexion(qpos, 1 - stance) == pytest.approx(flexion, abs=1e-15)


@given(st.sampled_from(ROBOTS), flexions, flexions)
@settings(deadline=None, derandomize=True)
def test_a_leg_stands_as_if_it_had_never_stood_otherwise(robot: KneedBiped, first: float, then: float) -> None:
    changed, fresh = (constants_of(robot) for _ in range(2))
    for flexion in (first, then):
        stand(changed, flexion)
    if then:
        stand(fresh, then)
    for name in ("weights", "moments", "reach"):
        for chain in ("chain", "straight"):
            array, other = getattr(getattr(changed, chain), name), getattr(getattr(fresh, chain), name)
            # straight again, the sums of cosines of zero are the chain's own but for rounding
            np.testing.assert_allclose(array, other, rtol=0, atol=1e-13 * np.abs(other).max(), err_msg=name)
    np.testing.assert_allclose(changed.knee_before, fresh.knee_before, rtol=0, atol=1e-13)
    np.testing.assert_allclose(changed.stance, fresh.stance, rtol=0, atol=1e-12)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("bent", [0.0, 0.4])
def test_the_weights_of_the_knee_strike_lock_the_swing_knee(robot: KneedBiped, bent: float) -> None:
    """Those of three segments, of whose last two rows the sum stays: one body."""
    constants = constants_of(robot)
    stand(constants, bent)
    free = constants.chain.weights
    np.testing.assert_allclose(constants.knee_before, [free[0], free[1] + free[2]], rtol=0, atol=1e-15)


def test_compiled_functions_take_the_same_numbers_in_one_block() -> None:
    plain = constants_of(UNEQUAL)
    block = in_one_block(plain)
    assert block.shank == 2
    for name in ("legs", "about_end", "heel_before"):
        np.testing.assert_array_equal(block[name], getattr(plain, name))
    for name, values in vars(plain.whole).items():
        np.testing.assert_array_equal(block.whole[name], values)


def test_within_a_step_the_pose_follows_the_dense_output() -> None:
    simulation = hybrid_simulation(Terrain.incline(2.5), (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33))
    s, w = simulation.plain, simulation.state
    w.dense[:] = np.random.default_rng(0).normal(size=np.shape(w.dense)).tolist()
    assert pose_within(s, 1e-300) == pytest.approx(pose_within(s, 0.0), abs=1e-15)
    x, n = 0.3, len(w.y)
    state = [dense_at(w.dense, n, index, w.y[index], x) for index in range(3)]
    assert pose_within(s, x) == pose_of(s, state)
    assert pose_of(s, state)[:-1:2] == pytest.approx(np.sin(np.add(state, w.slope)).tolist(), abs=1e-15)
