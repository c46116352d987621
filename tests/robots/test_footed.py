"""The compass biped on feet with mass: what it is made of, what it refuses, and its equations while it stands flat."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from simulations import build_scene

import mjbiped
from mjbiped.robots.footed import FootedCompass

ROBOT = FootedCompass(hip_mass=3.0, lower_length=0.6, upper_length=0.4, sole=(0.08, 0.13), foot_mass=0.2)
ANGLES = st.floats(-0.6, 0.6)


def test_a_leg_and_its_foot_are_the_leg_of_a_compass() -> None:
    """Mass, place of the centre of mass, and inertia about it, by the sums over both bodies."""
    (leg,), foot = ROBOT.bodies.leg, ROBOT.foot
    masses, below_hip = np.array([leg.mass, foot.mass]), np.array([leg.centre, ROBOT.leg_length])
    centre = masses @ below_hip / masses.sum()
    assert masses.sum() == pytest.approx(ROBOT.leg_mass, rel=1e-15)
    assert centre == pytest.approx(ROBOT.upper_length, rel=1e-14)
    assert leg.inertia + masses @ (below_hip - centre) ** 2 == pytest.approx(ROBOT.leg_inertia, rel=1e-14)


MODEL = build_scene(ROBOT, mjbiped.Terrain.level(), timestep=1e-4, reach=1.0).model


@given(q1=ANGLES, q2=ANGLES, slope=st.floats(-0.2, 0.2), stance=st.sampled_from((0, 1)))
def test_places_are_those_of_mujoco(q1: float, q2: float, slope: float, stance: int) -> None:
    """The sole's points and the centre of mass; the feet are parallel to the slope."""
    data = mujoco.MjData(MODEL)
    posture = ROBOT.posture((0.3, 0.1), stance, (q1, q2), slope=slope)
    for name, place in zip(ROBOT.places, posture, strict=True):
        data.joint(name).qpos[:] = place
    mujoco.mj_forward(MODEL, data)
    outline = ROBOT.outline(posture)
    for side, name in enumerate(("left", "right")):
        for point, part in ((-2, "heel"), (-1, "toe")):
            np.testing.assert_allclose(outline[side, point], data.geom(f"{name}_{part}").xpos[[0, 2]], atol=1e-14)
    np.testing.assert_allclose(ROBOT.centre_of_mass(posture), data.subtree_com[0][[0, 2]], atol=1e-13)
    np.testing.assert_allclose(ROBOT.limbs(posture)[stance, -1], (0.3, 0.1), atol=1e-14)
    heel, toe = outline[stance, -2:]
    assert math.atan2(heel[1] - toe[1], toe[0] - heel[0]) == pytest.approx(slope, abs=1e-13)


def test_gaits_are_those_of_the_same_legs_on_the_same_soles() -> None:
    flat = ROBOT.flat
    assert type(flat) is mjbiped.Compass
    assert flat.sole == ROBOT.sole
    assert ROBOT.mechanism == replace(flat, sole=None)
    gait = mjbiped.find_passive_gait(ROBOT, 0.03)
    assert gait.start.tobytes() == mjbiped.find_passive_gait(flat, 0.03).start.tobytes()
