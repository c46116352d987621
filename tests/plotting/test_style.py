"""How figures are written: the same figure is the same file, byte for byte."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from mjbiped.plotting.style import SUFFIXES, new_figure, save_figure, styled


def figure_with_panels() -> Figure:
    with styled():
        figure = new_figure(3.0)
        parts: Any = figure.subfigures(2, 1)
        left, right = parts[0].subplots(1, 2)
        left.plot([0.0, 1.0, 2.0], [0.1, -0.3, 0.2], label="a line")
        left.legend()
        figure.colorbar(right.imshow(np.eye(3)), ax=right)
        below = parts[1].subplots(1, 1)
        below.set(xlabel="time (s)", ylabel="slope (°)")
        below.fill_between([0.0, 1.0], [0.0, 0.3], 1.0)
    return figure


@pytest.mark.slow
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_same_figure_is_the_same_file(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where matplotlib's layout solver took its equations in another order, as it does from run to run."""
    laid_out = ConstrainedLayoutEngine.execute
    rounding = np.random.default_rng(0)

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

    paths = [tmp_path / f"{name}{suffix}" for name in ("calm", "first", "second")]
    save_figure(figure_with_panels(), paths[0])
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", execute)
    for path in paths[1:]:
        save_figure(figure_with_panels(), path)
    assert len({path.read_bytes() for path in paths}) == 1


def test_files_do_not_say_when_they_were_written(tmp_path: Path) -> None:
    for suffix in (".pdf", ".svg"):
        path = tmp_path / f"figure{suffix}"
        save_figure(figure_with_panels(), path)
        assert b"Date" not in path.read_bytes()
