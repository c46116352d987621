"""How the best reading of Table II is chosen, on tables whose answer is known."""

from __future__ import annotations

import math

import pytest
from reproduction_rows import changed, made_row

from mjbiped.studies.reproduction.cell import COSTS, LENGTHS
from mjbiped.studies.reproduction.results import Results, Row, read_rows, side_distances, write_rows
from mjbiped.studies.reproduction.section_5 import GROUNDS, SLOPE_SOURCES, STAIRS, TABLE_2

PAPER = TABLE_2["adaptive"]


def row(ground: str, pattern: str, first: float, factor: float, delay: float | None = 0.8, **others: object) -> Row:
    """A walk whose c_mt is the paper's times a factor, of whatever kind and length."""
    paper = PAPER[ground]
    fields = {"ground": ground, "pattern": pattern, "first": first, "delay": delay, **others}
    return made_row(factor * paper, **fields)


@pytest.fixture
def rows() -> list[Row]:
    factors = {
        ("stair", "down"): (1.1, 1.1), ("stair", "up"): (1.3, 1.3),
        ("slope", "down"): (1.02, 1 / 1.02), ("slope", "up"): (0.9, 1.0),
    }  # fmt: skip
    return [
        row(f"{kind} {k + 1}", pattern, 0.9, pair[k], delay=delay)
        for (kind, pattern), pair in factors.items()
        for k in range(2)
        for delay in (0.8, None)
    ]


def test_nearest_choice_and_its_distance(rows: list[Row]) -> None:
    found = Results(rows).readings
    assert len(found) == 2 * 3 * len(LENGTHS) * 2 * 2
    best = found[0]
    assert (best.stairs, best.slopes) == (("down", 0.9), ("down", 0.9))
    expected = math.sqrt((2 * math.log(1.1) ** 2 + 2 * math.log(1.02) ** 2) / 4)
    assert best.distance == pytest.approx(expected, rel=1e-12)
    assert [choice.distance for choice in found] == sorted(choice.distance for choice in found)
    assert best.places[0] == ("level", "", 0.0)
    assert {ground for ground, _, _ in best.places} == set(GROUNDS)


def test_a_length_that_fits_better_is_chosen(rows: list[Row]) -> None:
    better = [changed(r, net_45=PAPER[r.ground]) if r.pattern == "up" and r.delay is None else r for r in rows]
    best = Results(better).best
    assert (best.kind, best.length, best.stairs[0], best.slopes[0], best.distance) == ("net", 45, "up", "up", 0.0)
    assert best.delay is None


def test_ground_that_is_not_walked_cannot_be_chosen(rows: list[Row]) -> None:
    nothing = dict.fromkeys(COSTS, math.nan)
    lost = [changed(r, **nothing) if r.pattern == "down" and r.ground == "stair 2" else r for r in rows]
    found = Results(lost).readings
    assert found[0].stairs[0] == "up"
    assert math.isinf(found[-1].distance)
    sides = {side.stairs[0]: side.distance for side in side_distances(lost, STAIRS)}
    assert math.isinf(sides["down"])
    assert sides["up"] == pytest.approx(math.log(1.3), rel=1e-12)


def test_source_whose_failures_are_the_papers_is_first(rows: list[Row]) -> None:
    best = Results(rows).best
    walks = list(rows)
    for method in ("PBC", "ECC", "KETC"):
        for source in SLOPE_SOURCES:
            for place in best.places:
                paper = TABLE_2[method][place[0]]
                fails = math.isnan(paper) and source == "local"
                walk = row(*place, 1.0, delay=None, method=method, slope_source=source)
                value = math.nan if fails else 1.05 * (0.03 if math.isnan(paper) else paper)
                walks.append(changed(walk, **dict.fromkeys(COSTS, value)))
    results = Results(walks)
    found = {source: results.agreement("hybrid", source) for source in results.sources}
    assert next(iter(found)) == "local"
    assert (found["local"].agreeing, found["local"].asked) == (15, 15)
    assert {a.agreeing for source, a in found.items() if source != "local"} == {10}  # the paper's five X are walked
    assert all(a.distance == pytest.approx(math.log(1.05), rel=1e-12) for a in found.values())


def test_table_survives_its_file(rows: list[Row]) -> None:
    text = write_rows(read_rows(write_rows(rows)))  # of six digits
    assert write_rows(read_rows(text)) == text
    assert len(read_rows(text)) == len(rows)
