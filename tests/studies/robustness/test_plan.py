"""What a robustness study's file asks for, and what of it is refused."""

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjbiped.errors import InputError
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.limit_cycles.basin import Fate, basin_of_control, rates_around
from mjbiped.robots.compass import Compass
from mjbiped.studies import robustness_walks as plans
from mjbiped.studies.robustness import plan, read_plan
from mjbiped.studies.robustness_walks import BASIN, BASIN_RATES, DISTURBANCES, LEVEL, MARGINS, SURVIVAL
from mjbiped.terrain.terrain import Terrain

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


def test_a_controller_may_have_weak_motors_of_its_own() -> None:
    content = SMALL | {"controller": [{"label": "any"}, {"label": "weak", "torque_limit": 50}]}
    cells = plan(Path("x.toml"), content | {"margins": {"torque limit": [20]}}).study.cells
    limits = {(c.values["controller"], c.values["test"]): c.section("disturbances").get("torque_limit") for c in cells}
    assert (limits["weak", LEVEL], limits["weak", "step up"], limits["any", LEVEL]) == (50.0, 50.0, None)
    assert limits["weak", "torque limit"] == limits["any", "torque limit"] == 20.0


def test_unless_a_file_says_otherwise_all_disturbances_are_tried() -> None:
    assert len(plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1}}).limits.magnitudes) >= 4
    assert plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1, "slope up": True}}).limits.magnitudes.keys() == {
        "slope up"
    }
    assert plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1, "slope up": False}}).limits.magnitudes == {}
    for limits, count in (({}, BASIN_RATES), ({"step up": True}, 0), ({"step up": True, "basin": 4}, 4)):
        assert plan(Path("x.toml"), {"seeds": 1, "limits": {"phases": 1, **limits}}).limits.basin == count
    without = plan(Path("x.toml"), {"grounds": [], "limits": {"step up": False, "basin": False}})
    assert [cell.values["test"] for cell in without.study.cells] == [LEVEL]


def test_a_file_that_names_grounds_alone_tries_no_single_disturbances() -> None:
    content: dict[str, Any] = {"seeds": 2, "grounds": ["treads"]}
    assert [c.values["test"] for c in plan(Path("x.toml"), content).study.cells] == [LEVEL, SURVIVAL, SURVIVAL]
    neither, both = plan(Path("x.toml"), {"seeds": 1}), plan(Path("x.toml"), content | {"limits": {}})
    assert (len(neither.grounds), len(neither.limits.magnitudes)) == (1, len(DISTURBANCES))
    assert both.limits.magnitudes == neither.limits.magnitudes
    assert both.limits.basin == neither.limits.basin == BASIN_RATES


def test_all_margins_can_be_walked_in_both_engines() -> None:
    wanted = plan(
        Path("x.toml"), {"engine": ["hybrid", "mujoco"], "seeds": 1, "limits": {"basin": False}, "margins": {}}
    )
    assert set(wanted.margins.magnitudes) == set(MARGINS)
    for name, margin in MARGINS.items():  # all values have been checked as a walk would
        tried = [c.values["magnitude"] for c in wanted.study.cells if c.values["test"] == name]
        assert tried == [*margin.magnitudes, *margin.magnitudes]


def test_a_basin_is_that_of_its_own_module(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plans, "BASIN_WIDTH", 1.0)  # from all of the wide one this controller falls
    limits = {"step up": False, "basin": 6, "steps_after": 8}
    wanted = plan(Path("x.toml"), {"seeds": 1, "limits": limits, "controller": [{"name": "passivity"}]})
    cells = [cell for cell in wanted.study.cells if cell.values["test"] == BASIN]
    stance, swing = rates_around(find_passive_gait(Compass(), math.radians(2)).start, 6)
    basin = basin_of_control(cells[0].controller(), stance_rates=stance, swing_rates=swing, limit=8)
    rows = [cell.row() for cell in cells]
    finished = np.array([row["outcome"] == "finished" for row in rows]).reshape(6, 6).T
    assert 0 < finished.sum() < finished.size
    np.testing.assert_array_equal(finished, (basin.fates == Fate.SETTLED) | (basin.fates == Fate.UNDECIDED))
    torques = np.array([max(row["peak_ankle_torque_Nm"] or 0.0, row["peak_hip_torque_Nm"] or 0.0) for row in rows])
    # the map leaves a walk when it has settled to 1e-3; its greatest torque, of the first steps, was before that
    settled = basin.fates.T.ravel() == Fate.SETTLED
    np.testing.assert_allclose(torques[settled], basin.peak_torque.T.ravel()[settled], rtol=1e-9)


def test_seeds_walk_on_stretches_of_a_record_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "trail.csv").write_text("x,z\n0,0\n3,0.1\n7,-0.1\n9,0\n")
    content = {"grounds": ["recorded:file=trail.csv"], "seeds": 3, "steps": 20, "limits": {"step up": False}}
    wanted = plan(tmp_path / "x.toml", content)
    cells = [cell for cell in wanted.study.cells if cell.values["test"] == SURVIVAL]
    grounds = [pickle.loads(pickle.dumps(cell)).terrain() for cell in cells]  # as a worker gets them, without the file
    expected = [Terrain.recorded(tmp_path / "trail.csv", seed=seed, length=2.0 + 20 * 0.6) for seed in range(3)]
    assert grounds == expected
    (tmp_path / "trail.csv").write_text("x,z\n0,0\n3,0.1\n7,-0.1\n9,0.01\n")
    assert plan(tmp_path / "x.toml", content).study.digest != wanted.study.digest  # another study


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"sedes": 3}, "unknown key 'sedes'"),
        ({"grounds": ["stairs"]}, "unknown random ground 'stairs'"),
        ({"grounds": ["treads:seed=1"]}, "leave seed out, the study draws the seeds itself"),
        ({"grounds": ["recorded"]}, "recorded ground needs an elevation file"),
        ({"grounds": ["waves", "waves"]}, "each of them once"),
        ({"limits": {"step up": [0.02, 0.01]}}, "magnitudes must ascend"),
        ({"limits": {"step up": []}}, "magnitudes must ascend"),
        ({"limits": 3}, "limits must be a table"),
        ({"limits": {"basin": 1}}, "limits.basin = 1: must be a whole number from 2"),
        ({"margins": {"torque limit": [10, 20]}}, "margins.torque limit: magnitudes must descend"),
        ({"margins": {"ground": 3}}, "a random ground is a text, as 'treads:deviation=0.03', got 3"),
        ({"limits": {"phases": 1_000_000}}, "at most"),
        ({"controller": {"name": "adaptive"}}, r"must be tables \[\[controller\]\]"),
        ({"controller": [{}, {}]}, "controller 2: label = 'adaptive': must be a text of its own"),
        ({"controller": [{"position_gain": [3, 5]}]}, "give each variant a"),
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
