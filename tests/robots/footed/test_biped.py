"""The compass biped on feet with mass: what it is made of, what it refuses, and its equations while it stands flat."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import GroundWindows
from mjbiped.errors import InputError
from mjbiped.robots.footed import FootedCompass
from mjbiped.robots.kinds import robot_from

ROBOT = FootedCompass(hip_mass=3.0, lower_length=0.6, upper_length=0.4, sole=(0.08, 0.13), foot_mass=0.2)
ANGLES = st.floats(-0.6, 0.6)


def model_of(robot: FootedCompass) -> mujoco.MjModel:
    ground = Ground(mjbiped.Terrain.level(), reach=1.0)
    return GroundWindows(robot, ground, timestep=1e-4, margin=1.0).about(0.0).model


def test_a_description_is_read_back() -> None:
    robot = replace(ROBOT, underside="box")
    assert robot_from(robot.to_dict()) == robot
    assert robot != ROBOT


def test_a_leg_and_its_foot_are_the_leg_of_a_compass() -> None:
    """Mass, place of the centre of mass, and inertia about it, by the sums over both bodies."""
    (leg,), foot = ROBOT.bodies.leg, ROBOT.foot
    masses, below_hip = np.array([leg.mass, foot.mass]), np.array([leg.centre, ROBOT.leg_length])
    centre = masses @ below_hip / masses.sum()
    assert masses.sum() == pytest.approx(ROBOT.leg_mass, rel=1e-15)
    assert centre == pytest.approx(ROBOT.upper_length, rel=1e-14)
    assert leg.inertia + masses @ (below_hip - centre) ** 2 == pytest.approx(ROBOT.leg_inertia, rel=1e-14)


@given(q1=ANGLES, q2=ANGLES, rate1=st.floats(-3.0, 3.0), rate2=st.floats(-3.0, 3.0), stance=st.sampled_from((0, 1)))
def test_flat_it_has_the_kinetic_energy_of_a_compass(
    q1: float, q2: float, rate1: float, rate2: float, stance: int
) -> None:
    """MuJoCo's mass matrix, for rates with which the stance foot stands and the other one stays parallel to it."""
    model = MODEL
    data = mujoco.MjData(model)
    posture = ROBOT.posture((0.3, 0.1), stance, (q1, q2), slope=0.05)
    moved = np.array(ROBOT.posture((0.0, 0.0), stance, (rate1, rate2)))  # linear in the angles behind the hip's place
    moved[:2] = ROBOT.leg_length * rate1 * np.array([math.cos(q1), -math.sin(q1)])
    rates = np.zeros(model.nv)
    for name, place, rate in zip(ROBOT.places, posture, moved, strict=True):
        address = model.joint(name).qposadr[0]
        data.qpos[address], rates[address] = place, rate
    mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    expected = ROBOT.kinetic_energy((q1, q2), (rate1, rate2))
    assert 0.5 * rates @ matrix @ rates == pytest.approx(expected, rel=1e-12, abs=1e-13)


MODEL = model_of(ROBOT)


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


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"sole": None}, r"sole = None: a FootedCompass stands on heel and toe"),
        ({"sole": (0.0, 0.1)}, r"both farther than 0 from the ankle"),
        ({"foot_mass": 4.9}, r"foot_mass = 4.9 kg: too heavy for a leg of 5 kg whose inertia"),
        ({"underside": "pad"}, r"unknown underside 'pad': valid are pads, box; did you mean 'pads'\?"),
        ({"ankle_height": 0.0}, r"ankle_height = 0"),
    ],
)
def test_it_refuses_feet_that_cannot_be(wrong: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        FootedCompass(**wrong)  # type: ignore[arg-type]  # that is what is tested
