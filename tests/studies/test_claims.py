"""Claims about the paper: its own numbers fulfil every one, and each fails on numbers that contradict it."""

import math
from collections.abc import Callable, Sequence
from itertools import product

import pytest
from reproduction_rows import changed as altered
from reproduction_rows import fallen, made_row

from mjbiped.studies.reproduction.cell import COSTS
from mjbiped.studies.reproduction.claims import BLIND, FITTED, FOUND, GROUPS, UNFITTED, Answer, checks
from mjbiped.studies.reproduction.results import Choice, Results, Row
from mjbiped.studies.reproduction.section_5 import ADAPTATION_GAINS, START_ESTIMATES, TABLE_3
from mjbiped.studies.reproduction.section_5 import TABLE_2 as PAPER

BEST = Choice(0.8, "absolute", 20, ("descending", 0.9), ("down", 1.5), 0.0)
GOOD = {
    "trace_settled": 0.01, "trace_later": 0.02, "trace_off_time": 1.0, "trace_error": 0.1, "trace_travel": 3.0,
    "trace_z1": 0.1, "trace_z2": 0.01, "trace_straight": 0.1, "trace_bent": 2.0,
}  # fmt: skip
"""Of a walk of which all is true that the paper says."""
POOR = {**GOOD, "trace_off_time": 6.0, "trace_error": 0.4, "trace_travel": 40.0, "trace_z2": 1.5}
"""Without update, or without re-planning."""

Change = Callable[[Row], Row]


def paper_s() -> list[Row]:
    """The paper's numbers as if they had been walked, in the hybrid engine."""
    rows = []
    for ground, pattern, first in BEST.places:
        for method, values in PAPER.items():
            cost = values[ground]
            place = {"ground": ground, "pattern": pattern, "first": first, "method": method}
            parts: list[dict[str, object]] = [{}]
            if method != "adaptive":
                parts = [{"part": part, "delay": None, "slope_source": "local"} for part in (BLIND, FITTED)]
            rows += [fallen(**place, **part) if math.isnan(cost) else made_row(cost, **place, **part) for part in parts]
    for ground in ("mixed", "found"):
        for zeta, (torque, cost) in TABLE_3.items():
            mine = {"part": "table 3", "ground": ground, "ankle": torque, "delay": zeta}
            rows.append(made_row(cost, **(POOR if zeta is None else GOOD), **mine))
    for gain, start, update in product(ADAPTATION_GAINS, START_ESTIMATES, ("yes", "no")):
        mine = {"part": "figure 5", "ground": "mixed", "adaptation_gain": gain, "start_estimate": start}
        found = {**GOOD, "begun": 0.05, "jump": 0.0} if update == "yes" else {**POOR, "begun": 2.0, "jump": 2.0}
        rows.append(made_row(0.04, **mine, update=update, ended=0.05, **found))
    return rows


def changed(where: dict[str, object], change: Change) -> list[Row]:
    """The paper's numbers with some rows changed; NaN fits NaN."""
    rows = paper_s()
    fits = [all(str(getattr(row, name)) == str(value) for name, value in where.items()) for row in rows]
    assert any(fits), f"no row is {where}"
    return [change(row) if fit else row for row, fit in zip(rows, fits, strict=True)]


def having(**fields: object) -> Change:
    return lambda row: altered(row, **fields)


def costs(value: float) -> Change:
    return having(**dict.fromkeys(COSTS, value))


def tracing(**values: float) -> Change:
    return having(**{f"trace_{name}": value for name, value in values.items()})


lost = having(outcome="fell", steps=3, **dict.fromkeys(COSTS, math.nan))


def asked(rows: Sequence[Row], words: str, group: str, engine: str = "hybrid") -> Answer:
    """The one answer of an engine to the claim that has these words in it."""
    found = [a for a in checks(Results(rows)) if (a.group, a.engine) == (group, engine) and words in a.claim]
    assert len(found) == 1, [answer.claim for answer in found]
    return found[0]


