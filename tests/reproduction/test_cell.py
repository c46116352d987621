"""Cells of the reproduction: what their keys hold, and that one walk gives the c_mt of every shorter one."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence

import pytest

import mjbiped
from controllers import AdaptiveController, Controller, Memory
from mjbiped.reproduction import cell as cells
from mjbiped.reproduction.cell import Cell, Result, measured


class Breaks(Controller):
    """Raises an error in its second step."""

    memory_size = 1

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        memory[0] += 1.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if memory[0] > 0.0:
            raise RuntimeError("broken")
        return 0.0, 0.0


@pytest.fixture
def cell(controller: AdaptiveController) -> Cell:
    return Cell("hybrid", controller, mjbiped.Terrain.stairs(rise=-0.02), steps=7)


def test_every_input_has_its_key(cell: Cell) -> None:
    law = cell.controller
    assert isinstance(law, AdaptiveController)
    others = [
        dataclasses.replace(cell, engine="mujoco"),
        dataclasses.replace(cell, engine="mujoco", timestep=1e-4),
        dataclasses.replace(cell, controller=dataclasses.replace(law, adaptation_gain=0.4)),
        dataclasses.replace(cell, terrain=mjbiped.Terrain.stairs(rise=-0.021)),
        dataclasses.replace(cell, initial="rest"),
        dataclasses.replace(cell, steps=8),
        dataclasses.replace(cell, distance=3.0),
        dataclasses.replace(cell, record=True),
    ]
    keys = [cell.key, *(other.key for other in others)]
    assert len(set(keys)) == len(keys)
    assert dataclasses.replace(cell).key == cell.key
    assert dataclasses.replace(cell, timestep=1e-4).key == cell.key  # the hybrid engine has none


def test_key_holds_versions_and_sources(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    first = cell.key
    monkeypatch.setattr(cells, "versions", lambda: {"mujoco": "another"})
    second = dataclasses.replace(cell).key
    monkeypatch.setattr(cells, "sources", lambda: "mended")
    assert len({first, second, dataclasses.replace(cell).key}) == 3


@pytest.mark.parametrize("length", [1, 4, 7])
def test_cost_after_some_steps_is_that_of_the_shorter_walk(cell: Cell, length: int) -> None:
    result, record = measured(cell)
    assert record is None
    shorter = mjbiped.walk(cell.controller, cell.terrain, engine="hybrid", steps=length)
    for kind in ("absolute", "net", "positive"):
        # the same numbers of the same steps: bit by bit
        assert result.cost_of_transport(kind, length) == mjbiped.records.measures.cost_of_transport(shorter, kind)
    assert result.cost_of_transport("absolute", 8) != result.cost_of_transport("absolute", 8)  # NaN: not walked
    assert result.steps == 7


def test_least_force_is_that_of_the_whole_walk_in_weights(cell: Cell) -> None:
    result, _ = measured(cell)
    walk = mjbiped.walk(cell.controller, cell.terrain, engine="hybrid", steps=7)
    assert result.least_force == walk.touchdowns["normal_force"].min() / (10.0 * 9.81)
    assert 0.0 < result.least_force < 1.0


def test_record_is_kept_where_it_is_asked_for(cell: Cell) -> None:
    result, record = measured(dataclasses.replace(cell, record=True, steps=2))
    assert record is not None
    assert record.steps == result.steps == 2
    assert len(record.samples["time"]) > 200  # every 5 ms of 1.5 s


def test_result_survives_json(cell: Cell) -> None:
    result, _ = measured(cell)
    assert Result.from_dict(json.loads(json.dumps(result.to_dict()))) == result


def test_error_is_a_result() -> None:
    result, _ = measured(Cell("hybrid", Breaks(), mjbiped.Terrain.incline(2.0), steps=3))
    assert result.outcome == "failed"
    assert "broken" in result.error
    assert result.steps == 1
    result, _ = measured(Cell("hybrid", Breaks(), mjbiped.Terrain.incline(-3.0), steps=3))
    assert "no passive gait" in result.error or "downhill" in result.error
