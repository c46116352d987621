"""Claims of Table II and section V-A, tested on our walks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from mjbiped.reproduction.grounds import DIGITS, GROUNDS, IMITATED_SLOPE, TABLE_2, meets
from mjbiped.reproduction.report.markdown import Answer, cost, number, printed
from mjbiped.reproduction.report.table_2 import walks_asked
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

_UNIT = 10.0**-DIGITS
_PASSIVE = math.sin(IMITATED_SLOPE)
_OTHERS = tuple(method for method in TABLE_2 if method != "adaptive")

Costs = Mapping[str, float]
"""c_mt by method; NaN where there is none."""


def unfitted(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[Answer]:
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


def of_all_methods(rows: Sequence[Row], best: Choice, engine: str, part: str) -> Iterator[Answer]:
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
    for method in _OTHERS:
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
        claim, "Table II", stairs, printed(stairs["adaptive"]) < min(printed(stairs[each]) for each in _OTHERS)
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