def test_the_paper_s_own_numbers_fulfil_every_claim() -> None:
    """A claim that they miss would not be the paper's."""
    asked_here = [check for check in checks(Results(paper_s())) if check.engine == "hybrid"]
    assert [answer for answer in asked_here if answer.holds is not True] == []
    assert [sum(check.group == group for check in asked_here) for group in GROUPS] == [19, 20, 20, 13]
    assert all(check.source for check in asked_here)


LEVEL = {"ground": "level"}
MIXED = {"part": "table 3", "ground": "mixed"}
PAPER_S_GAIN = {"part": "figure 5", "adaptation_gain": 0.3}

CONTRADICTIONS = [
    # Table II and V-A: words of the claim, its group, the rows and what is changed in them
    ("the adaptive controller's c_mt is 0.0350", UNFITTED, {**LEVEL, "method": "adaptive"}, costs(0.03494)),
    ("is within 0.0001 of sin 2°", UNFITTED, {**LEVEL, "method": "adaptive"}, costs(0.0351)),
    ("PBC's c_mt is 0.0342", FITTED, {**LEVEL, "method": "PBC"}, costs(0.0349)),
    ("closer than PBC's", FITTED, {**LEVEL, "method": "PBC"}, costs(0.03490)),
    ("closer than ECC's", FITTED, {**LEVEL, "method": "adaptive"}, costs(0.0352)),
    ("same as KETC's", FITTED, {**LEVEL, "method": "KETC"}, costs(0.0349)),
    ("stair 1 every method's c_mt is higher", FITTED, {"ground": "stair 1", "method": "KETC"}, costs(0.03504)),
    ("stair 1 the adaptive controller's c_mt is the lowest", FITTED, {"ground": "stair 1", "method": "ECC"},
     costs(0.0357)),
    ("stair 1 the four c_mt differ", FITTED, {"ground": "stair 1", "method": "PBC"}, costs(0.0364)),
    ("slope 1 every method's c_mt is lower", FITTED, {"ground": "slope 1", "method": "PBC"}, costs(0.0342)),
    ("tair 2 is not walked to the end (X) by PBC", FITTED, {"ground": "stair 2", "method": "PBC"}, costs(0.05)),
    ("lope 2 is walked by ECC", FITTED, {"ground": "slope 2", "method": "ECC"}, lost),
    ("slope 2 ECC's c_mt is higher", FITTED, {"ground": "slope 2", "method": "ECC"}, costs(0.0335)),
    # Table III and V-D, on either ground
    *(
        (words, group, {"part": "table 3", "ground": ground, "delay": zeta}, change)
        for group, ground in ((UNFITTED, "mixed"), (FOUND, "found"))
        for words, zeta, change in (
            ("comes to the end with every ζ", 0.1, lost),
            ("a smaller ζ takes", 0.3, having(ankle=331.0)),
            ("a smaller ζ takes", 1.0, having(ankle=1.0, hip=48.0)),
            ("torque without re-planning lies between", None, having(ankle=112.5)),
            ("torque without re-planning lies between", 0.5, having(ankle=98.3)),
            ("no ζ has a lower c_mt than 0.8", 0.9, costs(0.1437)),
            ("each ζ from 0.6 to 0.9", 0.5, costs(0.1486)),
            ("each ζ from 0.6 to 0.9", 0.6, costs(0.1554)),
            ("without re-planning is lower than with any", None, costs(0.1438)),
            # Fig. 6
            ("smoother", 0.4, tracing(travel=40.0)),
            ("smoother", 0.8, tracing(travel=40.0)),
            ("more accurate", 0.8, tracing(error=0.4)),
            ("z₂ of (9) is reduced to zero", 0.4, tracing(z2=0.016)),
        )
    ),
    # Fig. 4: our mixed ground's is of Fig. 5's walks, the found ground's is Table III's
    *(
        (words, group, where, change)
        for group, where in (
            (UNFITTED, {**PAPER_S_GAIN, "update": "yes", "start_estimate": -3.0}),
            (FOUND, {"part": "table 3", "ground": "found", "delay": 0.8}),
        )
        for words, change in (
            ("before the ground first changes", tracing(settled=0.12)),
            ("stays within ε", tracing(later=0.12)),
            ("nearer to a straight line", tracing(bent=0.09)),
            ("both legs stay within", tracing(z1=0.58)),
        )
    ),
    # Fig. 5
    ("for a shorter time", UNFITTED, {**PAPER_S_GAIN, "update": "no", "start_estimate": 3.0}, tracing(off_time=1.0)),
    ("by the end of every step", UNFITTED, {**PAPER_S_GAIN, "update": "no", "start_estimate": 3.0}, having(ended=0.12)),
    ("the greatest error of the estimate after", UNFITTED, {**PAPER_S_GAIN, "update": "yes"}, having(begun=2.0)),
    ("makes no wrong estimate right", UNFITTED,
     {"part": "figure 5", "adaptation_gain": 0.03, "update": "yes", "start_estimate": -3.0}, having(jump=0.12)),
]  # fmt: skip
CONTRADICTIONS += [(words, BLIND, where, change) for words, group, where, change in CONTRADICTIONS if group == FITTED]


