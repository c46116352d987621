"""What Table II and section V-A say, asked of our walks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from mjbiped.reproduction.published import DIGITS, IMITATED_SLOPE, TABLE_2, meets
from mjbiped.reproduction.report.answers import Answer, printed
from mjbiped.reproduction.report.markdown import cost, number
from mjbiped.reproduction.report.table_2 import Walks, walks_asked
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice

_UNIT = 10.0**-DIGITS
_PASSIVE = math.sin(IMITATED_SLOPE)


def unfitted(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[Answer]:
    """Of the adaptive controller on level ground, where neither reading nor zeta makes a difference."""
    walks = walks_asked(rows, best, engine, "level", "blind")
    value = _cost(walks["adaptive"], best)
    paper = _paper("adaptive", "level")
    yield _number(walks, best, "adaptive", "level")
    off = abs(printed(paper) - printed(_PASSIVE))
    yield Answer(
        f"On level ground the adaptive controller's c_mt is within {off:.{DIGITS}f} of sin 2° = "
        f"{_PASSIVE:.{DIGITS}f}, as the printed {paper:.{DIGITS}f} is",
        "V-A",
        None if math.isnan(value) else abs(printed(value) - printed(_PASSIVE)) < off + 0.5 * _UNIT,
        f"{number(value, '.5f')}",
    )


def of_all_methods(rows: Sequence[Row], best: Choice, engine: str, part: str) -> Iterator[Answer]:
    """Of all methods; reading and zeta were fitted to the table's numbers.

    Args:
        rows: Of the reproduction.
        best: The reading.
        engine: "hybrid" or "mujoco".
        part: The other methods' walks: "blind" or "fitted", see `mjbiped.reproduction.plan.compared`.
    """
    level = walks_asked(rows, best, engine, "level", part)
    for method in TABLE_2:
        if method != "adaptive":
            yield _number(level, best, method, "level")
    base = {method: _cost(walk, best) for method, walk in level.items()}
    yield from _closeness(base)
    for ground, dearer in (("stair 1", True), ("slope 1", False)):
        here = {method: _cost(walk, best) for method, walk in walks_asked(rows, best, engine, ground, part).items()}
        yield _against_level(here, base, ground, dearer)
        if ground == "stair 1":
            yield _cheapest(here)
        yield _similar(here, ground)
    for ground in ("stair 2", "slope 2"):
        walks = walks_asked(rows, best, engine, ground, part)
        for method in TABLE_2:
            yield _comes_through(walks[method], best, method, ground)
        if ground == "slope 2":
            yield _dearer({method: _cost(walk, best) for method, walk in walks.items()}, "ECC", ground)


def _name(method: str) -> str:
    return "the adaptive controller" if method == "adaptive" else method


def _cost(walk: Row | None, best: Choice) -> float:
    return math.nan if walk is None else walk.cost[best.kind, best.length]


def _paper(method: str, ground: str) -> float:
    value = TABLE_2[method][ground]
    return math.nan if value is None else value


def _told(costs: Mapping[str, float]) -> str:
    return ", ".join(f"{method} {number(value)}" for method, value in costs.items())


def _all_there(costs: Mapping[str, float]) -> bool:
    return not any(math.isnan(value) for value in costs.values())


def _pair(costs: Mapping[str, float], method: str) -> Mapping[str, float]:
    return {name: costs[name] for name in ("adaptive", method)}


def _asked(claim: str, source: str, costs: Mapping[str, float], holds: bool, found: str = "") -> Answer:
    """The answer to a claim about some c_mt, found or the costs beside it; none where one of them does not exist."""
    if not _all_there(costs):
        return Answer(claim, source, None, _told(costs))
    return Answer(claim, source, holds, found or _told(costs))


def _number(walks: Walks, best: Choice, method: str, ground: str) -> Answer:
    """A number of the table, to half a unit of its last digit."""
    value, paper = _cost(walks[method], best), _paper(method, ground)
    holds = None if math.isnan(value) else meets(value, paper)
    return Answer(
        f"On {ground} ground {_name(method)}'s c_mt is {paper:.{DIGITS}f}", "Table II", holds, number(value, ".5f")
    )


def _closeness(costs: Mapping[str, float]) -> Iterator[Answer]:
    """V-A: "closer to the reference value on the level ground, the same as KETC"."""
    off = {method: abs(printed(value) - printed(_PASSIVE)) for method, value in costs.items()}
    for method in ("PBC", "ECC"):
        claim = f"On level ground the adaptive controller's c_mt is closer than {method}'s to sin 2° = {_PASSIVE:.4f}"
        yield _asked(claim, "V-A", _pair(costs, method), off["adaptive"] < off[method] - 0.5 * _UNIT)
    claim = "On level ground the adaptive controller's c_mt is the same as KETC's"
    yield _asked(claim, "V-A", _pair(costs, "KETC"), printed(costs["adaptive"]) == printed(costs["KETC"]))


def _against_level(here: Mapping[str, float], level: Mapping[str, float], ground: str, dearer: bool) -> Answer:
    """Whether all methods pay more, or less, than on level ground."""
    claim = f"On {ground} every method's c_mt is {'higher' if dearer else 'lower'} than its own on level ground"
    if not (_all_there(here) and _all_there(level)):
        return Answer(claim, "Table II", None, _told(here))
    sign = 1.0 if dearer else -1.0
    holds = all(sign * (printed(here[method]) - printed(level[method])) > 0.5 * _UNIT for method in here)
    found = ", ".join(f"{method} {number(value)} against {number(level[method])}" for method, value in here.items())
    return Answer(claim, "Table II", holds, found)


def _cheapest(costs: Mapping[str, float]) -> Answer:
    claim = "On stair 1 the adaptive controller's c_mt is the lowest of the four"
    others = [printed(value) for method, value in costs.items() if method != "adaptive"]
    return _asked(claim, "Table II", costs, printed(costs["adaptive"]) < min(others))


def _similar(costs: Mapping[str, float], ground: str) -> Answer:
    """V-A: "similar energy efficiency on uneven terrains", as similar as the table's own numbers."""
    papers = [_paper(method, ground) for method in costs]
    allowed = round(max(papers) - min(papers), DIGITS)
    claim = f"On {ground} the four c_mt differ by no more than the table's, {allowed:.{DIGITS}f}"
    spread = max(map(printed, costs.values())) - min(map(printed, costs.values()))
    found = f"{number(spread)}; {_told(costs)}"
    return _asked(claim, "V-A, Table II", costs, spread < allowed + 0.5 * _UNIT, found)


def _comes_through(walk: Row | None, best: Choice, method: str, ground: str) -> Answer:
    """Whether a method walks as many steps as the reading's c_mt is of, as it does or does not in the table."""
    through = TABLE_2[method][ground] is not None
    said = "is walked" if through else "is not walked to the end (X)"
    claim = f"{ground[0].upper()}{ground[1:]} {said} by {_name(method)}"
    if walk is None:
        return Answer(claim, "Table II", None)
    walked = math.isfinite(walk.cost[best.kind, best.length])
    found = f"{walk.outcome} after {walk.steps} steps" if not walked else f"c_mt {cost(walk, best.kind, best.length)}"
    return Answer(claim, "Table II", walked == through, found)


def _dearer(costs: Mapping[str, float], method: str, ground: str) -> Answer:
    """Whether a method pays more than the adaptive controller."""
    claim = f"On {ground} {method}'s c_mt is higher than the adaptive controller's"
    return _asked(claim, "Table II", _pair(costs, method), printed(costs[method]) > printed(costs["adaptive"]))
