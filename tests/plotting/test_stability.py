"""The figure of Theorem 1 is complete and labelled, for one walk as for four, of one step or on changing slopes."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.stability import Stability, stability
from mjbiped.errors import InputError
from mjbiped.plotting.comparison import plot_stability


@pytest.fixture(scope="module")
def found(controller: AdaptiveController) -> Stability:
    terrain = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (9.0, -1.5, 0.0)])
    blind = replace(controller, initial_slope_estimate=math.radians(2), estimate_update=False, replanning_delay=None)
    return stability(mjbiped.walk(blind, terrain, engine="hybrid", steps=4, sample_period=0.01))


@pytest.mark.slow
def test_figure_shows_the_numbers(found: Stability, tmp_path: Path) -> None:
    path = tmp_path / "stability.png"
    figure = plot_stability({"a walk": found, "the same": found}, path)
    assert path.stat().st_size > 10_000
    over_time, errors, excitation, condition = figure.axes
    np.testing.assert_array_equal(over_time.lines[0].get_ydata(), found.lyapunov)
    np.testing.assert_array_equal(errors.lines[1].get_ydata(), np.linalg.norm(found.end, axis=1))
    np.testing.assert_array_equal(excitation.lines[1].get_ydata(), found.excitation[:, 1])
    np.testing.assert_array_equal(condition.lines[0].get_ydata(), found.condition)
    np.testing.assert_array_equal(condition.lines[1].get_ydata(), found.ratio)
    np.testing.assert_array_equal(condition.lines[4].get_ydata(), found.condition_floor)
    assert [text.get_text() for text in excitation.texts] == ["−1.5°"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a walk", "the same"]
    for axes in figure.axes:
        assert axes.get_xlabel()
        assert axes.get_ylabel()
        assert axes.get_title(loc="left")


def test_one_step_without_any_error(controller: AdaptiveController, tmp_path: Path) -> None:
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1)
    plot_stability({"exact": stability(walk)}, tmp_path / "stability.svg")
    assert (tmp_path / "stability.svg").stat().st_size > 10_000


def test_refusals(found: Stability, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="one to 4 walks, got 0"):
        plot_stability({})
    with pytest.raises(InputError, match="one to 4 walks, got 5"):
        plot_stability({str(number): found for number in range(5)})
    with pytest.raises(InputError, match="cannot draw to"):
        plot_stability({"a walk": found}, tmp_path / "stability.gif")
