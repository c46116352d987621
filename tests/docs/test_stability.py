"""The prose of docs/stability.md about walks is true of the table of walks."""

from __future__ import annotations

import re

from documentation import table, text

PROSE = " ".join(text("docs/stability.md").split())
WALKS = table("stability", "walks")
STEEP = "stairs −6 cm"


def told(sentence: str) -> list[str]:
    """The numbers that a sentence of the page tells where the pattern has groups."""
    found = re.search(sentence, PROSE)
    assert found, sentence
    return list(found.groups())


def ends(column: str, grounds: list[str]) -> list[str]:
    """The least and the greatest number of a column with ranges, of some grounds, as written."""
    cells = [row[column].split(" to ") for row in WALKS if row["ground"] in grounds]
    return [choose(each, key=float) for choose, each in zip((min, max), zip(*cells, strict=True), strict=True)]


def least(column: str, grounds: list[str]) -> str:
    """The least number of a column, of some grounds, as written."""
    return min((row[column] for row in WALKS if row["ground"] in grounds), key=float)


def test_ranges_are_those_of_the_walks() -> None:
    grounds = list(dict.fromkeys(row["ground"] for row in WALKS))
    others = [ground for ground in grounds if ground != STEEP]
    eigenvalue = r"over a step ([\d.]+) to ([\d.]+) 1/s³ on level ground, .*?, ([\d.]+) to ([\d.]+) on stairs of −6 cm"
    assert told(eigenvalue) == [*ends("weak eigenvalue", others), *ends("weak eigenvalue", [STEEP])]
    condition = r"which is ([\d.]+) or more, and ([\d.]+) or more for any .*? the other grounds ([\d.]+) and ([\d.]+)\)"
    columns = ("(24), least", "its floor")
    assert told(condition) == [least(column, where) for where in ([STEEP], others) for column in columns]
    assert told(r"([\d.]+) to ([\d.]+) along the tables' walks") == ends("‖Φ‖", grounds)
