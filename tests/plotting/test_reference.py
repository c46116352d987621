"""The figure of a reference: what it shows, in both widths."""

from pathlib import Path

import numpy as np
import pytest

import mjbiped
from mjbiped.plotting.reference import plot_reference
from mjbiped.plotting.width import figure_width


@pytest.mark.parametrize("width", ["single", "double"])
def test_panels(robot: mjbiped.Compass, tmp_path: Path, width: str) -> None:
    gait = mjbiped.find_reference(robot, clearance=0.06)
    with figure_width(width):
        figure = plot_reference(gait, tmp_path / "reference.pdf")
    cycle, foot, torques = figure.axes
    assert (tmp_path / "reference.pdf").read_bytes().startswith(b"%PDF")
    path = np.asarray(foot.get_lines()[0].get_xydata())
    assert path[0] == pytest.approx([-gait.step_length, 0.0], abs=1e-9)  # rounding of the table
    assert path[:, 1].max() == pytest.approx(gait.measures.greatest_clearance, abs=1e-5)  # 400 moments
    greatest = max(np.abs(np.asarray(line.get_ydata(), dtype=float)).max() for line in torques.get_lines()[:2])
    assert greatest == pytest.approx(max(gait.measures.peak_torque), rel=1e-6)
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in (cycle, foot, torques))
