"""What a robustness study's file asks for, and what of it is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjbiped.errors import InputError
from mjbiped.robustness.plan import LEVEL, SURVIVAL, plan, read_plan

SMALL: dict[str, Any] = {
    "engine": ["hybrid", "mujoco"],
    "steps": 50,
    "seeds": 3,
    "grounds": ["treads:deviation=0.02,slope_deg=-2..2", "waves"],
    "limits": {"step up": [0.01, 0.02], "phases": 4, "torque": 50},
    "scuffing": {"reach": 0.15},
    "controller": [{"label": "paper"}, {"label": "free", "name": "passivity"}],
}


def test_the_walks_of_a_study() -> None:
    wanted = plan(Path("x.toml"), SMALL)
    cells = wanted.study.cells
    assert len(cells) == 2 * 2 * (1 + 2 * 4 + 2 * 3)
    tests = [cell.values["test"] for cell in cells]
    assert {test: tests.count(test) for test in tests} == {LEVEL: 4, "step up": 32, SURVIVAL: 24}
    assert all(cell.section("scuffing") == {"reach": 0.15, "delay": 0.1} for cell in cells)
    paired = [cell.terrain() for cell in cells if cell.values.get("ground") == "waves" and cell.values["case"] == 2]
    assert len(paired) == 4
    assert len(set(paired)) == 1  # all controllers and engines on the same ground
    assert paired[0].x[-1] > 50 * 0.5  # as long as any walk


def test_a_disturbance_comes_at_all_phases_of_the_step() -> None:
    cells = [c for c in plan(Path("x.toml"), SMALL).study.cells if c.values["test"] == "step up"]
    mine = [c for c in cells if c.values["controller"] == "paper" and c.values["engine"] == "hybrid"]
    gait = mine[0].controller().gait
    assert gait is not None
    places = np.array([float(c.values["terrain.first"]) for c in mine if c.values["magnitude"] == 0.01])
    assert places / gait.step_length == pytest.approx(3.0 + (np.arange(4) + 0.5) / 4)


def test_unless_a_file_says_otherwise_all_disturbances_are_tried() -> None:
    assert len(plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1}}).disturbances) >= 4
    assert plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1, "slope up": True}}).disturbances == ("slope up",)
    assert plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1, "slope up": False}}).disturbances == ()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"sedes": 3}, "unknown key 'sedes'"),
        ({"engine": "drake"}, "unknown engine 'drake'"),
        ({"grounds": ["stairs"]}, "unknown random ground 'stairs'"),
        ({"grounds": ["treads:seed=1"]}, "leave seed out, the study draws the seeds itself"),
        ({"grounds": ["treads:length=9"]}, "leave length out"),
        ({"grounds": ["treads:deviatoin=1"]}, "deviatoin"),
        ({"grounds": ["waves", "waves"]}, "list of different texts"),
        ({"limits": {"step upp": True}}, "unknown key of limits 'step upp'"),
        ({"limits": {"step up": [0.02, 0.01]}}, "magnitudes must ascend"),
        ({"limits": {"step up": []}}, "list of magnitudes"),
        ({"limits": {"share": 0.2}}, "limits.share = 0.2"),
        ({"limits": {"torque": -1}}, "limits.torque"),
        ({"limits": 3}, "limits must be a table"),
        ({"margins": {"torque limit": [10, 20]}}, "margins.torque limit: magnitudes must descend"),
        ({"margins": {"ground": 3}}, "a random ground is a text, as 'treads:deviation=0.03', got 3"),
        ({"limits": {"phases": 1_000_000}}, "at most"),
        ({"margins": {"ground": "stairs"}}, "unknown random ground 'stairs'"),
        ({"scuffing": {"raech": 1}}, "raech"),
        ({"controller": {"name": "adaptive"}}, r"must be tables \[\[controller\]\]"),
        ({"controller": [{}, {}]}, "controller 2: label = 'adaptive': must be a text of its own"),
        ({"controller": [{"position_gain": [3, 5]}]}, "give each variant a"),
        ({"controller": [{"name": "adaptiv"}]}, "adaptive"),
        ({"controller": [{"position_gain": -3}]}, "position_gain"),
    ],
)
def test_what_no_study_can_have_is_refused(content: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        plan(tmp_path / "x.toml", content)


def test_messages_name_the_file(tmp_path: Path) -> None:
    file = tmp_path / "x.toml"
    file.write_text("seeds = 0\n")
    with pytest.raises(InputError, match=r"robustness study .*x.toml: seeds = 0"):
        read_plan(file)
