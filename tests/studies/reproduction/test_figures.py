"""Figures 5, 6 and Table III: they show what the records hold."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import mjbiped
from mjbiped.errors import InputError
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.style import TRUTH
from mjbiped.studies.reproduction import reproduce
from mjbiped.studies.reproduction.cell import cell, row
from mjbiped.studies.reproduction.figures import plot_figure_5, plot_figure_6, plot_table_3
from mjbiped.studies.reproduction.results import row_of
from mjbiped.studies.reproduction.section_5 import adaptive


@pytest.fixture(scope="module")
def walks() -> list[mjbiped.Walk]:
    """Over a change of slope from rest, with the update and without."""
    ground = mjbiped.Terrain.slopes(length=0.8, change_deg=2.0)
    return [
        cell(ground, adaptive(0.8, estimate_update=update), steps=5, engine="hybrid", initial="rest").walk(5e-3)
        for update in (True, False)
    ]


def test_figure_5_has_a_row_for_each_gamma_and_a_curve_for_each_walk(walks: list[mjbiped.Walk], tmp_path: Path) -> None:
    curves = {(3.0, True): walks[0], (3.0, False): walks[1], (-3.0, True): walks[1], (-3.0, False): walks[0]}
    figure = plot_figure_5(dict.fromkeys((0.3, 3.0), curves), tmp_path / "five.png")
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["(a) γ = 0.3", "(b) γ = 3"]
    for axes in figure.axes:
        lines = {line.get_label(): line for line in axes.lines}
        for (start, update), walk in curves.items():
            line = lines[f"{'with' if update else 'without'} the update (27), from {start:+g}°".replace("-", "−")]
            drawn = np.asarray(line.get_ydata(), dtype=np.float64)
            assert np.array_equal(drawn, np.degrees(walk.samples["slope_estimate"]))
        looks = {(lines[name].get_color(), str(lines[name].get_linestyle())) for name in lines if "from" in str(name)}
        assert len(looks) == 4
    assert figure.axes[-1].get_xlabel() == "time (s)"
    assert (tmp_path / "five.png").stat().st_size > 10_000


def test_figure_5_has_the_truth_of_each_ground_that_was_walked(walks: list[mjbiped.Walk]) -> None:
    """Where one walk landed on the other side of an edge than another."""
    elsewhere = dict(walks[0].touchdowns)
    elsewhere["slope"] = np.roll(elsewhere["slope"], 1)
    assert not np.array_equal(elsewhere["slope"], walks[0].touchdowns["slope"])
    other = dataclasses.replace(walks[0], touchdowns=elsewhere)
    for second, count in ((walks[0], 1), (other, 2)):
        figure = plot_figure_5({0.3: {(3.0, True): walks[0], (-3.0, True): second}})
        assert sum(line.get_color() == TRUTH["color"] for line in figure.axes[0].lines) == count


@pytest.mark.slow
def test_figure_6_names_the_greatest_torque(walks: list[mjbiped.Walk], tmp_path: Path) -> None:
    figure = plot_figure_6({0.8: walks[0], None: walks[1]}, tmp_path / "six.pdf")
    titles = [axes.get_title(loc="left").replace("\u00a0", " ") for axes in figure.axes]
    assert [title[:4] for title in titles] == ["(a) ", "(b) ", "(c) ", "(d) "]
    assert f"{max(walks[0].peak_torque):.1f} N m" in titles[1]
    assert "no re-planning" in titles[2]
    low, high = figure.axes[1].get_ylim()
    assert low <= min(walk.samples["torque"].min() for walk in walks)
    assert high >= max(walk.samples["torque"].max() for walk in walks)


def test_table_3_shows_the_engines_that_walked(tmp_path: Path) -> None:
    rows = [row_of(row(cell)) for cell in reproduce.table_3("hybrid")]
    figure = plot_table_3(rows, tmp_path / "table.png")
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert "hybrid" in labels
    assert "MuJoCo" not in labels
    assert all(axes.get_yscale() == "log" for axes in figure.axes)


def test_bad_suffix_is_refused(walks: list[mjbiped.Walk]) -> None:
    with pytest.raises(InputError, match=r"\.png"):
        plot_figure_6({0.8: walks[0]}, "six.gif")


def test_pages_pictures_are_small(walks: list[mjbiped.Walk], tmp_path: Path) -> None:
    path = tmp_path / "six.png"
    plot_figure_6({0.8: walks[0]}, path)
    before, pixels = path.stat().st_size, np.asarray(Image.open(path).convert("L"), dtype=np.float64)
    plot_style.make_small(path)
    assert path.stat().st_size < before
    after = np.asarray(Image.open(path).convert("L"), dtype=np.float64)
    assert np.abs(after - pixels).mean() < 1.0  # of 255
