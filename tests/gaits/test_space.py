"""Passive gaits in space, and planar references whose roll is left to itself."""

import math
from pathlib import Path
from typing import Any

import golden_numbers
import numpy as np
import pytest
from command_line import ran

import mjbiped
from mjbiped.gaits.described import gait_from, reference_of
from mjbiped.gaits.space import step
from mjbiped.robots.in_space import InSpace, pull_of


def test_a_gait_is_found_and_drawn_on_the_command_line(tmp_path: Path) -> None:
    told = ran("gait", "--robot", "kneed3d", "--slope-deg", "3", "--plot", str(tmp_path / "gait.png"), "--json")
    assert (tmp_path / "gait.png").stat().st_size > 10_000
    for modulus in (8.168, 0.6444):
        assert f'"modulus": {modulus:.3f}'[:15] in told
    golden_numbers.check("gait in space with knees")


@pytest.mark.parametrize(
    "robot",
    [mjbiped.Compass3D(hip_width=0.2), pytest.param(mjbiped.Kneed3D(), marks=pytest.mark.slow)],
    ids=["wide", "knees"],
)
def test_a_gait_repeats_itself_and_its_trajectory_is_passive(robot: InSpace) -> None:
    """In the middle of the table's pieces the equations of motion hold to 1e-6 rad/s^2: of polynomials of degree 9."""
    slope = math.radians(2.5)
    gait = mjbiped.find_gait_in_space(robot, slope)
    half = len(robot.angles)
    places = gait.start[[0, half - 1, half, half + 1, -1]]
    np.testing.assert_allclose(step(robot, slope, places)[0], places, rtol=0, atol=1e-9)
    time = 0.37 * (gait.knee_strike or gait.period)
    q, dq, ddq = gait.reference(time)
    linkage = robot.in_space[half - 1]
    np.testing.assert_allclose(ddq, linkage.accelerations(np.zeros(half), q, dq, pull_of(slope)), rtol=0, atol=1e-6)
    assert gait_from(gait.describe()) == gait


def test_the_roll_beside_a_planar_reference_needs_no_torque_and_repeats_itself() -> None:
    robot = mjbiped.Compass3D()
    gait = reference_of(robot, clearance=0.06)
    planar = mjbiped.find_reference(robot.planar, clearance=0.06)  # type: ignore[arg-type]  # a compass
    np.testing.assert_array_equal(gait.reference(0.3)[0][:2], planar.reference(0.3)[0])
    q, dq, ddq = gait.reference(0.4)
    linkage = robot.in_space[2]
    forces = linkage.mass_matrix(q) @ ddq + linkage.coriolis_forces(q, dq) + linkage.gravity_forces(q) @ pull_of(0.0)
    assert forces[-1] == pytest.approx(0.0, abs=1e-5)
    after, rates = robot.impact(gait.end[:3], gait.end[3:])
    np.testing.assert_allclose([after[-1], rates[-1]], gait.start[[2, 5]], rtol=0, atol=1e-7)
    assert gait_from(gait.describe()) == gait


def test_the_figure_shows_a_straight_knee_after_its_strike() -> None:
    figure = mjbiped.plot_gait(mjbiped.find_gait_in_space(mjbiped.Kneed3D(), math.radians(3.0)))
    (panel,) = (axes for axes in figure.axes if axes.get_ylabel().startswith("flexion"))
    flexion = np.asarray(panel.lines[0].get_ydata())
    assert np.max(flexion) == pytest.approx(29.05, abs=0.01)
    assert flexion[-1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("find", "robot"),
    [
        (mjbiped.find_passive_gait, mjbiped.Compass3D()),
        (mjbiped.find_kneed_gait, mjbiped.Kneed3D()),
        (mjbiped.find_gait_in_space, mjbiped.KneedBiped()),
    ],
)
def test_each_robot_is_told_the_function_that_finds_its_gait(find: Any, robot: Any) -> None:
    with pytest.raises(mjbiped.InputError, match=r"find_passive_gait.*find_kneed_gait.*find_gait_in_space"):
        find(robot, 0.03)
