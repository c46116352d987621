"""Cells of the reproduction: what their keys hold, and that one walk gives the c_mt of every shorter one."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path

import pytest

import mjbiped
from controllers import Controller, Memory
from mjbiped.studies.cell import FAILED, Cell, attempt
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction.cell import cost_after, key, measures_of, record_path
from mjbiped.studies.reproduction.section_5 import adaptive


class Breaks(Controller):
    """Raises an error in its second step."""

    memory_size = 1

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        memory[0] += 1.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if memory[0] > 0.0:
            raise RuntimeError("broken")
        return 0.0, 0.0


STAIRS = mjbiped.Terrain.stairs(rise=-0.02)
LAW = adaptive(0.8)


@pytest.fixture
def cell() -> Cell:
    return cells.cell(STAIRS, LAW, steps=7, engine="hybrid")


def test_every_input_has_its_key(cell: Cell) -> None:
    others = [
        cells.cell(STAIRS, LAW, steps=7, engine="mujoco"),
        cells.cell(STAIRS, adaptive(0.8, adaptation_gain=0.4), steps=7, engine="hybrid"),
        cells.cell(mjbiped.Terrain.stairs(rise=-0.021), LAW, steps=7, engine="hybrid"),
        cells.cell(STAIRS, LAW, steps=7, engine="hybrid", initial="rest"),
        cells.cell(STAIRS, LAW, steps=8, engine="hybrid"),
        cells.cell(STAIRS, LAW, distance=3.0, engine="hybrid"),
        cells.cell(STAIRS, LAW, steps=7, engine="hybrid", record=True),
    ]
    keys = [*map(key, (cell, *others))]
    assert len(set(keys)) == len(keys)
    assert key(dataclasses.replace(cell)) == keys[0]


def test_key_holds_versions_and_sources(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    first = key(cell)
    monkeypatch.setattr(cells, "machinery", lambda: {"sources": "mended"})
    assert key(cell) != first


@pytest.mark.parametrize("length", [1, 4, 7])
def test_cost_after_some_steps_is_that_of_the_shorter_walk(cell: Cell, length: int) -> None:
    whole = cell.walk()
    shorter = mjbiped.walk(cell.controller(), cell.terrain(), engine="hybrid", steps=length)
    for kind in ("absolute", "net", "positive"):
        # the same numbers of the same steps: bit by bit
        assert cost_after(whole, kind, length) == mjbiped.records.measures.cost_of_transport(shorter, kind)
    assert math.isnan(cost_after(whole, "absolute", 8))  # not walked
    assert measures_of(whole)["steps"] == 7
    assert measures_of(whole)["absolute_end"] == cost_after(whole, "absolute")
    assert math.isnan(measures_of(whole)["absolute_20"])


def test_least_force_is_that_of_the_whole_walk_in_weights(cell: Cell) -> None:
    least = measures_of(cell.walk())["least_force"]
    walk = mjbiped.walk(cell.controller(), cell.terrain(), engine="hybrid", steps=7)
    assert least == walk.touchdowns["normal_force"].min() / (10.0 * 9.81)
    assert 0.0 < least < 1.0


def test_record_is_kept_where_it_is_asked_for(cell: Cell, tmp_path: Path) -> None:
    kept = cells.cell(STAIRS, LAW, steps=2, engine="hybrid", record=True)
    row = cells.row(kept, tmp_path)
    record = mjbiped.Walk.load(record_path(tmp_path, kept))
    assert record.steps == row["steps"] == 2
    assert len(record.samples["time"]) > 200  # every 5 ms of 1.5 s
    cells.row(cell, tmp_path)
    assert not record_path(tmp_path, cell).exists()


def test_error_is_a_result() -> None:
    def walked(slope: float) -> mjbiped.Walk:
        return mjbiped.walk(Breaks(), mjbiped.Terrain.incline(slope), engine="hybrid", steps=3)

    row = attempt(lambda: walked(2.0), measures_of)
    assert row["outcome"] == FAILED
    assert "broken" in row["error"]
    assert row["steps"] == 1
    row = attempt(lambda: walked(-3.0), measures_of)
    assert row["outcome"] == FAILED
    assert "no passive gait" in row["error"] or "downhill" in row["error"]
