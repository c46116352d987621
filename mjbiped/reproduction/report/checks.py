"""Claims of the paper about its tables and figures, tested on our walks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from mjbiped.reproduction.grounds import DIGITS, ENERGY_BASED, GROUNDS, IMITATED_SLOPE, TABLE_2, meets
from mjbiped.reproduction.report import checks_figures
from mjbiped.reproduction.report.markdown import ENGINES, NONE, Answer, cost, number, printed
from mjbiped.reproduction.report.table_2 import walks_asked
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice
from mjbiped.utils.markdown import markdown_table

UNFITTED, BLIND, FITTED, FOUND = "unfitted", "blind", "fitted", "found"
"""What is fitted to the paper's numbers in the walks that are tested: nothing; the reading of the grounds; the other
methods' settings as well; the ground."""


_UNIT = 10.0**-DIGITS
_PASSIVE = math.sin(IMITATED_SLOPE)

Costs = Mapping[str, float]
"""c_mt by method; NaN where there is none."""


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
    grounds = ((UNFITTED, "mixed", "On our mixed ground"), (FOUND, "found", "On the ground that was found"))
    asked = [
        (UNFITTED, _level(rows, best, engine)),
        *((group, _of_all_methods(rows, best, engine, group)) for group in (BLIND, FITTED)),
        *((group, checks_figures.answers(rows, ground, title, engine)) for group, ground, title in grounds),
    ]
    for group, answers in asked:
        yield from ((group, answer) for answer in answers)


def sections(asked: Sequence[Check]) -> dict[str, str]:
    """Fill the template's places about the claims, by name."""
    parts = {"claims_alike": _alike(asked)}
    for group in (UNFITTED, BLIND, FITTED, FOUND):
        mine = _by_claim(check for check in asked if check.group == group)
        parts |= {f"missed_{group}": _missed(mine), f"checks_{group}": _table(mine)}
    without = _counting(asked)
    denied = {key: said for key, said in without.items() if any(each.holds is False for each in said.values())}
    lines = [
        [claim, source, " and ".join(ENGINES[engine] for engine, each in said.items() if each.holds is False)]
        for (_, claim, source), said in denied.items()
    ]
    shown = markdown_table(("claim", "in the paper", "does not hold in"), lines)
    return {**parts, "missed_without_the_table": _missed(without), "denied": shown}


Asked = Mapping[tuple[str, str, str], Mapping[str, Answer]]
"""Each engine's answer by group, claim and source. A claim counts once, in however many engines it is tested."""


def _by_claim(asked: Iterable[Check]) -> Asked:
    found: dict[tuple[str, str, str], dict[str, Answer]] = {}
    for check in asked:
        key = check.group, check.answer.claim, check.answer.source
        found.setdefault(key, {})[check.engine] = check.answer
    return found


def _counting(asked: Iterable[Check]) -> Asked:
    """The claims that count as evidence: nothing but the reading of the grounds was fitted to their numbers."""
    return _by_claim(check for check in asked if check.group in (UNFITTED, BLIND))


def what_counts(asked: Iterable[Check]) -> str:
    """Say which rows count, and how many of their claims do not hold."""
    return (
        f'What counts are the rows "{UNFITTED}" and "{BLIND}", whose settings were not chosen by the paper\'s numbers: '
        f"{_missed(_counting(asked))} claims do not hold in every engine that walked them. "
        f'In the rows "{FITTED}" the gains, in "{FOUND}" the ground were searched for so that they agree.'
    )


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
    return markdown_table(("claim", "in the paper", "hybrid", "MuJoCo"), lines)


