"""The readings of Table II's grounds, against profiles written down from the paper's sentence."""

from __future__ import annotations

import math

import pytest

from mjbiped.studies.reproduction.section_5 import (
    GROUNDS,
    PRINTED,
    READINGS,
    SLOPE_PATTERNS,
    STAIR_PATTERNS,
    TABLE_2,
    TABLE_3,
    Place,
    terrain_of,
)


@pytest.mark.parametrize(
    ("pattern", "heights"),
    [
        ("descending", [0.0, -0.06, -0.12, -0.18]),
        ("ascending", [0.0, 0.06, 0.12, 0.18]),
        ("alternating, down first", [0.0, -0.06, 0.0, -0.06]),
        ("alternating, up first", [0.0, 0.06, 0.0, 0.06]),
    ],
)
@pytest.mark.parametrize("first", [0.9, 1.8])
def test_stairs(pattern: str, heights: list[float], first: float) -> None:
    terrain = terrain_of(Place("stair 2", pattern, first))
    for k, height in enumerate(heights):
        for x in (0.01, first - 0.01) if k == 0 else (first + 1.8 * (k - 1) + 0.01, first + 1.8 * k - 0.01):
            assert terrain.height(x) == pytest.approx(height, abs=1e-12)
            assert terrain.slope(x) == 0.0


@pytest.mark.parametrize(
    ("pattern", "slopes"),
    [
        ("accumulating downhill", [0, 1, 2, 3]),
        ("accumulating uphill", [0, -1, -2, -3]),
        ("level and downhill in turn", [0, 1, 0, 1]),
        ("level and uphill in turn", [0, -1, 0, -1]),
        ("down and up in turn, ±Δ", [1, -1, 1, -1]),
        ("up and down in turn, ±Δ", [-1, 1, -1, 1]),
        ("down and up in turn, ±Δ/2", [0.5, -0.5, 0.5, -0.5]),
        ("up and down in turn, ±Δ/2", [-0.5, 0.5, -0.5, 0.5]),
    ],
)
@pytest.mark.parametrize("first", [0.9, 1.5])
@pytest.mark.parametrize(("ground", "change"), [("slope 1", 0.3), ("slope 2", 1.0)])
def test_slopes(ground: str, change: float, pattern: str, slopes: list[float], first: float) -> None:
    terrain = terrain_of(Place(ground, pattern, first))
    x = 0.0
    for k, factor in enumerate(slopes):
        length = (1.5 if k else first) * math.cos(math.radians(factor * change))
        assert math.degrees(terrain.slope(x + 0.5 * length)) == pytest.approx(factor * change, abs=1e-12)
        x += length
    assert not any(terrain.rises)  # slopes meet without a step


def test_every_reading_has_its_own_ground() -> None:
    every = [terrain_of(place) for place in READINGS]
    assert len(set(every)) == len(every) == 1 + 2 * 2 * len(STAIR_PATTERNS) + 4 * len(SLOPE_PATTERNS)
    assert all(terrain.x[-1] > 100 * 0.38 for terrain in every[1:])  # ground for 100 steps


def test_patterns_as_printed_exist() -> None:
    for ground, pattern, _ in PRINTED:
        assert pattern in (STAIR_PATTERNS if ground.startswith("stair") else SLOPE_PATTERNS)


def test_the_papers_tables_are_whole() -> None:
    assert all(tuple(values) == GROUNDS for values in TABLE_2.values())
    assert sum(math.isnan(value) for values in TABLE_2.values() for value in values.values()) == 5  # its X
    assert list(TABLE_3)[1:] == [round(0.1 * k, 1) for k in range(1, 11)]
