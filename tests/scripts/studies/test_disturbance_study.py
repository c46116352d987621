"""The study of disturbances: it walks what it says, and its figure can be read."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from legible import assert_legible
from matplotlib.figure import Figure

from mjbiped.plotting import style as plot_style
from scripts.studies import disturbance_study as study


def test_the_figure_can_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(plot_style, "save_figure", lambda figure, _: drawn.append(figure))
    points = [[study.Point(1.0 / (1 + n), 0.03 * (1 + n)) for n in range(len(scan.values))] for scan in study.SCANS]
    points[0][-1] = study.Point(0.0, math.nan)
    study.draw(dict.fromkeys(study.ENGINES, points), Path("disturbances.pdf"))
    assert_legible(drawn[0], "page")


@pytest.mark.slow
def test_a_scan_counts_walks_that_finished() -> None:
    short = study.SCANS[2]._replace(values=(0.5, 40.0))
    fallen, walked = study.measure(short, "hybrid", walks=2, steps=9)
    assert fallen.finished == 0.0
    assert math.isnan(fallen.cost)
    assert walked.finished == 1.0
    assert 0.0 < walked.cost < 0.1
