"""Every figure at every width: as wide as it says, legible, and the same file each time; what is refused."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from legible import assert_legible
from matplotlib import cbook
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from reproduction_rows import made_row

import mjbiped
from mjbiped.analysis.survival import Survival
from mjbiped.errors import InputError, RenderError
from mjbiped.limit_cycles.basin import Basin
from mjbiped.limit_cycles.map_slices import map_slices
from mjbiped.plotting import WIDTHS, figure_width, panels, width
from mjbiped.plotting.comparison import plot_comparison, plot_stability, plot_survival
from mjbiped.plotting.gait import plot_gait
from mjbiped.plotting.gaits import plot_basins, plot_bifurcation, plot_multipliers, plot_return_map
from mjbiped.plotting.style import C_MT
from mjbiped.plotting.walk import plot_walk
from mjbiped.studies.reproduction.figures import plot_figure_5, plot_figure_6, plot_table_3
from mjbiped.studies.reproduction.section_5 import TABLE_3

Get = Callable[[str], Any]

WALKED = [
    made_row(cost, part="table 3", ground=ground, ankle=torque, delay=zeta)
    for ground in ("mixed", "found")
    for zeta, (torque, cost) in TABLE_3.items()
]
CURVES = [(start, update) for start in (-3.0, 3.0) for update in (True, False)]
FIGURES: dict[str, Callable[[Get], Figure]] = {
    "walk": lambda get: plot_walk(get("walk")),
    "fall": lambda get: plot_walk(get("fallen")),
    "walk in rows": lambda get: plot_walk(get("long_walk")),
    "walk in space": lambda get: plot_walk(get("walk_in_space")),
    "walk with knees": lambda get: plot_walk(get("kneed_walk")),
    "gait": lambda get: plot_gait(get("gait")),
    "reference": lambda get: plot_gait(get("reference")),
    "gait with knees": lambda get: plot_gait(get("kneed_gait")),
    "comparison": lambda get: plot_comparison(get("compared")),
    "comparison of falls": lambda get: plot_comparison(get("compared_falls")),
    "bifurcation": lambda get: plot_bifurcation(get("diagram"), get("cascade")),
    "multipliers": lambda get: plot_multipliers([branch.gaits for branch in get("cascade").branches]),
    "basins": lambda get: plot_basins(get("maps")),
    "return map": lambda get: plot_return_map(map_slices(get("robot"), np.radians(3.0), points=40)),
    "return map of a wheel": lambda _: plot_return_map(map_slices(mjbiped.RimlessWheel(), 0.08, points=40)),
    "stability": lambda get: plot_stability(get("evaluated")),
    "survival": lambda _: plot_survival({"one": Survival((5, 9), (True, False)), "$^": Survival((9,), (False,))}),
    "figure 5": lambda get: plot_figure_5({gain: {curve: get("walk") for curve in CURVES} for gain in (0.3, 3.0)}),
    "figure 6": lambda get: plot_figure_6({delay: get("walk") for delay in (0.6, None)}),
    "table 3": lambda _: plot_table_3(WALKED),
}
ALIKE = {"walk", "gait", "gait with knees", "comparison of falls", "return map of a wheel"}
"""Others have their panels."""
NARROW = [pytest.param(name, marks=() if name == "single" else pytest.mark.slow) for name in WIDTHS]
"""Where letters find least room; the other widths are slow."""


@pytest.fixture
def get(request: pytest.FixtureRequest) -> Get:
    return lambda name: request.getfixturevalue(name)


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize(
    "draw",
    [pytest.param(draw, id=name, marks=pytest.mark.slow if name in ALIKE else ()) for name, draw in FIGURES.items()],
)
def test_figures_are_legible(draw: Callable[[Get], Figure], name: str, get: Get) -> None:
    with figure_width(name):
        assert_legible(draw(get), name)


@settings(max_examples=20)
@given(st.text("$$$\\{}^_a%", min_size=1, max_size=12))
def test_any_name_stands_beside_a_formula(name: str) -> None:
    """Odd numbers of dollar signs, backslashes, braces: matplotlib would draw the formula as text, or raise."""
    figure, text = Figure(), f"{panels.plain(name)} costs {C_MT}"
    panels.head(figure, text)
    assert cbook.is_math_text(text)
    figure.draw_without_rendering()


@settings(max_examples=30)
@given(st.lists(st.sampled_from(["stairs", C_MT, "0.0376;", "x" * 200, "m"]), min_size=1, max_size=40))
def test_the_cost_of_transport_is_never_broken(words: list[str]) -> None:
    for name in WIDTHS:
        with figure_width(name):
            lines = panels.wrapped(" ".join(words)).split("\n")
            assert sum(line.count(C_MT) for line in lines) == words.count(C_MT)
            assert all(len(line.replace(C_MT, "cmt")) <= width().letters() for line in lines)


@pytest.mark.parametrize("suffix", [".svg", *(pytest.param(name, marks=pytest.mark.slow) for name in (".pdf", ".png"))])
def test_same_figure_same_file(
    walk: mjbiped.Walk, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where matplotlib's layout solver took its equations in another order, as it does from run to run."""
    laid_out, rounding = ConstrainedLayoutEngine.execute, np.random.default_rng(0)

    def execute(self: ConstrainedLayoutEngine, figure: Figure) -> Any:
        result = laid_out(self, figure)
        for part in figure.subfigs:
            points = part.bbox_relative.get_points()
            part.bbox_relative.set_points(points * (1.0 + 1e-15 * rounding.integers(-4, 5, size=points.shape)))
        for axes in figure.axes:
            bounds = np.array(axes.get_position(original=True).bounds)
            axes.set_position(bounds * (1.0 + 1e-15 * rounding.integers(-4, 5, size=4)))
            axes.set_in_layout(True)
        return result

    paths = [tmp_path / f"{name}{suffix}" for name in ("calm", "other")]
    plot_walk(walk, paths[0])
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", execute)
    plot_walk(walk, paths[1])
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].read_bytes().startswith({".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}[suffix])
    assert b"Date" not in paths[0].read_bytes()


def test_refusals(walk: mjbiped.Walk, maps: list[Basin], compared: mjbiped.Comparison, tmp_path: Path) -> None:
    empty = dataclasses.replace(walk, samples={name: array[:0] for name, array in walk.samples.items()})
    refused: list[tuple[type[Exception], str, Callable[[], object]]] = [
        (InputError, "one or two basins", lambda: plot_basins([])),
        (InputError, "unknown panel 'torqe'.*'torque'", lambda: plot_walk(walk, panels=("torqe",))),
        (RenderError, "no samples", lambda: plot_walk(empty)),
        (RenderError, "no samples", lambda: plot_comparison(dataclasses.replace(compared, hybrid=empty))),
        (RenderError, "cannot write .*No such file", lambda: plot_walk(walk, tmp_path / "missing" / "walk.png")),
    ]
    refused += [
        (InputError, r"\.png, \.pdf, \.svg", lambda name=name: plot_basins(maps, tmp_path / name))  # type: ignore[misc]
        for name in ("basin.jpeg", "basin", "basin.npz")
    ]
    for kind, words, draw in refused:
        with pytest.raises(kind, match=words):
            draw()
    assert not list(tmp_path.iterdir())
