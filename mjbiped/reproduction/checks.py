"""What the paper's numbers claim, asked of ours: whether it holds, and with which numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from mjbiped.reproduction.markdown import NONE, delay, number
from mjbiped.reproduction.methods import METHODS
from mjbiped.reproduction.published import IMITATED_SLOPE, TABLE_2
from mjbiped.reproduction.report_table_2 import walk_of
from mjbiped.reproduction.report_table_3 import ENGINES, walks_of
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.table_2 import Choice, agreements

_LEVEL = ("level", "", 0.0)
_LABELS = {"hybrid": "hybrid", "mujoco": "MuJoCo"}


@dataclass(frozen=True)
class Check:
    """A claim and what became of it.

    Attributes:
        claim: In words.
        engine: Whose walks were asked.
        found: Our numbers.
        holds: Whether they fulfil it; None where the walks were not made.
    """

    claim: str
    engine: str
    found: str
    holds: bool | None

    @property
    def verdict(self) -> str:
        """In a word."""
        return NONE if self.holds is None else "holds" if self.holds else "**does not hold**"


def checks(rows: Sequence[Row], best: Choice) -> list[Check]:
    """All checks, engine by engine."""
    source = agreements(rows, best)[0].source
    return [check for engine in ENGINES for check in _of(rows, best, source, engine)]


def _of(rows: Sequence[Row], best: Choice, source: str, engine: str) -> Iterator[Check]:
    def check(claim: str, found: str, holds: bool | None) -> Check:
        return Check(claim, _LABELS[engine], found, holds)

    target = math.sin(IMITATED_SLOPE)
    for method, tolerance in (("adaptive", 0.0002), ("PBC", 0.0005), ("KETC", 0.0005)):
        walk = walk_of(rows, engine, _LEVEL, method, best.delay, source)
        value = math.nan if walk is None else walk.cost[best.kind, best.length]
        claim = f"level ground, {method}: c_mt within {tolerance:g} of sin 2° = {target:.4f}"
        yield check(claim, number(value, ".5f"), None if value != value else abs(value - target) <= tolerance)
    yield from (check(*parts) for parts in _stairs(rows, best, source, engine))
    for ground, title in (("mixed", "our mixed ground"), ("found", "the ground that was found")):
        walks = walks_of(rows, ground, engine)
        for claim, found, holds in _table_3(walks):
            yield check(f"Table III on {title}: {claim}", found, holds)


def _stairs(rows: Sequence[Row], best: Choice, source: str, engine: str) -> Iterator[tuple[str, str, bool | None]]:
    """Descending 0.06 m: the adaptive controller walks, the energy-based ones do not."""
    place = ("stair 2", "descending", best.stairs[1])
    walks = {
        method: walk_of(rows, engine, place, method, best.delay, source) for method in METHODS if method in TABLE_2
    }
    for method, walk in walks.items():
        if method == "adaptive":
            holds = None if walk is None or (walk.steps < 60 and walk.finished) else walk.steps >= 60
            claim = "stairs of 0.06 m descending: the adaptive controller walks 60 steps"
        else:
            holds = None if walk is None else not walk.finished
            claim = f"stairs of 0.06 m descending: {method} does not come through (X)"
        yield claim, NONE if walk is None else f"{walk.outcome}, {walk.steps} steps", holds


def _table_3(walks: dict[float | None, Row]) -> Iterator[tuple[str, str, bool | None]]:
    """The table's shape, of the walks that came to their end."""
    if not walks:
        yield "shape", NONE, None
        return
    lost = [f"ζ = {delay(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    yield "all walks come to their end", "; ".join(lost) or "all", not lost
    torque = {zeta: walk.torque for zeta, walk in walks.items() if walk.finished}
    cost = {zeta: walk.cost["absolute", None] for zeta, walk in walks.items() if walk.finished}
    zetas = [zeta for zeta in torque if zeta is not None]
    if None not in torque or len(zetas) < 2:
        return
    first, last = zetas[0], zetas[-1]
    falls = all(torque[a] > torque[b] for a, b in pairwise(zetas))
    yield "torque falls with every ζ", f"{torque[first]:.5g} to {torque[last]:.5g} N m, from ζ = {first:g} on", falls
    whole = (first, last) == (0.1, 1.0)
    ratio = torque[first] / torque[last]
    claim = "torque at ζ = 0.1 at least 20 times that at ζ = 1"
    yield claim, number(ratio, ".1f") if whole else NONE, ratio >= 20.0 if whole else None
    least = min(zetas, key=lambda zeta: cost[zeta])
    yield "c_mt least between ζ = 0.7 and 0.9", f"least at ζ = {least:g}", 0.7 <= least <= 0.9
    found = f"{torque[None]:.4g} N m, {torque[0.5]:.4g} at ζ = 0.5"
    yield "without re-planning more torque than at ζ = 0.5", found, torque[None] > torque[0.5]
    found = f"{cost[None]:.4f}, least with it {cost[least]:.4f}"
    yield "without re-planning less c_mt than with any ζ", found, cost[None] < cost[least]
