"""All claims of the paper about its tables and figures, answered by engine and group, and counted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from mjbiped.reproduction.report import claims
from mjbiped.reproduction.report.claims import Answer
from mjbiped.reproduction.report.markdown import ENGINES, NONE, body
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

GROUPS = UNFITTED, BLIND, FITTED, FOUND = "unfitted", "blind", "fitted", "found"
"""What is fitted to the paper's numbers in the walks that are tested: nothing; the reading of the grounds; the other
methods' settings as well; the ground."""


def checks(rows: Sequence[Row], best: Choice) -> list[Answer]:
    """Answer all claims, engine by engine and group by group."""
    return [
        answer._replace(engine=engine, group=group)
        for engine in ENGINES
        for group, answers in (
            (UNFITTED, claims.of_adaptive(rows, best, engine)),
            (BLIND, claims.of_all_methods(rows, best, engine, "blind")),
            (FITTED, claims.of_all_methods(rows, best, engine, "fitted")),
            (UNFITTED, claims.of_figures(rows, "mixed", "On our mixed ground", engine)),
            (FOUND, claims.of_figures(rows, "found", "On the ground that was found", engine)),
        )
        for answer in answers
    ]


def sections(asked: Sequence[Answer]) -> dict[str, str]:
    """Fill the template's places about the claims, by name."""
    parts = {}
    for group in GROUPS:
        mine = _by_claim(asked, (group,))
        parts[f"missed_{group}"] = _missed(mine)
        parts[f"checks_{group}"] = body(
            [claim, source, *(said[engine].verdict if engine in said else NONE for engine in ENGINES)]
            for (_, claim, source), said in mine.items()
        )
    counting = _by_claim(asked, _COUNTING)
    denied = (
        [claim, source, " and ".join(ENGINES[engine] for engine, each in said.items() if each.holds is False)]
        for (_, claim, source), said in counting.items()
    )
    return {
        **parts,
        "claims_alike": _alike(_by_claim(asked, GROUPS)),
        "missed_without_the_table": _missed(counting),
        "denied": body(line for line in denied if line[2]),
    }


_COUNTING = (UNFITTED, BLIND)
"""The groups that count as evidence: nothing but the reading of the grounds was fitted to their numbers."""

Asked = Mapping[tuple[str, str, str], Mapping[str, Answer]]
"""Each engine's answer by group, claim and source. A claim counts once, in however many engines it is tested."""


def _by_claim(asked: Iterable[Answer], groups: Sequence[str]) -> Asked:
    found: dict[tuple[str, str, str], dict[str, Answer]] = {}
    for answer in asked:
        if answer.group in groups:
            found.setdefault((answer.group, answer.claim, answer.source), {})[answer.engine] = answer
    return found


def what_counts(asked: Iterable[Answer]) -> str:
    """Say which rows count, and how many of their claims do not hold."""
    return (
        f'What counts are the rows "{UNFITTED}" and "{BLIND}", whose settings were not chosen by the paper\'s numbers: '
        f"{_missed(_by_claim(asked, _COUNTING))} claims do not hold in every engine that walked them. "
        f'In the rows "{FITTED}" the gains, in "{FOUND}" the ground were searched for so that they agree.'
    )


def _missed(asked: Asked) -> str:
    """Count the claims that an engine denies, out of those that have an answer."""
    known = [{each.holds for each in said.values()} - {None} for said in asked.values()]
    return f"{sum(False in said for said in known)} of {sum(map(bool, known))}"


def _alike(asked: Asked) -> str:
    """Count the claims on which the engines agree, and list the others."""
    both = {claim: {each.holds for each in said.values()} for claim, said in asked.items() if len(said) == 2}
    both = {claim: holds for claim, holds in both.items() if None not in holds}
    apart = [f"\n* {claim}" for (_, claim, _), holds in both.items() if len(holds) == 2]
    return f"{len(both) - len(apart)} of {len(both)}" + (f"; they differ on\n{''.join(apart)}" if apart else ".")
