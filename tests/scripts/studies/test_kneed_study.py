"""The study of robots with knees: what its cells count."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped import Terrain
from mjbiped.records.record import Walk
from scripts.studies import kneed_study as study

CLIFF = Terrain.stairs(rise=0.2, first=1.5)
"""A riser too high for straight legs of a passive gait."""


@pytest.fixture(scope="module")
def walks(adaptive: AdaptiveController) -> list[Walk]:
    return [mjbiped.walk(adaptive, ground, engine="hybrid", steps=8) for ground in (Terrain.level(), CLIFF)]


@pytest.fixture(scope="module")
def adaptive() -> AdaptiveController:
    robot = mjbiped.Compass()
    return AdaptiveController(robot, mjbiped.find_passive_gait(robot, np.deg2rad(2.0)))


def test_a_cell_counts_walks_that_come_through(walks: list[Walk]) -> None:
    assert [walk.outcome for walk in walks] == ["finished", "fell"]
    cost, torque = walks[0].cost_of_transport, walks[0].peak_torque
    assert study.share_and_cost(walks) == f"1 of 2, {cost:.4f}"
    assert study.torques(walks) == f"{torque[0]:.1f},\u00a0{torque[1]:.1f}"
    assert study.share_and_cost(walks[:1]) == f"yes, {cost:.4f}"
    assert study.share_and_cost(walks[1:]) == "no"
    assert study.torques(walks[1:]) == "-"
    assert study.soles(walks) == f"{100.0 * walks[0].summary()['foot_length_99_percent_m']:.0f}"
    assert study.soles(walks[1:]) == "-"
    assert study.with_torques("told", walks[1:]) == "told"
    assert study.with_torques("told", walks) == f"told; {study.torques(walks)}"


def test_a_walk_of_tiny_steps_has_not_come_through() -> None:
    # the passive gait of 0.05° steps 0.107 m, docs/gaits.md
    walk = mjbiped.walk(
        PassiveController(), Terrain.incline(0.05), engine="hybrid", steps=4, scuffing=mjbiped.ScuffingRule(reach=0.05)
    )
    assert walk.outcome == "finished"
    assert study.came_through([walk]) == []


def test_costs_are_compared_where_both_come_through(adaptive: AdaptiveController, walks: list[Walk]) -> None:
    level, cliff = walks
    down = mjbiped.walk(adaptive, Terrain.incline(1.0), engine="hybrid", steps=8)
    difference = down.cost_of_transport - level.cost_of_transport
    assert difference < 0.0
    expected = f"2 of 2, {(down.cost_of_transport + level.cost_of_transport) / 2:.4f} (−{-difference:.5f})"
    assert study.beside([down, level], [level, cliff]) == expected
    assert "(" not in study.beside([level], [cliff])
    assert study.beside([cliff], [level]) == "no"
    assert "(+0.00000)" in study.beside([level], [level])


def test_grounds_begin_at_places_over_one_step_and_bear_their_names() -> None:
    grounds = dict(study.grounds(0.4))
    firsts = [terrain.x[1] for terrain in grounds["stairs −4 cm"]]
    np.testing.assert_allclose(np.diff(firsts), 0.4 / study.PLACES, rtol=0, atol=1e-12)  # rounding
    assert all(terrain.rises[1] == pytest.approx(-0.04) for terrain in grounds["stairs −4 cm"])
    assert all(terrain.slope(3.0) == pytest.approx(np.deg2rad(5.0)) for terrain in grounds["level, then +5°"])


@pytest.mark.slow
def test_the_study_writes_its_tables_of_both_engines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    passive = {name: make for name, make in study.walkers().items() if "passive" in name}
    monkeypatch.setattr(study, "walkers", lambda: passive)
    monkeypatch.setattr(study, "HEIGHTS_CM", (-2,))
    monkeypatch.setattr(study, "PLACES", 1)
    monkeypatch.setattr(study, "STAIRS", 1)
    monkeypatch.setattr(study, "climbers", lambda: {"climbs nothing": next(iter(passive.values()))()})
    told = CliRunner().invoke(study.main, ["--steps", "6", "--tables", str(tmp_path)], catch_exceptions=False)
    assert told.exit_code == 0
    walks, stairs, mujoco = (
        (tmp_path / f"{name}.csv").read_text(encoding="utf-8") for name in ("walks", "any_stairs", "mujoco")
    )
    assert "+6 cm,no" in stairs
    assert "straight legs" in walks
    assert "straight legs" not in mujoco
    # both engines walk the passive gait at c_mt within 0.0001: tests/engines/conformance holds them together
    level = next(line for line in mujoco.splitlines() if line.startswith("level,"))
    assert "(+0.0000" in level or "(−0.0000" in level
