"""What the paper says of its tables and figures, asked of our walks: whether it holds, and with which numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mjbiped.reproduction.report import checks_figures, checks_table_2, checks_table_3
from mjbiped.reproduction.report.answers import Answer
from mjbiped.reproduction.report.markdown import ENGINES, NONE, table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

UNFITTED, TABLE_2, FOUND = "unfitted", "table 2", "found"
"""What the walks that are asked owe to the paper's numbers: nothing; their settings; the ground."""


@dataclass(frozen=True)
class Check:
    """An answer, and whose.

    Attributes:
        group: `UNFITTED`, `TABLE_2` or `FOUND`.
        engine: "hybrid" or "mujoco".
        answer: To a claim.
    """

    group: str
    engine: str
    answer: Answer


def checks(rows: Sequence[Row], best: Choice) -> list[Check]:
    """All answers, engine by engine and group by group."""
    return [Check(group, engine, answer) for engine in ENGINES for group, answer in _answers(rows, best, engine)]


def _answers(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[tuple[str, Answer]]:
    yield from ((UNFITTED, answer) for answer in checks_table_2.unfitted(rows, best, engine))
    yield from ((TABLE_2, answer) for answer in checks_table_2.fitted(rows, best, engine))
    for group, ground, title in (
        (UNFITTED, "mixed", "On our mixed ground"),
        (FOUND, "found", "On the ground that was found"),
    ):
        yield from ((group, answer) for answer in checks_table_3.answers(rows, ground, title, engine))
        yield from ((group, answer) for answer in checks_figures.figure_4(rows, ground, title, engine))
        if ground == "mixed":
            yield from ((group, answer) for answer in checks_figures.figure_5(rows, title, engine))
        yield from ((group, answer) for answer in checks_figures.figure_6(rows, ground, title, engine))


def sections(asked: Sequence[Check]) -> dict[str, str]:
    """What the template wants to know of the checks, by name."""
    missed, known = _count(asked)
    parts = {"missed": str(missed), "asked": str(known)}
    for group in (UNFITTED, TABLE_2, FOUND):
        mine = [check for check in asked if check.group == group]
        missed, known = _count(mine)
        name = group.replace(" ", "_")
        parts |= {f"checks_{name}": _table(mine), f"missed_{name}": f"{missed} of {known}"}
    return parts


def _count(asked: Sequence[Check]) -> tuple[int, int]:
    """How many claims do not hold, and of how many it is known."""
    return sum(check.answer.holds is False for check in asked), sum(check.answer.holds is not None for check in asked)


def _table(asked: Sequence[Check]) -> str:
    """A claim a line, with each engine's verdict on it."""
    verdicts: dict[tuple[str, str], dict[str, str]] = {}
    for check in asked:
        by_engine = verdicts.setdefault((check.answer.claim, check.answer.source), {})
        by_engine[check.engine] = check.answer.verdict
    lines = [[*claim, *(said.get(engine, NONE) for engine in ENGINES)] for claim, said in verdicts.items()]
    return table(("claim", "in the paper", "hybrid", "MuJoCo"), lines, words=4)
