"""Figures of gaits: what they show, at several widths."""

import math
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from mjbiped.plotting import figure_width
from mjbiped.plotting.gait import plot_gait


@pytest.mark.slow
@pytest.mark.parametrize("width", ["single", "page"])
def test_panels_with_knees(tmp_path: Path, width: str) -> None:
    gait = mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))
    with figure_width(width):
        figure = plot_gait(gait, tmp_path / "knees.pdf")
    assert (tmp_path / "knees.pdf").read_bytes().startswith(b"%PDF")
    postures, cycle, foot, knee, _ = figure.axes
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)
    assert "clearance 2.56\u00a0cm" in figure.get_suptitle().replace("\n", " ")
    # each posture: stance leg, thigh, shank, knees, hip; then the ground
    times = [text.get_text() for text in postures.texts]
    assert len(postures.lines) == 5 * len(times) + 1
    assert (times[0], times[-1]) == ("0.000 s", "0.615 s")
    assert "0.527 s\nknee strike" in times
    thigh, shank = (np.asarray(line.get_xydata()) for line in postures.lines[1:3])
    assert np.hypot(*(thigh[1] - thigh[0])) == pytest.approx(0.5)
    assert np.hypot(*(shank[1] - shank[0])) == pytest.approx(0.5)
    # at the start the swing foot stands on the slope, behind the stance foot
    np.testing.assert_allclose(shank[1], gait.step_length * np.array([-1, math.tan(gait.slope)]), rtol=2e-3)
    greatest = np.asarray(knee.lines[0].get_ydata()).max()
    assert greatest == pytest.approx(math.degrees(gait.greatest_flexion), rel=1e-4)  # of 400 moments
    assert np.asarray(foot.lines[2].get_ydata())[0] == pytest.approx(100 * gait.clearance, rel=1e-4)
    assert len(cycle.lines) == 10  # two parts of stance leg and thigh, one of the shank; five jumps


def test_the_file_is_the_same_each_time(tmp_path: Path) -> None:
    gait = mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))
    for name in ("a.svg", "b.svg"):
        plot_gait(gait, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("width", ["single", "double"])
def test_panels_of_a_reference(robot: mjbiped.Compass, tmp_path: Path, width: str) -> None:
    gait = mjbiped.find_reference(robot, clearance=0.06)
    with figure_width(width):
        figure = plot_gait(gait, tmp_path / "reference.pdf")
    _, cycle, foot, torques = figure.axes
    assert (tmp_path / "reference.pdf").read_bytes().startswith(b"%PDF")
    path = np.asarray(foot.get_lines()[0].get_xydata()) / (1.0, 100.0)
    assert path[0] == pytest.approx([-gait.step_length, 0.0], abs=1e-9)  # rounding of the table
    assert path[:, 1].max() == pytest.approx(gait.measures.greatest_clearance, abs=1e-5)  # 400 moments
    greatest = max(np.abs(np.asarray(line.get_ydata(), dtype=float)).max() for line in torques.get_lines()[:2])
    assert greatest == pytest.approx(max(gait.measures.peak_torque), rel=1e-6)
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in (cycle, foot, torques))
