"""Where hip, legs and swing foot of the biped with knees are, straight or bent, against the drawn robot's limbs."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL, hybrid_simulation

from mjbiped.dynamics.integrate import value_at
from mjbiped.dynamics.linkage import Motion, room, stand
from mjbiped.dynamics.modes import FREE, bend_stance_knee
from mjbiped.engines.hybrid.meeting import write_angles_at
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.records import write_posture
from mjbiped.engines.hybrid.run import HybridRun
from mjbiped.engines.hybrid.state import swing_foot
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

ROBOTS = [KneedBiped(), UNEQUAL]
angles = st.floats(-0.8, 0.8)
flexions = st.one_of(st.just(0.0), st.floats(0.05, 1.2))


@cache
def of(robot: KneedBiped) -> HybridRun:
    return hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=robot)


@given(st.sampled_from(ROBOTS), st.tuples(angles, angles, flexions), flexions, st.sampled_from([0, 1]), angles)
@settings(deadline=None, derandomize=True)
def test_hip_legs_and_foot_are_those_of_the_drawn_robot(
    robot: KneedBiped, posture: tuple[float, float, float], bent: float, stance: int, slope: float
) -> None:
    line, thigh, flexion = posture
    c, w, y = of(robot).constants, of(robot).state, [line, thigh, thigh + flexion]
    w.stance, w.slope, w.sine, w.cosine, w.foot_x, w.foot_z = stance, slope, math.sin(slope), math.cos(slope), 0.7, -0.3
    w.locked, w.stance_flexion = FREE, bent
    bend_stance_knee(w, c.upper, c.lower, bent)
    enter_mode(c, w)
    write_posture(c, w, y)
    qpos = w.posture[:6]
    length, _ = bent_leg(robot.thigh_length, robot.shank_length, bent)
    place = [0.7 + length * math.sin(line + slope), -0.3 + length * math.cos(line + slope)]
    assert qpos[:2] == pytest.approx(place, abs=1e-13)  # sums of some metres
    legs = robot.limbs(qpos)
    standing, swinging = legs[stance, -1], legs[1 - stance, -1]
    assert standing == pytest.approx([0.7, -0.3], abs=1e-13)
    assert swinging == pytest.approx(swing_foot(c, w, y), abs=1e-13)
    assert robot.flexion(qpos, stance) == bent
    assert robot.flexion(qpos, 1 - stance) == pytest.approx(flexion, abs=1e-15)


@given(st.sampled_from(ROBOTS), flexions, flexions)
@settings(deadline=None, derandomize=True)
def test_a_leg_stands_as_if_it_had_never_stood_otherwise(robot: KneedBiped, first: float, then: float) -> None:
    changed, fresh = (Motion(free=3, **room()) for _ in range(2))
    for flexion in (first, then):
        bend_stance_knee(changed, robot.thigh_length, robot.shank_length, flexion)
        stand(robot.linkages[0], changed)
    bend_stance_knee(fresh, robot.thigh_length, robot.shank_length, then)
    stand(robot.linkages[0], fresh)
    assert changed == fresh


def test_within_a_step_the_angles_follow_the_dense_output() -> None:
    simulation = hybrid_simulation(Terrain.incline(2.5), (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33))
    c, w = simulation.constants, simulation.state
    w.dense[:] = np.random.default_rng(0).normal(size=np.shape(w.dense)).tolist()
    for x in (0.0, 1e-300):
        write_angles_at(c, w, x)
        assert w.spare[:3] == pytest.approx(w.y[:3], abs=1e-15)
    write_angles_at(c, w, 0.3)
    assert w.spare[:3] == [value_at(c, w, index, 0.3) for index in range(3)]
