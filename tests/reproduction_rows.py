"""Rows of a reproduction that was never walked, for tests that know what should come of them; settings that were."""

import csv
import io
import math

from mjbiped.studies.reproduction.cell import COSTS
from mjbiped.studies.reproduction.results import NO_WALK, Row
from mjbiped.studies.reproduction.section_5 import TABLE_3
from scripts.paper.placebo import RandomGround


def made_row(cost: float, **others: object) -> Row:
    """A walk of 100 steps to its end, whose c_mt is this one for whatever kind and length."""
    fields = {
        "part": "table 2", "ground": "level", "engine": "hybrid", "method": "adaptive", "first": 0.0,
        "delay": 0.8, "adaptation_gain": 0.3, "update": "yes", "start_estimate": 0.0,
        "outcome": "finished", "steps": 100, "place": 38.0, "ankle": 2.0, "hip": 1.0, "friction": 0.2,
        "least_force": 0.9, "begun": 0.0, "ended": 0.0, "rms": 0.0, "jump": 0.0, **dict.fromkeys(COSTS, cost),
    }  # fmt: skip
    return changed(NO_WALK, **{**fields, **others})


def changed(row: Row, **others: object) -> Row:
    """A row with other values in some columns."""
    return Row(**{**vars(row), **others})


def fallen(**others: object) -> Row:
    """A walk that fell in its fourth step."""
    return made_row(math.nan, **{"outcome": "fell", "steps": 3, **others})


def read_grounds(text: str) -> list[RandomGround]:
    """The grounds that `scripts.paper.placebo.write_grounds` wrote."""
    found = []
    for line in list(csv.reader(io.StringIO(text)))[1:]:
        tables = [float(value) for value in line[-2 * len(TABLE_3) :] if value]
        numbers = [float(value) for value in line[: -2 * len(TABLE_3)]]
        segments = tuple((numbers[k], numbers[k + 1], numbers[k + 2]) for k in range(0, len(numbers), 3))
        found.append(RandomGround(segments, tuple(tables[: len(TABLE_3)]), tuple(tables[len(TABLE_3) :])))
    return found
