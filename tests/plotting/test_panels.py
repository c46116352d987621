"""Titles and legends fit whatever the width is, and take nobody's file name for a formula."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from legible import assert_legible
from matplotlib import cbook
from matplotlib.figure import Figure

from mjbiped.plotting import WIDTHS, figure_width, panels, width
from mjbiped.plotting.style import C_MT, drawn


@settings(max_examples=30, deadline=None)  # of drawing, on a busy machine
@given(st.text("$$$\\{}^_a%", min_size=1, max_size=12))
def test_any_name_stands_beside_a_formula(name: str) -> None:
    """Odd numbers of dollar signs, backslashes, braces: matplotlib would draw the formula as text, or raise."""
    figure = Figure()
    text = f"{panels.plain(name)} costs {C_MT}"
    panels.head(figure, text)
    assert cbook.is_math_text(text)
    figure.draw_without_rendering()


@settings(max_examples=30, deadline=None)  # of drawing, on a busy machine
@given(st.lists(st.sampled_from(["stairs", C_MT, "0.0376;", "x" * 200, "m"]), min_size=1, max_size=40))
def test_the_cost_of_transport_is_never_broken(words: list[str]) -> None:
    for name in WIDTHS:
        with figure_width(name):
            lines = panels.wrapped(" ".join(words)).split("\n")
            assert sum(line.count(C_MT) for line in lines) == words.count(C_MT)
            assert all(len(line.replace(C_MT, "cmt")) <= width().letters() for line in lines)


@pytest.mark.parametrize("name", WIDTHS)
def test_titles_and_legends_fit(name: str) -> None:
    with figure_width(name), drawn(None) as figure:
        figure.set_figheight(4.0)
        axes = figure.subplots(2, 1)
        for panel, letter in zip(axes, "ab", strict=True):
            for number in range(4):
                panel.plot([0, 1], [number, 1], label=f"a line of the number {number}")
            panels.titled(panel, letter, "A title of as many words as would not go on a single line in a column")
            panels.legend_above(panel)
        panels.legend_below(figure, *axes[0].get_legend_handles_labels())
    assert_legible(figure, name)
    (below,) = figure.legends
    assert len(below.get_texts()) == 4
