"""What all robots tell of themselves: widths, limbs, and descriptions in records."""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import InputError
from mjbiped.gaits.passive import find_rolling
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, tables_of, width
from mjbiped.robots.kinds import NAMED, robot_from, robot_named
from mjbiped.robots.kneed import stance_knee_torque
from mjbiped.robots.robot import Robot

KNEED = mjbiped.KneedBiped()
HALVED = mjbiped.KneedBiped.halved_rods()


@pytest.mark.parametrize(
    "robot",
    [
        mjbiped.Compass(hip_mass=3.0),
        HALVED,
        mjbiped.FootedCompass(underside="box", sole=(0.08, 0.13)),
        mjbiped.RoundCompass(foot_radius=0.3),
        mjbiped.RoundKneed(hip_mass=2.0, shank_mass=2.0, shank_length=0.6),
        mjbiped.RimlessWheel(spokes=9, inertia=0.7),
    ],
)
def test_a_description_is_the_robot(robot: Robot) -> None:
    assert robot_from(json.loads(json.dumps(robot.to_dict()))) == robot


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("leg_mass", lambda: mjbiped.Compass(leg_mass=0.0)),
        ("hip_mass", lambda: mjbiped.Compass(hip_mass=True)),
        ("shank_mass", lambda: mjbiped.KneedBiped(shank_mass=math.nan)),
        ("thigh_centre", lambda: mjbiped.KneedBiped(thigh_centre=0.6)),
        ("sole", lambda: mjbiped.FootedCompass(sole=None)),
        ("sole", lambda: mjbiped.FootedCompass(sole=(0.1, 0.0))),
        ("foot_mass", lambda: mjbiped.FootedCompass(foot_mass=4.9)),
        ("underside", lambda: mjbiped.FootedCompass(underside="pad")),
        ("foot_radius", lambda: mjbiped.RoundCompass(foot_radius=1.0)),
        ("spokes", lambda: mjbiped.RimlessWheel(spokes=4)),
        ("q: nan in it", lambda: mjbiped.Compass().mass_matrix([math.nan, 0])),
        ("dq: expected", lambda: mjbiped.Compass().coriolis_matrix([0.1, 0.2], 0.3)),
        (r"dq: expected shape", lambda: stance_knee_torque(KNEED, [0] * 3, [0] * 2, [0] * 3, 0, locked=False)),
        ("slope = inf", lambda: mjbiped.Compass().gravity_vector([0, 0], math.inf)),
        ("bent by 5.73 degrees", lambda: KNEED.knee_impact([0.1, 0.2, 0.3], [1, 1, 1])),
        ("rolls", lambda: mjbiped.RoundCompass().model),
        ("comes to a stop", lambda: find_rolling(mjbiped.RimlessWheel(), 0.01)),
    ],
)
def test_what_no_robot_can_have_is_refused(words: str, call: Callable[[], object]) -> None:
    with pytest.raises(mjbiped.MjbipedError, match=words):
        call()


def test_a_description_without_a_kind_is_a_compass() -> None:
    assert robot_from({"leg_mass": 4.0}) == mjbiped.Compass(leg_mass=4.0)
    with pytest.raises(InputError, match="kind of robot"):
        robot_from({"kind": "centipede"})
    with pytest.raises(TypeError, match="not by a list"):  # as damaged records have it
        robot_from(["a", "a"])  # type: ignore[arg-type]


def test_the_compass_has_its_columns_of_old() -> None:
    """Records of earlier versions stay readable: names and widths of format 2, and the columns of formats 4 and 6."""
    assert list(SAMPLES) == ["time", "q", "dq", "torque", "ankle_asked", "slope", "slope_estimate", "stance", "qpos"]
    assert (width(SAMPLES), width(TOUCHDOWNS)) == (15, 31)
    knees = tables_of(mjbiped.KneedBiped)
    assert list(knees.samples)[: len(SAMPLES)] == list(SAMPLES)
    assert list(knees.touchdowns)[: len(TOUCHDOWNS)] == list(TOUCHDOWNS)


def test_a_name_is_a_robot_whose_parameters_can_be_others() -> None:
    """Inertias of uniform rods follow masses and lengths unless they are given."""
    made = [robot_named(name, {}) for name in NAMED]
    assert [*map(robot_from, (robot.to_dict() for robot in made))] == made
    assert (made[0], made[-1]) == (mjbiped.Compass(), HALVED)
    assert robot_named("halved-rods", {"thigh_mass": 3.0}).to_dict()["thigh_inertia"] == 3.0 * 0.5**2 / 12
    assert robot_named("kneed", {"thigh_mass": 3.0, "thigh_inertia": 0.2}).to_dict()["thigh_inertia"] == 0.2
    with pytest.raises(InputError, match=r"parameter of the robot kneed 'leg_mass'.*thigh_mass"):
        robot_named("kneed", {"leg_mass": 3.0})
    with pytest.raises(InputError, match="unknown robot 'knead'"):
        robot_named("knead", {})


def test_defaults_are_table_one() -> None:
    robot = mjbiped.Compass()
    assert robot == mjbiped.Compass(5.0, 0.0, 0.5, 0.5, 5 / 12, 9.81, None)
    assert (robot.leg_length, robot.total_mass) == (1.0, 10.0)
    assert robot.weight == pytest.approx(98.1, rel=1e-12)
    assert robot.leg_inertia == pytest.approx(0.4167, abs=5e-5)  # Table I's digits
    np.testing.assert_array_equal(robot.input_matrix, [[1, -1], [0, 1]])
    assert replace(robot, leg_mass=1).leg_inertia == robot.leg_inertia
