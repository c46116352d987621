"""Figures of a study: what stands in them, and which are drawn."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mjbiped.plotting import style as plot_style
from mjbiped.studies.bins import binned, measured, middle, values_of
from mjbiped.studies.cell import MEASURES
from mjbiped.studies.figures import draw
from mjbiped.studies.plan import FINISHED, plan


def rows_of(text: str) -> tuple[Any, list[dict[str, Any]]]:
    """A study and made-up rows: every fifth walk falls, the cost is the cell's number."""
    study = plan(Path("study.toml"), tomllib.loads(text))
    rows = []
    for cell in study.cells:
        row: dict[str, Any] = {**dict.fromkeys(study.varied), **cell.values, "cell": cell.index}
        row.update({name: float(cell.index) for name in MEASURES}, outcome="fell" if cell.index % 5 == 0 else FINISHED)
        rows.append(row)
    return study, rows


GRID = "controller = { position_gain = [2, 4, 8], velocity_gain = { from = 1, to = 4, count = 4 } }\n"
SEEDS = '[terrain]\nname = "random"\nseed = { from = 0, to = 9, count = 10 }\n'


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (GRID + SEEDS, ["map_controller.position_gain_controller.velocity_gain"]),
        (GRID + '[plot]\nparameters = ["controller.velocity_gain"]', ["line_controller.velocity_gain"]),
        ('controller = { name = ["adaptive", "passivity"] }\n' + SEEDS, ["groups_controller.name"]),
        ("", ["histograms"]),
        pytest.param(
            "samples = 300\nmodel = { hip_mass = { log_uniform = [1, 100] }, leg_mass = { uniform = [4, 6] } }\n"
            '[plot]\nmeasures = ["finished", "steps", "speed_m_per_s", "largest_slip_m"]',
            ["map_model.hip_mass_model.leg_mass"],
            marks=pytest.mark.slow,
        ),
    ],
)
def test_figures_that_are_drawn(text: str, names: list[str], tmp_path: Path) -> None:
    study, rows = rows_of(text)
    files = draw(study, rows, tmp_path)
    assert [file.name for file in files] == [f"{name}.png" for name in names]
    for file in files:
        with Image.open(file) as picture:
            assert picture.width == 1536
            assert np.ptp(np.asarray(picture.convert("L"))) > 200
    again = tmp_path / "again"
    again.mkdir()
    assert [file.read_bytes() for file in draw(study, rows, again)] == [file.read_bytes() for file in files]


def test_a_group_without_the_parameter_is_a_level_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Any] = []
    monkeypatch.setattr(plot_style, "save_figure", lambda figure, _: shown.append(figure))
    study, rows = rows_of('[[controller]]\nposition_gain = [2, 4, 8]\n[[controller]]\nname = "passive"\n')
    draw(study, rows, tmp_path)
    (figure,) = shown
    cost, *_ = figure.axes
    lines = {line.get_label(): line for line in cost.lines}
    passive = rows[-1]["cost_of_transport"]
    assert np.asarray(lines["passive"].get_ydata()).tolist() == [passive] * 3
    assert len(lines["adaptive"].get_xdata()) == 3
    none = [{**row, "outcome": "failed", **dict.fromkeys(MEASURES)} for row in rows]
    draw(study, none, tmp_path)
    assert [text.get_text() for text in shown[1].axes[0].texts] == ["no walk finished"]
    assert "4 walks, 0 finished, 4 could not begin" in shown[1].get_suptitle()


def test_a_group_without_the_parameter_is_on_maps_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Any] = []
    monkeypatch.setattr(plot_style, "save_figure", lambda figure, _: shown.append(figure))
    study, rows = rows_of(
        'terrain = { name = "incline", slope_deg = [1, 2] }\n'
        '[[controller]]\nposition_gain = [2, 4, 8]\n[[controller]]\nname = "passive"\n'
    )
    draw(study, [{**row, "outcome": FINISHED, "peak_ankle_torque_Nm": 0.0} for row in rows], tmp_path)
    maps = {axes.get_title(loc="left"): axes.collections[0] for axes in shown[0].axes if axes.get_title(loc="left")}
    passive = maps["cost of transport, absolute\npassive"].get_array()
    assert passive.count() == 6
    assert len(set(passive.compressed().tolist())) == 2  # one value for each slope, whatever the gain
    norm = maps["peak torque, ankle (N m)\npassive"].norm
    assert norm.vmin < 0.0 < norm.vmax  # colours of nothing but zeros


@pytest.mark.slow
def test_where_nothing_finished(tmp_path: Path) -> None:
    for text in (GRID, SEEDS, "controller = { position_gain = [2, 4] }"):
        study, rows = rows_of(text)
        assert draw(study, [{**row, "outcome": "failed", **dict.fromkeys(MEASURES)} for row in rows], tmp_path)


def test_only_finished_walks_are_measured() -> None:
    _, rows = rows_of(GRID)
    assert middle(values_of(rows, "cost_of_transport"), "cost_of_transport") == np.median([1, 2, 3, 4, 6, 7, 8, 9, 11])
    assert middle(values_of(rows, FINISHED), FINISHED) == 9 / 12
    assert np.isnan(middle(np.array([np.nan]), "steps"))
    rows[0] |= {"outcome": "failed", "steps": None}
    rows[1] |= {"outcome": "failed"}  # in its second step
    assert middle(values_of(rows, FINISHED), FINISHED) == 8 / 11  # a walk that could not begin is none
    assert measured([np.array([0.0, np.nan, 1.0, 2.0, 3.0, 4.0])], "steps").tolist() == [[2.0], [1.0], [3.0], [5.0]]


def test_few_values_stand_by_themselves_and_many_in_bins() -> None:
    few = binned([{"x": 8}, {"x": 2}, {"x": None}, {"x": 8}], "x", 5)
    assert few.bin.tolist() == [1, 0, -1, 1]
    assert few.ticks == ("2", "8")
    many = binned([{"x": float(k)} for k in range(1, 101)], "x", 4)
    assert np.bincount(many.bin).tolist() == [25, 25, 25, 25]
    assert (many.edges[0], many.edges[-1], many.ticks) == (1.0, 100.0, ())
    assert not many.log
    geometric = binned([{"x": 2.0**k} for k in range(20)], "x", 5)
    assert geometric.log
    assert np.bincount(geometric.bin).tolist() == [4, 4, 4, 4, 4]
