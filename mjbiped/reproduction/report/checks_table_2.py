"""Claims of section V-A about Table II, tested on the grounds of a reading."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

from mjbiped.reproduction.grounds import DIGITS, ENERGY_BASED, IMITATED_SLOPE, LEVEL, TABLE_2, meets
from mjbiped.reproduction.report.answers import Answer, Words, answer
from mjbiped.reproduction.report.markdown import best_cost, number, printed
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice, walk_on

_HALF = 0.5 * 10.0**-DIGITS
_PASSIVE = printed(math.sin(IMITATED_SLOPE))

Costs = Mapping[str, float]
"""c_mt by method; NaN where there is none."""


def of_adaptive(rows: Sequence[Row], best: Choice, engine: str) -> Iterator[Answer]:
    """Test claims about the adaptive controller on level ground, where reading and zeta make no difference."""
    value = best.cost(walk_on(rows, best, engine, LEVEL, "adaptive", ""))
    yield _number(value, "adaptive")
    off = abs((TABLE_2["adaptive"]["level"] or math.nan) - _PASSIVE)
    near = abs(printed(value) - _PASSIVE) < off + _HALF
    yield answer("level_passive", {"off": off}, near, number(value, ".5f"), [value])


def of_all_methods(rows: Sequence[Row], best: Choice, engine: str, settings: str) -> Iterator[Answer]:
    """Test claims about all methods; reading and zeta were fitted to the table's numbers.

    Args:
        rows: Rows of the reproduction.
        best: The reading.
        engine: "hybrid" or "mujoco".
        settings: The other methods' settings, "blind" or "fitted".
    """
    walks = {
        place[0]: {method: walk_on(rows, best, engine, place, method, settings) for method in TABLE_2}
        for place in best.places
    }
    costs = {ground: {method: best.cost(walk) for method, walk in mine.items()} for ground, mine in walks.items()}
    shown = {ground: {method: printed(cost) for method, cost in mine.items()} for ground, mine in costs.items()}
    level, stairs, slopes = shown["level"], shown["stair 1"], shown["slope 2"]
    for method in ENERGY_BASED:
        yield _number(costs["level"][method], method)
    for method in ("PBC", "ECC"):
        nearer = abs(level["adaptive"] - _PASSIVE) < abs(level[method] - _PASSIVE) - _HALF
        yield _asked("closer_to_passive", _pair(costs["level"], method), nearer, {"method": method})
    yield _asked("same_as_ketc", _pair(costs["level"], "KETC"), level["adaptive"] == level["KETC"])
    yield _against_level("higher_than_level", costs["stair 1"], costs["level"], 1.0)
    yield _asked("lowest", costs["stair 1"], stairs["adaptive"] < min(stairs[method] for method in ENERGY_BASED))
    yield _similar(costs["stair 1"], "stair 1")
    yield _against_level("lower_than_level", costs["slope 1"], costs["level"], -1.0)
    yield _similar(costs["slope 1"], "slope 1")
    for ground in ("stair 2", "slope 2"):
        for method, walk in walks[ground].items():
            yield _comes_through(walk, best, method, ground)
    yield _asked("higher_than_adaptive", _pair(costs["slope 2"], "ECC"), slopes["ECC"] > slopes["adaptive"])


def _name(method: str) -> str:
    return "the adaptive controller" if method == "adaptive" else method


def _told(costs: Costs) -> str:
    return ", ".join(f"{method} {number(value)}" for method, value in costs.items())


def _pair(costs: Costs, method: str) -> Costs:
    return {name: costs[name] for name in ("adaptive", method)}


def _asked(claim: str, costs: Costs, holds: bool, words: Words = MappingProxyType({})) -> Answer:
    """Answer a claim about some c_mt."""
    return answer(claim, words, holds, _told(costs), costs.values())


def _number(value: float, method: str) -> Answer:
    """Compare a number of level ground, to half a unit of its last digit."""
    paper = TABLE_2[method]["level"] or math.nan
    words: Words = {"method": _name(method), "paper": paper}
    return answer("level_number", words, meets(value, paper), number(value, ".5f"), [value])


def _against_level(claim: str, here: Costs, level: Costs, sign: float) -> Answer:
    """Compare each method with itself on level ground."""
    holds = all(sign * (printed(here[method]) - printed(level[method])) > _HALF for method in here)
    found = ", ".join(f"{method} {number(value)} against {number(level[method])}" for method, value in here.items())
    return answer(claim, {}, holds, found, [*here.values(), *level.values()])


def _similar(costs: Costs, ground: str) -> Answer:
    """Test V-A's "similar energy efficiency on uneven terrains": as similar as the table's own numbers."""
    papers, ours = [TABLE_2[method][ground] or math.nan for method in costs], [*map(printed, costs.values())]
    allowed, spread = round(max(papers) - min(papers), DIGITS), max(ours) - min(ours)
    words: Words = {"ground": ground, "allowed": allowed}
    return answer("similar", words, spread < allowed + _HALF, f"{number(spread)}; {_told(costs)}", costs.values())


def _comes_through(walk: Row, best: Choice, method: str, ground: str) -> Answer:
    """Test whether a method makes the steps over which the reading takes c_mt, or fails to, as in the table."""
    crossed, walked = TABLE_2[method][ground] is None, math.isfinite(best.cost(walk))
    found = f"c_mt {best_cost(walk, best)}" if walked else f"{walk.outcome} after {walk.steps} steps"
    words: Words = {"ground": ground.capitalize(), "method": _name(method)}
    return answer("not_walked" if crossed else "walked", words, walked != crossed if walk.outcome else None, found)
