"""Figures of many gaits: complete, labelled with units, and written whole."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from mjbiped.errors import InputError
from mjbiped.limit_cycles.basin import Basin, Fate, basin_of_attraction
from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade, bifurcation_diagram, find_cascade
from mjbiped.plotting.gaits import plot_basins, plot_bifurcation, plot_multipliers
from mjbiped.robots.compass import Compass


@pytest.fixture(scope="module")
def cascade(robot: Compass) -> Cascade:
    return find_cascade(robot, 2)


@pytest.fixture(scope="module")
def diagram(robot: Compass) -> BifurcationDiagram:
    return bifurcation_diagram(robot, np.radians(np.linspace(2.6, 3.7, 23)), steps=100, keep=20)


@pytest.fixture(scope="module")
def basin(robot: Compass) -> Basin:
    rates = np.linspace(0.9, 1.3, 12), np.linspace(-0.5, 1.5, 9)
    return basin_of_attraction(robot, math.radians(2), stance_rates=rates[0], swing_rates=rates[1])


def labels(figure: Figure) -> str:
    axes = figure.get_axes()
    texts = [text.get_text() for one in axes for text in one.texts]
    return "\n".join([*(one.get_xlabel() + one.get_ylabel() + one.get_title("left") for one in axes), *texts])


def test_bifurcation(diagram: BifurcationDiagram, cascade: Cascade, tmp_path: Path) -> None:
    figure = plot_bifurcation(diagram, cascade, tmp_path / "diagram.png")
    assert (tmp_path / "diagram.png").stat().st_size > 10_000
    shown = labels(figure)
    # in chaos the last bits of gravity decide whether 100 steps on 3.60° come through, or the first fall is on 3.65°
    for text in ("slope (°)", "step length (m)", "period 2: 2.7284°", "period 4: 3.2986°", "first fall on 3.6"):
        assert text in shown
    # every step kept, on its slope: those of periodic walking, and behind them the others
    others, periodic = (np.asarray(line.get_xydata()) for line in figure.get_axes()[0].lines[:2])
    assert len(periodic) == np.count_nonzero(diagram.counts()) * diagram.step_lengths.shape[1]
    slopes = np.repeat(np.degrees(diagram.slopes), diagram.step_lengths.shape[1])
    kept = np.column_stack([slopes, diagram.step_lengths.ravel()])
    np.testing.assert_array_equal(np.sort(np.concatenate([others, periodic]), axis=0), np.sort(kept, axis=0))


def test_the_unstable_gait_of_period_one_begins_at_its_onset(diagram: BifurcationDiagram, cascade: Cascade) -> None:
    """And goes on beyond both ends of the magnified panel."""
    onset = cascade.branches[0].doubling
    assert onset is not None
    whole, magnified = (axes.lines[2] for axes in plot_bifurcation(diagram, cascade).get_axes())
    for line in (whole, magnified):
        points = np.asarray(line.get_xydata())
        assert points[0].tolist() == [math.degrees(onset.slope), onset.step_lengths[0]]
    assert magnified.axes is not None
    low, high = magnified.axes.get_xlim()
    assert points[0, 0] < low < high < points[-1, 0]


def test_multipliers(cascade: Cascade, tmp_path: Path) -> None:
    figure = plot_multipliers([branch.gaits for branch in cascade.branches], tmp_path / "multipliers.svg")
    assert (tmp_path / "multipliers.svg").exists()
    magnitudes, _ = figure.get_axes()
    shown = np.array([line.get_ydata() for line in magnitudes.lines[:3]])
    gaits = cascade.branches[0].gaits
    np.testing.assert_array_equal(shown.max(axis=0), [abs(gait.multipliers).max() for gait in gaits])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["period 1", "period 2"]
    with pytest.raises(InputError, match="at least two"):
        plot_multipliers([gaits[:1]])


def test_basin(basin: Basin, tmp_path: Path) -> None:
    figure = plot_basins([basin], tmp_path / "basin.png")
    shown = labels(figure)
    assert (tmp_path / "basin.png").stat().st_size > 10_000
    for text in ("(rad/s)", "steps until settled", "passive on 2° down", f"{100 * basin.share(Fate.SETTLED):.1f} %"):
        assert text in shown


def test_basin_with_torques_and_with_nothing_settled(basin: Basin) -> None:
    controlled = dataclasses.replace(basin, peak_torque=np.full(basin.fates.shape, 3.0), slope=0.0)
    assert "torque on the way (N m)" in labels(plot_basins([basin, controlled]))
    for fate in (Fate.FELL, Fate.UNDECIDED, Fate.SETTLED):
        plot_basins([dataclasses.replace(basin, fates=np.full_like(basin.fates, fate))])
    with pytest.raises(InputError, match="one or two"):
        plot_basins([])


def test_wrong_suffix_is_refused_before_anything_is_drawn(basin: Basin) -> None:
    with pytest.raises(InputError, match=r"\.png"):
        plot_basins([basin], Path("basin.jpeg"))


def test_what_settles_is_darker_than_what_falls_in_grey(basin: Basin) -> None:
    figure = plot_basins([basin])
    falls, settled = (axes.cmap(np.linspace(0.0, 1.0, 256)) for axes in figure.get_axes()[0].collections[:2])
    luma = [colours[:, :3] @ (0.299, 0.587, 0.114) for colours in (falls, settled)]  # Rec. 601, as pictures are printed
    assert luma[0].min() > luma[1].max() + 0.1
    (legend,) = figure.legends
    assert not figure.get_axes()[0].get_legend()
    shown = [text.get_text() for text in legend.get_texts()]
    assert shown == ["the gait", "falls at once", "falls after 6 steps or more"]
    undecided = dataclasses.replace(basin, fates=np.full_like(basin.fates, Fate.UNDECIDED))
    assert [text.get_text() for text in plot_basins([undecided]).legends[0].get_texts()][-1] == "neither"
