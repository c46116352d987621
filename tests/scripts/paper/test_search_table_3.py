"""The search for Table III's ground: its measure, and that a seed finds the same ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mjbiped import Terrain
from mjbiped.studies.cell import Row
from mjbiped.studies.reproduction.section_5 import FOUND, TABLE_3, end_of
from scripts.paper import placebo as family
from scripts.paper import search_table_3 as search


def results(factor: float = 1.0, outcome: str = "finished") -> list[Row]:
    """Walks whose torques and c_mt are the paper's times a factor."""
    return [
        {"outcome": outcome, "steps": 1, "ankle": factor * torque, "hip": 1.0, "absolute_end": factor * cost}
        for torque, cost in TABLE_3.values()
    ]


def test_distance_of_the_table_from_itself_is_zero() -> None:
    assert search.distance(results()) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("factor", [0.5, 1.1, 3.0])
def test_distance_of_a_multiple_is_its_logarithm(factor: float) -> None:
    assert search.distance(results(factor)) == pytest.approx(abs(math.log(factor)), rel=1e-12)


def test_fall_is_farther_than_any_walk_to_the_end() -> None:
    assert search.distance(results(outcome="fell")) > search.distance(results(1000.0))


def test_data_file_is_of_the_family_that_was_searched() -> None:
    assert len(FOUND) == family.SEGMENTS
    for k, values in enumerate(FOUND):
        for value, (low, high) in zip(values, (family.LENGTHS, family.SLOPES, family.RISES), strict=True):
            assert low <= value <= high
        assert k > 0 or values[2] == 0.0
    terrain, last = Terrain.from_segments(FOUND), FOUND[-1]
    assert end_of(FOUND) == pytest.approx(terrain.x[-1] + last[0] * math.cos(math.radians(last[1])), rel=1e-15)


@pytest.mark.slow
def test_a_seed_finds_the_same_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nearer than the first generation's best, and the same again."""
    monkeypatch.setattr(family, "SEGMENTS", 2)
    first, second = (search.search(seed=3, generations=2, population=1) for _ in range(2))
    assert first == second
    assert first.evaluations == 3 * 8  # 5 numbers, rounded up to a power of two, and two generations more
    assert first.distance == search.distance(search.walked(first.segments))


def test_parameters_become_segments_of_short_numbers() -> None:
    parameters = np.concatenate([[1.2345, -0.04], np.tile([2.0, 1.26, -0.05049], family.SEGMENTS - 1)])
    segments = family.segments_of(parameters)
    assert segments[0] == (1.23, 0.0, 0.0)
    assert math.copysign(1.0, segments[0][1]) == 1.0
    assert segments[1:] == ((2.0, 1.3, -0.05),) * (family.SEGMENTS - 1)
