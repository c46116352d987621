"""The biped with knees: what it is made of, and its impacts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from simulations import UNEQUAL

import mjbiped
from mjbiped.errors import InputError
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped

ROBOTS = [
    KneedBiped(),
    KneedBiped.halved_rods(),
    UNEQUAL,
]


def compass_of(robot: KneedBiped) -> Compass:
    """The compass biped whose legs are this robot's straight ones, by the theorem of parallel axes."""
    thigh, shank = robot.thigh_mass, robot.shank_mass
    low, high = robot.shank_length - robot.shank_centre, robot.leg_length - robot.thigh_centre
    centre = (shank * low + thigh * high) / (shank + thigh)
    inertia = robot.shank_inertia + robot.thigh_inertia + shank * (low - centre) ** 2 + thigh * (high - centre) ** 2
    return Compass(shank + thigh, robot.hip_mass, centre, robot.leg_length - centre, inertia, robot.gravity)


def test_the_halved_rods_are_the_legs_of_table_one() -> None:
    halved, compass = compass_of(KneedBiped.halved_rods()), Compass()
    assert (halved.leg_mass, halved.hip_mass, halved.lower_length) == (compass.leg_mass, 0.0, compass.lower_length)
    assert halved.leg_inertia == pytest.approx(compass.leg_inertia, rel=1e-15)


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


def test_a_knee_that_is_bent_strikes_nothing() -> None:
    with pytest.raises(InputError, match=r"bent by 5.73 degrees: it strikes its stop where it is straight"):
        KneedBiped().knee_impact([0.1, 0.2, 0.3], [1, 1, 1])


def test_defaults_and_names() -> None:
    robot = KneedBiped()
    assert mjbiped.KneedBiped is KneedBiped
    assert robot == KneedBiped(4.5, 0.5, 5.0, 0.5, 0.5, 0.3, 0.09)
    assert (robot.leg_length, robot.total_mass, robot.weight) == (1.0, 15.0, 15 * 9.81)
    assert (robot.thigh_inertia, robot.shank_inertia) == (4.5 * 0.25 / 12, 0.5 * 0.25 / 12)
    assert replace(robot, thigh_mass=1).thigh_inertia == robot.thigh_inertia
    assert hash(robot) == hash(KneedBiped(thigh_mass=np.float32(4.5)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "bad", "words"),
    [
        ("thigh_mass", 0.0, "from 1e-09"),
        ("shank_mass", math.nan, "finite"),
        ("hip_mass", -1.0, "from 0 to"),
        ("shank_length", "1", "finite"),
        ("thigh_inertia", -1.0, "from 0 to"),
        ("gravity", 0.0, "from 0.001"),
        ("thigh_centre", 0.6, "must lie on the link, at most thigh_length = 0.5 m"),
        ("shank_centre", 0.51, "must lie on the link, at most shank_length = 0.5 m"),
    ],
)
def test_parameters_outside_their_domain_are_named(name: str, bad: object, words: str) -> None:
    with pytest.raises(InputError, match=rf"{name} = .*{words}"):
        KneedBiped(**{name: bad})  # type: ignore[arg-type]


def test_the_flexion_is_that_of_the_named_leg() -> None:
    robot = KneedBiped()
    qpos = [robot.posture((0.0, 0.0), stance, (-0.2, 0.3, 0.7), 0.1) for stance in (0, 1)]
    assert robot.flexion(qpos, [0, 1]) == pytest.approx([0.1, 0.1], abs=1e-15)  # the stance leg's
    assert robot.flexion(qpos, [1, 0]) == pytest.approx([0.4, 0.4], abs=1e-15)
