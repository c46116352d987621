"""What figures and summaries of a study show, on rows worked out by hand."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from legible import assert_legible
from matplotlib.figure import Figure

from mjbiped.plotting import WIDTHS, figure_width, style
from mjbiped.studies.bins import binned, measured, middle, values_of
from mjbiped.studies.cell import MEASURES, Row
from mjbiped.studies.figures import draw
from mjbiped.studies.plan import FINISHED, Study, plan
from mjbiped.studies.summary import best, by_value, summarised

GRID = "controller = { position_gain = [2, 4, 8], velocity_gain = { from = 1, to = 4, count = 4 } }\n"
LINE = GRID + '[plot]\nparameters = ["controller.velocity_gain"]'
SEEDS = '[terrain]\nname = "random"\nseed = { from = 0, to = 9, count = 10 }\n'
BASELINE = '[[controller]]\nposition_gain = [2, 4, 8]\n[[controller]]\nname = "passive"\n'
MODEL = """
samples = 300
model = { hip_mass = { log_uniform = [0.01, 1000] }, leg_mass = { uniform = [4, 6] } }
plot.measures = ["finished", "steps", "speed_m_per_s", "largest_slip_m"]
"""
FAILED = {"outcome": "failed", **dict.fromkeys(MEASURES)}
COST = "cost_of_transport"


def rows_of(text: str) -> tuple[Study, list[Row]]:
    """A study and made-up rows: every fifth walk falls, the cost is the cell's number."""
    study = plan(Path("study.toml"), tomllib.loads(text))
    rows = []
    for cell in study.cells:
        row: Row = {**dict.fromkeys(study.varied), **cell.values, "cell": cell.index}
        row.update({name: float(cell.index) for name in MEASURES}, outcome="fell" if cell.index % 5 == 0 else FINISHED)
        rows.append(row)
    return study, rows


@pytest.mark.parametrize(
    "width", [pytest.param(name, marks=() if name == "double" else pytest.mark.slow) for name in WIDTHS]
)
@pytest.mark.parametrize(
    ("text", "name"),
    [
        (GRID + SEEDS, "map_controller.position_gain_controller.velocity_gain"),
        pytest.param(LINE, "line_controller.velocity_gain", marks=pytest.mark.slow),
        ('controller = { name = ["adaptive", "passivity"] }\n' + SEEDS, "groups_controller.name"),
        (SEEDS, "histograms"),
        pytest.param(MODEL, "map_model.hip_mass_model.leg_mass", marks=pytest.mark.slow),
        (BASELINE, "line_controller.position_gain"),
    ],
)
def test_legible(text: str, name: str, width: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A study's figure is legible at each width, and another where nothing finished."""
    study, rows = rows_of(text)
    figures: list[Figure] = []
    save = style.save_figure

    def kept(figure: Figure, path: Path) -> None:
        figures.append(figure)
        save(figure, path)

    monkeypatch.setattr(style, "save_figure", kept)
    with figure_width(width):
        [file] = draw(study, rows, tmp_path)
        before = file.read_bytes()
        assert file.name == f"{name}.png"
        draw(study, [{**row, **FAILED} for row in rows], tmp_path)  # nothing finished: other words, no error
    assert file.read_bytes() != before
    assert_legible(figures[0], width, smallest=4.0)  # numbers in a map's cells, and how many walks they are of


def test_only_finished_walks_are_measured() -> None:
    _, rows = rows_of(GRID)
    assert middle(values_of(rows, COST), COST) == np.median([1, 2, 3, 4, 6, 7, 8, 9, 11])
    assert middle(values_of(rows, FINISHED), FINISHED) == 9 / 12
    assert np.isnan(middle(np.array([np.nan]), "steps"))
    rows[0] |= {"outcome": "failed", "steps": None}
    rows[1] |= {"outcome": "failed"}  # in its second step
    assert middle(values_of(rows, FINISHED), FINISHED) == 8 / 11  # a walk that could not begin is none
    assert measured([np.array([0.0, np.nan, 1, 2, 3, 4])], "steps").tolist() == [[2.0], [1.0], [3.0], [5.0]]
    assert measured([np.array([0.0, 1, 1, 1])], FINISHED).tolist() == [[0.75], [0.75], [0.75], [4.0]]


def test_few_values_stand_by_themselves_and_many_in_bins() -> None:
    few = binned([{"x": 8}, {"x": 2}, {"x": None}, {"x": 8}], "x", 5)
    assert (few.bin.tolist(), few.ticks) == ([1, 0, -1, 1], ("2", "8"))
    many = binned([{"x": float(k)} for k in range(1, 101)], "x", 4)
    assert np.bincount(many.bin).tolist() == [25, 25, 25, 25]
    assert (many.edges[0], many.edges[-1], many.ticks, many.log) == (1.0, 100.0, (), False)
    geometric = binned([{"x": 2.0**k} for k in range(20)], "x", 5)
    assert (geometric.log, binned([{"x": k} for k in range(1, 11)], "x", 5).log) == (True, False)
    assert np.bincount(geometric.bin).tolist() == [4, 4, 4, 4, 4]


def summed(content: dict[str, Any], results: list[tuple[str, float | None]]) -> tuple[list[Row], Study]:
    """Rows with these outcomes and costs, and their study."""
    study = plan(Path("study.toml"), {"engine": "hybrid", **content})
    rows = [
        {"cell": cell.index, **cell.values, "outcome": outcome, COST: cost, "peak_ankle_torque_Nm": cost}
        for cell, (outcome, cost) in zip(study.cells, results, strict=True)
    ]
    return rows, study


GAINS = {"controller": {"position_gain": [3, 5], "replanning_delay": [0.8, "none"]}}


def test_the_best_combination_finishes_most_often_and_is_then_the_cheapest() -> None:
    found = best(*summed(GAINS, [("fell", 0.01), ("finished", 0.3), ("finished", 0.2), ("finished", 0.4)]))
    assert found is not None
    assert found["values"] == {"controller.position_gain": 5, "controller.replanning_delay": 0.8}
    assert (found["walks"], found["finished"], found[COST], found["first_cell"]) == (1, 1.0, 0.2, 2)
    assert best(*summed(GAINS, [("fell", None)] * 4)) is None


def test_outcomes_are_counted_and_walks_that_violate_the_contact_are_told_apart() -> None:
    _, rows = rows_of(GRID)
    rows = [{**row, "error": None, "steps_violating_contact": row["cell"] % 2} for row in rows[:4]]
    rows[3] |= {**FAILED, "error": "no gait"}
    found = summarised(rows)
    assert found["outcomes"] == {"finished": 2, "fell": 1, "failed": 1}
    assert found["verdicts"] == {"fell": 1, "finished, contact violated": 1, "finished": 1, "failed": 1}
    assert found["finished"][COST] == pytest.approx([1.05, 1.5, 1.95])
    assert found["errors"] == [{"error": "no gait", "walks": 1, "first_cell": 3}]


def test_what_is_drawn_is_put_into_ranges_and_is_no_combination() -> None:
    drawn = {"samples": 9, "terrain": {"name": "random", "rise": {"plus_minus": {"uniform": [0, 0.04]}}}}
    rows, study = summed(drawn, [("finished", 0.1)] * 9)
    [(name, entries)] = by_value(rows, study).items()
    assert name == "terrain.rise.plus_minus"
    assert sum(entry["walks"] for entry in entries) == 9
    assert best(rows, study) is None
