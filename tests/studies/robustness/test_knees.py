"""Robustness studies of robots with knees, beside straight legs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mjbiped
from mjbiped.errors import InputError
from mjbiped.studies.robustness import plan
from mjbiped.studies.robustness_findings import Robustness
from mjbiped.studies.robustness_report import robustness_tables, scuffing_words, texts_of
from mjbiped.studies.robustness_walks import BASIN, LEVEL
from mjbiped.studies.run import run

SMALL: dict[str, Any] = {
    "steps": 20,
    "seeds": 2,
    "grounds": ["treads:deviation=0.01"],
    "limits": {"step down": [0.02, 0.04], "phases": 2, "basin": 2},
    "robot": {"kind": "kneed"},
    "controller": [
        {"label": "knees", "reference": "clearance=0.08"},
        {"label": "straight", "robot": {}},
    ],
}


def test_a_disturbance_comes_at_all_phases_of_a_step_with_knees() -> None:
    gait = mjbiped.find_reference(mjbiped.KneedBiped(), clearance=0.08)
    cells = plan(Path("x.toml"), SMALL).study.cells
    mine = [c for c in cells if c.values["test"] == "step down" and c.values["controller"] == "knees"]
    places = np.array([float(c.values["terrain.first"]) for c in mine if c.values["magnitude"] == 0.02])
    assert places / gait.step_length == pytest.approx([3.25, 3.75])


def test_a_basins_first_states_have_a_straight_swing_leg() -> None:
    cells = plan(Path("x.toml"), SMALL).study.cells
    mine = [c for c in cells if c.values["test"] == BASIN and c.values["controller"] == "knees"]
    gait = mine[0].controller().gait
    assert gait is not None
    starts = np.array([cell.initial(lambda: gait.start.tolist()) for cell in mine], dtype=float)
    assert starts.shape == (4, 6)
    assert (starts[:, 1] == starts[:, 2]).all()
    assert (np.abs(starts[:, 4] - starts[:, 5]) < 1e-15).all()
    assert np.ptp(starts[:, 4]) > 1.0


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"robot": {"kind": "kneed"}, "scuffing": {"reach": 0.3}}, "scuffing is for straight legs"),
        ({"robot": {"kind": ["kneed", "compass"]}}, "robot.kind must be one value"),
        ({"robot": "kneed"}, "robot must be a table"),
        (
            {"controller": [{"robot": {"kind": "kneed"}, "name": "passivity"}]},
            r"choose a controller for that robot: adaptive \(KneedController\), bounded-ankle",
        ),
    ],
)
def test_what_no_study_with_knees_can_have_is_refused(content: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        plan(Path("x.toml"), {"seeds": 1, "limits": {"step up": [0.01], "phases": 1}, **content})


@pytest.mark.usefixtures("studies_in_threads")
@pytest.mark.slow
def test_findings_are_those_of_walks_with_knees(tmp_path: Path) -> None:
    wanted = plan(
        Path("x.toml"), {**SMALL, "limits": {**SMALL["limits"], "torque": 40}, "controller": [SMALL["controller"][0]]}
    )
    rows, *_ = run(wanted.study, tmp_path, workers=1)
    result = Robustness(wanted, rows)
    (findings,) = result.findings
    level = mjbiped.walk(wanted.study.cells[0].controller(), mjbiped.Terrain.level(), engine="hybrid", steps=40)
    assert rows[0]["test"] == LEVEL
    assert findings["level"]["cost_of_transport"] == level.cost_of_transport
    # the knee's torque counts too, and that of the ankle decides: steps down ask for 26 and 47 N m (docs/knees.md)
    assert findings["greatest_survived"]["step down"]["magnitude"] == 0.02
    assert findings["survival"]["treads:deviation=0.01"]["falls"] == 0
    assert scuffing_words(wanted) == "the swing foot collides from lift-off on"
    assert [texts_of(table)[1][0][0] for table in robustness_tables(result)] == ["knees"] * 3
    assert scuffing_words(plan(Path("x.toml"), SMALL)).endswith("with knees from lift-off on")
