"""The figure of a gait with knees: what it shows, in both widths."""

import math
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from mjbiped.plotting.kneed import plot_kneed_gait
from mjbiped.plotting.width import figure_width


@pytest.mark.parametrize("width", ["single", "page"])
def test_panels(tmp_path: Path, width: str) -> None:
    gait = mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))
    with figure_width(width):
        figure = plot_kneed_gait(gait, tmp_path / "knees.pdf")
    assert (tmp_path / "knees.pdf").read_bytes().startswith(b"%PDF")
    postures, cycle, knee, foot = figure.axes
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
    assert np.asarray(knee.lines[0].get_ydata()).max() == pytest.approx(math.degrees(gait.greatest_flexion))
    assert np.asarray(foot.lines[1].get_ydata())[0] == pytest.approx(100 * gait.clearance)
    assert len(cycle.lines) == 10  # two parts of stance leg and thigh, one of the shank; five jumps


def test_the_file_is_the_same_each_time(tmp_path: Path) -> None:
    gait = mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))
    for name in ("a.svg", "b.svg"):
        plot_kneed_gait(gait, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