def _level(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[Answer]:
    """Test claims about the adaptive controller on level ground, where reading and zeta make no difference."""
    value = _costs(walks_asked(rows, best, engine, "level", "blind"), best)["adaptive"]
    paper = _paper("adaptive", "level")
    yield _number(value, "adaptive", "level")
    off = abs(printed(paper) - printed(_PASSIVE))
    yield Answer(
        f"On level ground the adaptive controller's c_mt is within {off:.{DIGITS}f} of sin 2° = "
        f"{_PASSIVE:.{DIGITS}f}, as the printed {paper:.{DIGITS}f} is",
        "V-A",
        None if math.isnan(value) else abs(printed(value) - printed(_PASSIVE)) < off + 0.5 * _UNIT,
        f"{number(value, '.5f')}",
    )


def _of_all_methods(rows: Sequence[Row], best: Choice, engine: str, part: str) -> Iterator[Answer]:
    """Test claims about all methods; reading and zeta were fitted to the table's numbers.

    Args:
        rows: Rows of the reproduction.
        best: The reading.
        engine: "hybrid" or "mujoco".
        part: The other methods' walks: "blind" or "fitted", see `mjbiped.reproduction.plan.compared`.
    """
    walks = {ground: walks_asked(rows, best, engine, ground, part) for ground in GROUNDS}
    costs = {ground: _costs(mine, best) for ground, mine in walks.items()}
    level, stairs = costs["level"], costs["stair 1"]
    for method in ENERGY_BASED:
        yield _number(level[method], method, "level")
    off = {method: abs(printed(value) - printed(_PASSIVE)) for method, value in level.items()}
    for method in ("PBC", "ECC"):
        claim = f"On level ground the adaptive controller's c_mt is closer than {method}'s to sin 2° = {_PASSIVE:.4f}"
        yield _asked(claim, "V-A", _pair(level, method), off["adaptive"] < off[method] - 0.5 * _UNIT)
    claim = "On level ground the adaptive controller's c_mt is the same as KETC's"
    yield _asked(claim, "V-A", _pair(level, "KETC"), printed(level["adaptive"]) == printed(level["KETC"]))
    yield _against_level(stairs, level, "stair 1", "higher", 1.0)
    claim = "On stair 1 the adaptive controller's c_mt is the lowest of the four"
    yield _asked(
        claim, "Table II", stairs, printed(stairs["adaptive"]) < min(printed(stairs[each]) for each in ENERGY_BASED)
    )
    yield _similar(stairs, "stair 1")
    yield _against_level(costs["slope 1"], level, "slope 1", "lower", -1.0)
    yield _similar(costs["slope 1"], "slope 1")
    for ground in ("stair 2", "slope 2"):
        for method in TABLE_2:
            yield _comes_through(walks[ground][method], best, method, ground)
    both = _pair(costs["slope 2"], "ECC")
    claim = "On slope 2 ECC's c_mt is higher than the adaptive controller's"
    yield _asked(claim, "Table II", both, printed(both["ECC"]) > printed(both["adaptive"]))


def _name(method: str) -> str:
    return "the adaptive controller" if method == "adaptive" else method


def _costs(walks: Mapping[str, Row | None], best: Choice) -> Costs:
    return {method: math.nan if walk is None else walk.cost[best.kind, best.length] for method, walk in walks.items()}


def _paper(method: str, ground: str) -> float:
    value = TABLE_2[method][ground]
    return math.nan if value is None else value


def _told(costs: Costs) -> str:
    return ", ".join(f"{method} {number(value)}" for method, value in costs.items())


def _pair(costs: Costs, method: str) -> Costs:
    return {name: costs[name] for name in ("adaptive", method)}


def _asked(claim: str, source: str, costs: Costs, holds: bool, found: str = "") -> Answer:
    """Answer a claim about some c_mt; there is no answer where one of them does not exist."""
    known = not any(map(math.isnan, costs.values()))
    return Answer(claim, source, holds if known else None, (known and found) or _told(costs))


def _number(value: float, method: str, ground: str) -> Answer:
    """Compare a number of the table, to half a unit of its last digit."""
    paper = _paper(method, ground)
    claim = f"On {ground} ground {_name(method)}'s c_mt is {paper:.{DIGITS}f}"
    return Answer(claim, "Table II", None if math.isnan(value) else meets(value, paper), number(value, ".5f"))


def _against_level(here: Costs, level: Costs, ground: str, word: str, sign: float) -> Answer:
    """Compare each method with itself on level ground."""
    claim = f"On {ground} every method's c_mt is {word} than its own on level ground"
    if any(map(math.isnan, level.values())):
        return Answer(claim, "Table II", None, _told(here))
    holds = all(sign * (printed(here[method]) - printed(level[method])) > 0.5 * _UNIT for method in here)
    found = ", ".join(f"{method} {number(value)} against {number(level[method])}" for method, value in here.items())
    return _asked(claim, "Table II", here, holds, found)


def _similar(costs: Costs, ground: str) -> Answer:
    """Test V-A's "similar energy efficiency on uneven terrains": as similar as the table's own numbers."""
    papers = [_paper(method, ground) for method in costs]
    allowed = round(max(papers) - min(papers), DIGITS)
    claim = f"On {ground} the four c_mt differ by no more than the table's, {allowed:.{DIGITS}f}"
    spread = max(map(printed, costs.values())) - min(map(printed, costs.values()))
    found = f"{number(spread)}; {_told(costs)}"
    return _asked(claim, "V-A, Table II", costs, spread < allowed + 0.5 * _UNIT, found)


def _comes_through(walk: Row | None, best: Choice, method: str, ground: str) -> Answer:
    """Test whether a method makes the steps over which the reading takes c_mt, or fails to, as in the table."""
    through = TABLE_2[method][ground] is not None
    said = "is walked" if through else "is not walked to the end (X)"
    claim = f"{ground[0].upper()}{ground[1:]} {said} by {_name(method)}"
    if walk is None:
        return Answer(claim, "Table II", None)
    walked = math.isfinite(walk.cost[best.kind, best.length])
    found = f"c_mt {cost(walk, best.kind, best.length)}" if walked else f"{walk.outcome} after {walk.steps} steps"
    return Answer(claim, "Table II", walked == through, found)
