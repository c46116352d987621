"""Measures by value, and the best combination, against a table worked out by hand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mjbiped.studies.cell import Row
from mjbiped.studies.plan import Study, plan
from mjbiped.studies.summary import best, by_value

COSTS = {"plot": {"measures": ["cost_of_transport", "finished"]}}
GRID = {"controller": {"position_gain": [3, 5], "replanning_delay": [0.8, "none"]}}
DRAWN = {"samples": 9, "terrain": {"name": "random", "rise": {"plus_minus": {"uniform": [0, 0.04]}}}}


def study_of(content: Mapping[str, Any]) -> Study:
    return plan(Path("study.toml"), {"engine": "hybrid", **content})


def rows_of(study: Study, results: list[tuple[str, float | None]]) -> list[Row]:
    """Rows with these outcomes and costs."""
    return [
        {"cell": cell.index, **cell.values, "outcome": outcome, "cost_of_transport": cost, "peak_ankle_torque_Nm": cost}
        for cell, (outcome, cost) in zip(study.cells, results, strict=True)
    ]


def test_medians_are_of_the_walks_with_each_value_that_finished() -> None:
    study = study_of(GRID | COSTS)  # 3 with 0.8, 3 with none, 5 with 0.8, 5 with none
    rows = rows_of(study, [("finished", 0.1), ("fell", 0.9), ("finished", 0.25), ("finished", 0.5)])
    found = by_value(rows, study)
    assert found["controller.position_gain"] == [
        {"value": "3", "walks": 2, "cost_of_transport": 0.1, "finished": 0.5},
        {"value": "5", "walks": 2, "cost_of_transport": 0.375, "finished": 1.0},
    ]
    assert found["controller.replanning_delay"] == [
        {"value": "0.8", "walks": 2, "cost_of_transport": 0.175, "finished": 1.0},
        {"value": "none", "walks": 2, "cost_of_transport": 0.5, "finished": 0.5},
    ]


def test_the_best_combination_finishes_most_often_and_is_then_the_cheapest() -> None:
    study = study_of(GRID)
    rows = rows_of(study, [("fell", 0.01), ("finished", 0.3), ("finished", 0.2), ("finished", 0.4)])
    found = best(rows, study)
    assert found is not None
    assert found["values"] == {"controller.position_gain": 5, "controller.replanning_delay": 0.8}
    assert (found["walks"], found["finished"], found["cost_of_transport"], found["first_cell"]) == (1, 1.0, 0.2, 2)
    assert best(rows_of(study, [("fell", None)] * 4), study) is None


def test_what_is_drawn_is_put_into_ranges_and_is_no_combination() -> None:
    study = study_of(DRAWN)
    assert study.drawn == {"terrain.rise.plus_minus"}
    rows = rows_of(study, [("finished", 0.1)] * 9)
    [(name, entries)] = by_value(rows, study).items()
    assert name == "terrain.rise.plus_minus"
    assert sum(entry["walks"] for entry in entries) == 9
    assert best(rows, study) is None
