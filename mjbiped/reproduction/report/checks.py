"""Claims of the paper about its tables and figures, tested on our walks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from mjbiped.reproduction.report import checks_figures, checks_table_2
from mjbiped.reproduction.report.markdown import ENGINES, NONE, Answer, table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

UNFITTED, BLIND, FITTED, FOUND = "unfitted", "blind", "fitted", "found"
"""What is fitted to the paper's numbers in the walks that are tested: nothing; the reading of the grounds; the other
methods' settings as well; the ground."""


@dataclass(frozen=True)
class Check:
    """An answer, and the walks that gave it.

    Attributes:
        group: `UNFITTED`, `BLIND`, `FITTED` or `FOUND`.
        engine: "hybrid" or "mujoco".
        answer: The answer to a claim.
    """

    group: str
    engine: str
    answer: Answer


def checks(rows: Sequence[Row], best: Choice) -> list[Check]:
    """Answer all claims, engine by engine and group by group."""
    return [Check(group, engine, answer) for engine in ENGINES for group, answer in _answers(rows, best, engine)]


def _answers(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[tuple[str, Answer]]:
    yield from ((UNFITTED, answer) for answer in checks_table_2.unfitted(rows, best, engine))
    for group in (BLIND, FITTED):
        yield from ((group, answer) for answer in checks_table_2.of_all_methods(rows, best, engine, group))
    for group, ground, title in (
        (UNFITTED, "mixed", "On our mixed ground"),
        (FOUND, "found", "On the ground that was found"),
    ):
        yield from ((group, answer) for answer in checks_figures.table_3(rows, ground, title, engine))
        yield from ((group, answer) for answer in checks_figures.figure_4(rows, ground, title, engine))
        if ground == "mixed":
            yield from ((group, answer) for answer in checks_figures.figure_5(rows, title, engine))
        yield from ((group, answer) for answer in checks_figures.figure_6(rows, ground, title, engine))


def sections(asked: Sequence[Check]) -> dict[str, str]:
    """Fill the template's places about the claims, by name."""
    parts = {"claims_alike": _alike(asked), "zero": f"{100 * checks_figures.ZERO:g} %"}
    for group in (UNFITTED, BLIND, FITTED, FOUND):
        mine = _by_claim(check for check in asked if check.group == group)
        parts |= {f"missed_{group}": _missed(mine), f"checks_{group}": _table(mine)}
    without = _by_claim(check for check in asked if check.group in (UNFITTED, BLIND))
    denied = {key: said for key, said in without.items() if any(each.holds is False for each in said.values())}
    lines = [
        [claim, source, " and ".join(ENGINES[engine] for engine, each in said.items() if each.holds is False)]
        for (_, claim, source), said in denied.items()
    ]
    shown = table(("claim", "in the paper", "does not hold in"), lines, words=3)
    return {**parts, "missed_without_the_table": _missed(without), "denied": shown}


Asked = Mapping[tuple[str, str, str], Mapping[str, Answer]]
"""Each engine's answer by group, claim and source. A claim counts once, in however many engines it is tested."""


def _by_claim(asked: Iterable[Check]) -> Asked:
    found: dict[tuple[str, str, str], dict[str, Answer]] = {}
    for check in asked:
        key = check.group, check.answer.claim, check.answer.source
        found.setdefault(key, {})[check.engine] = check.answer
    return found


def _missed(asked: Asked) -> str:
    """Count the claims that an engine denies, out of those that have an answer."""
    known = [[each.holds for each in said.values() if each.holds is not None] for said in asked.values()]
    return f"{sum(not all(said) for said in known)} of {sum(bool(said) for said in known)}"


def _alike(asked: Iterable[Check]) -> str:
    """Count the claims on which the engines agree, and list the others."""
    both = {
        key: said
        for key, said in _by_claim(asked).items()
        if len(said) == len(ENGINES) and all(each.holds is not None for each in said.values())
    }
    apart = [key[1] for key, said in both.items() if len({each.holds for each in said.values()}) > 1]
    named = "".join(f"\n* {claim}" for claim in apart)
    return f"{len(both) - len(apart)} of {len(both)}" + (f"; they differ on\n{named}" if apart else ".")


def _table(asked: Asked) -> str:
    """Tabulate the claims with each engine's verdict."""
    lines = [
        [claim, source, *(said[engine].verdict if engine in said else NONE for engine in ENGINES)]
        for (_, claim, source), said in asked.items()
    ]
    return table(("claim", "in the paper", "hybrid", "MuJoCo"), lines, words=4)
