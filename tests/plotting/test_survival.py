"""Survival curves are drawn as they are, and legibly."""

from pathlib import Path

import numpy as np
import pytest
from legible import assert_legible

from mjbiped.analysis.survival import Survival
from mjbiped.plotting import WIDTHS, figure_width
from mjbiped.plotting.comparison import plot_survival


@pytest.mark.parametrize("width", WIDTHS)
def test_curves_and_bands(width: str, tmp_path: Path) -> None:
    often = Survival((5, 9, 40, 100), (True, True, True, False))
    survivals = {"the paper's": often, "of 10 cm": Survival((100,) * 4, (False,) * 4)}
    with figure_width(width):
        figure = plot_survival(survivals, tmp_path / "survival.png")
        assert_legible(figure, width)
    [axes] = figure.axes
    for line, survival in zip(axes.lines, survivals.values(), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.transpose(survival.curve()[:2]))
    labels = [line.get_label() for line in axes.lines]
    assert labels == ["the paper's: a fall in 51.3 steps", "of 10 cm: no fall"]  # 154 steps, 3 falls
    assert (tmp_path / "survival.png").stat().st_size > 1000
