"""Every figure of the package at every width: as wide as it says, legible, nothing cut off, nothing overlapping."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from legible import assert_legible
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.stability import Stability, stability
from mjbiped.errors import InputError
from mjbiped.limit_cycles.basin import Basin, basin_of_attraction
from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade, bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.map_slices import map_slices
from mjbiped.plotting import DEFAULT_WIDTH, WIDTHS, figure_width, width
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.comparison import plot_comparison, plot_stability
from mjbiped.plotting.gait import plot_gait
from mjbiped.plotting.gaits import plot_basins, plot_bifurcation, plot_multipliers, plot_return_map
from mjbiped.plotting.walk import plot_walk
from mjbiped.robots.compass import Compass
from mjbiped.studies import figures as sweep_figures
from mjbiped.studies.cell import MEASURES
from mjbiped.studies.plan import FINISHED, plan
from mjbiped.studies.reproduction.figures import plot_figure_5, plot_figure_6, plot_table_3

ROBOT = Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
LAW = AdaptiveController(ROBOT, GAIT, initial_slope_estimate=math.radians(3))
GROUND = mjbiped.Terrain.from_segments([(0.6, 0.0), (0.8, 2.0, -0.02), (2.0, -1.0)])


@cache
def walked(
    start: float = 3.0, update: bool = True, delay: float | None = 0.8, engine: str = "hybrid", steps: int = 5
) -> mjbiped.Walk:
    law = replace(LAW, initial_slope_estimate=math.radians(start), estimate_update=update, replanning_delay=delay)
    return mjbiped.walk(law, GROUND, engine=engine, steps=steps, sample_period=0.01)


@cache
def fallen() -> mjbiped.Walk:
    return mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), engine="hybrid", initial="rest")


@cache
def compared() -> mjbiped.Comparison:
    return mjbiped.compare(LAW, GROUND, steps=2)


@cache
def compared_passive() -> mjbiped.Comparison:
    return mjbiped.compare(PassiveController(), mjbiped.Terrain.incline(2.0), steps=2)


@cache
def diagram() -> BifurcationDiagram:
    return bifurcation_diagram(ROBOT, np.radians(np.linspace(2.4, 3.6, 13)), steps=60, keep=20)


@cache
def cascade() -> Cascade:
    return find_cascade(ROBOT, 2)


@cache
def maps() -> list[Basin]:
    return [
        basin_of_attraction(ROBOT, math.radians(2), stance_rates=np.linspace(*a, 8), swing_rates=np.linspace(*b, 8))
        for a, b in (((0.9, 1.3), (-0.5, 1.5)), ((0.5, 2.0), (-2.0, 3.0)))
    ]


@cache
def evaluated() -> dict[str, Stability]:
    laws: dict[str, dict[str, Any]] = {"as in the paper": {}, "without": {"update": False, "delay": None}}
    return {name: stability(walked(**changed, steps=3)) for name, changed in laws.items()}


def figure_5() -> Figure:
    curves = {(start, update): walked(start, update) for start in (-3.0, 3.0) for update in (True, False)}
    return plot_figure_5({0.3: curves, 3.0: curves})


FIGURES: dict[str, Callable[[], Figure]] = {
    "walk": lambda: plot_walk(walked()),
    "fall": lambda: plot_walk(fallen()),
    "walk in rows": lambda: plot_walk(walked(steps=20)),
    "gait": lambda: plot_gait(GAIT),
    "reference": lambda: plot_gait(mjbiped.find_reference(mjbiped.Compass(), clearance=0.06)),
    "gait with knees": lambda: plot_gait(mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))),
    "comparison": lambda: plot_comparison(compared()),
    "comparison without an estimate": lambda: plot_comparison(compared_passive()),
    "bifurcation": lambda: plot_bifurcation(diagram(), cascade()),
    "multipliers": lambda: plot_multipliers([branch.gaits for branch in cascade().branches]),
    "basins": lambda: plot_basins(maps()),
    "return map": lambda: plot_return_map(map_slices(ROBOT, math.radians(3.0), points=40)),
    "return map of a wheel": lambda: plot_return_map(map_slices(mjbiped.RimlessWheel(), 0.08, points=40)),
    "stability": lambda: plot_stability(evaluated()),
    "figure 5": figure_5,
    "figure 6": lambda: plot_figure_6({delay: walked(delay=delay) for delay in (0.6, 0.8, None)}),
    "table 3": lambda: plot_table_3([]),
}


NARROW = [pytest.param(name, marks=() if name == "single" else pytest.mark.slow) for name in WIDTHS]
"""Where letters find least room; the other widths are slow."""


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize("draw", FIGURES.values(), ids=FIGURES)
def test_figures_are_legible_at_every_width(draw: Callable[[], Figure], name: str) -> None:
    with figure_width(name):
        assert_legible(draw(), name)


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("controller = { position_gain = [2, 4, 8], replanning_delay = [0.6, 0.8] }\n", 1),
        ('controller = { velocity_gain = [2, 4, 8] }\nengine = ["mujoco", "hybrid"]\n', 1),
        ('[terrain]\nname = "random"\nseed = { from = 0, to = 9, count = 10 }\n', 1),
    ],
    ids=["map", "lines", "histograms"],
)
def test_figures_of_studies(name: str, text: str, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(plot_style, "save_figure", lambda figure, _: drawn.append(figure))
    study = plan(tmp_path / "study.toml", tomllib.loads(text))
    rows = []
    for cell in study.cells:
        row: dict[str, Any] = {**dict.fromkeys(study.varied), **cell.values, "cell": cell.index}
        rows.append({**row, **dict.fromkeys(MEASURES, 0.01 * cell.index), "outcome": FINISHED})
    with figure_width(name):
        sweep_figures.draw(study, rows, tmp_path)
    assert len(drawn) == count
    for figure in drawn:
        assert_legible(figure, name, smallest=4.0)  # numbers in a map's cells, and how many walks they are of


def test_a_width_holds_in_its_block_alone() -> None:
    assert width() is WIDTHS[DEFAULT_WIDTH]
    with figure_width("double"), figure_width("single"):
        assert width().inches == 3.5
    assert width().inches == 9.6
    with pytest.raises(InputError, match=r"unknown figure width 'singel': valid are page, .*; did you mean 'single'"):
        figure_width("singel").__enter__()
    assert width().inches == 9.6


def test_panels_stand_below_each_other_where_they_would_be_too_narrow() -> None:
    assert [size.beside(3) for size in WIDTHS.values()] == [3, 2, 1, 3]
    assert [size.beside(2) for size in WIDTHS.values()] == [2, 2, 1, 2]


def test_of_a_controller_without_an_estimate_none_is_drawn() -> None:
    *_, slope = plot_comparison(compared_passive()).axes
    assert [line.get_label() for line in slope.lines] == ["ground"]
    assert slope.get_title(loc="left").startswith("(b) Slope of the ground")


def test_a_walk_of_twenty_steps_fits_the_column_of_a_page() -> None:
    with figure_width("single"):
        assert plot_walk(walked(steps=20)).get_size_inches()[1] < 9.5  # IEEE's column is 9.6 in high


@pytest.mark.slow
def test_no_legend_lies_on_the_title_of_a_time_lapse() -> None:
    for name in WIDTHS:
        with figure_width(name):
            figure = plot_walk(walked(steps=20))
            figure.draw_without_rendering()
        (title,) = (text for text in figure.findobj(Text) if text.get_text() == "(a) Time lapse")
        legend = figure.axes[0].get_legend()
        assert legend is not None
        first, second = title.get_window_extent(), legend.get_window_extent()
        assert second.x0 > first.x1 or second.y1 < first.y0 + 2.0  # pixels, of the legend's own margin


@pytest.mark.slow
def test_files_have_the_dots_that_their_use_asks_for(tmp_path: Path) -> None:
    for name, dots in (("page", 160), ("double", 300), ("single", 300)):  # a screen's; journals ask for 300 per inch
        with figure_width(name):
            plot_gait(GAIT, tmp_path / "gait.png")
        with Image.open(tmp_path / "gait.png") as picture:
            assert picture.width == round(dots * WIDTHS[name].inches)


@pytest.mark.slow
def test_same_figure_is_the_same_file_at_any_width(tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.png" for number in range(2)]
    with figure_width("single"):
        for path in paths:
            plot_gait(GAIT, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