@pytest.mark.parametrize(("words", "group", "where", "change"), CONTRADICTIONS)
def test_contradictions(words: str, group: str, where: dict[str, object], change: Change) -> None:
    """Each claim holds for the paper's numbers and fails for numbers that contradict it."""
    assert asked(paper_s(), words, group).holds is True
    answer = asked(changed(where, change), words, group)
    assert answer.holds is False
    assert answer.verdict.startswith("**does not hold**")


def test_a_claim_judged_on_survivors_says_so() -> None:
    rows = changed({**MIXED, "delay": 0.1}, lost)
    for words in ("a smaller ζ takes", "no ζ has a lower c_mt", "each ζ from 0.6", "lower than with any"):
        answer = asked(rows, words, UNFITTED)
        assert answer.holds is True
        assert answer.verdict.startswith("holds for the 9 of 10 ζ that came to their end: ")
    assert "9 of 10" not in asked(rows, "comes to the end", UNFITTED).verdict
    assert asked(paper_s(), "a smaller ζ takes", UNFITTED).of == ""


def test_what_was_not_walked_is_not_asked() -> None:
    """In MuJoCo there are no rows, and of walks that ended early no numbers."""
    there = [check for check in checks(Results(paper_s())) if check.engine == "mujoco"]
    assert {check.holds for check in there} == {None}
    assert {check.verdict for check in there} == {"–"}
    for zeta, words in ((0.8, "no ζ has a lower"), (0.7, "each ζ from 0.6"), (0.4, "torque without re-planning"),
                        (0.4, "smoother"), (None, "lower than with any")):  # fmt: skip
        assert asked(changed({**MIXED, "delay": zeta}, lost), words, UNFITTED).holds is None
    none_of_5 = [row for row in paper_s() if row.part != "figure 5" or row.start_estimate > 0]
    for words in ("for a shorter time", "makes no wrong estimate right", "stays within ε"):
        assert asked(none_of_5, words, UNFITTED).holds is None


def test_each_group_is_asked_of_its_own_walks() -> None:
    """Never of others: an engine in which those were not walked is not asked."""
    others = [row for row in paper_s() if row.part != BLIND]
    for words in ("stair 1 the adaptive", "Slope 2 is not walked to the end (X) by PBC"):
        assert asked(others, words, FITTED).holds is True
        assert asked(others, words, BLIND).holds is None
    assert asked(others, "the adaptive controller's c_mt is 0.0350", UNFITTED).holds is True
