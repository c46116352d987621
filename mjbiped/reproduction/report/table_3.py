"""The part of the report on Table III, and Fig. 5 in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from mjbiped.reproduction.grounds import TABLE_3, found_segments
from mjbiped.reproduction.report.markdown import ENGINES, NONE, body, cost, delay, ending, excess, number, share
from mjbiped.reproduction.rows import NO_WALK, Row, select


def sections(rows: Sequence[Row]) -> dict[str, str]:
    """Fill the template's places about Table III and Fig. 5, by name."""
    return {
        "table_3_mixed": _table(rows, "mixed"),
        "table_3_found": _table(rows, "found"),
        "distance_mixed": _distance(rows, "mixed"),
        "distance_found": _distance(rows, "found"),
        "found_segments": _segments(),
        "figure_5": _figure_5(rows),
        "pulls": _pulls(rows),
    }


def walks_of(rows: Iterable[Row], ground: str, engine: str) -> dict[float | None, Row]:
    """Find the walks of Table III on one of the grounds, by zeta; None: no re-planning."""
    return {row.delay: row for row in select(rows, part="table 3", ground=ground, engine=engine)}


def distance(walks: dict[float | None, Row]) -> float:
    """Root mean square of ln(ours / paper's) of the torques and c_mt of all walks that came to their end."""
    ended = {zeta: walk for zeta, walk in walks.items() if walk.finished}
    if not ended:
        return math.nan
    ours = [(walk.torque, walk.absolute_end) for walk in ended.values()]
    return math.sqrt(float(np.mean(np.log(np.divide(ours, [TABLE_3[zeta] for zeta in ended])) ** 2)))


def _distance(rows: Sequence[Row], ground: str) -> str:
    values = []
    for engine in ENGINES:
        walks = walks_of(rows, ground, engine)
        ended = sum(walk.finished for walk in walks.values())
        part = "" if ended == len(walks) else f", the {ended} of {len(walks)} walks that came to their end"
        values.append(f"{share(distance(walks), '.1f')} ({ENGINES[engine]}{part})")
    return ", ".join(values)


def _table(rows: Sequence[Row], ground: str) -> str:
    """Tabulate Table III beside ours."""
    begun = {row.delay: number(row.torque, ".5g") for row in select(rows, part="start")}
    by_engine = [walks_of(rows, ground, engine) for engine in ENGINES]
    lines = []
    for zeta, (torque, paper) in TABLE_3.items():
        here, there = walks = [found.get(zeta, NO_WALK) for found in by_engine]
        lines.append(
            [
                delay(zeta),
                number(torque, ".5g"),
                *([begun.get(zeta, NONE)] if ground == "mixed" else []),  # both are on level ground at first
                *(ending(walk, number(walk.torque, ".5g")) for walk in walks),
                excess(here.torque, torque),
                number(paper),
                *map(cost, walks),
                excess(here.absolute_end, paper),
                number(here.least_force, ".2f"),
                number(there.least_force, ".2f"),
                "pulls" if here.pulls else number(here.friction, ".3g"),
            ]
        )
    return body(lines)


def _pulls(rows: Sequence[Row]) -> str:
    """List the walks of the hybrid engine that need a ground that pulls, in words."""
    parts = []
    for ground, title in (("mixed", "our mixed ground"), ("found", "the ground that was found")):
        walks = walks_of(rows, ground, "hybrid")
        named = ["no re-planning" if zeta is None else f"ζ = {zeta:g}" for zeta, walk in walks.items() if walk.pulls]
        parts.append(f"with {' and '.join(named) if named else 'no ζ'} on {title}")
    return ", and ".join(parts)


def _segments() -> str:
    lines = [
        [str(k), number(length, ".2f"), number(slope, ".1f"), number(1000 * step, ".0f") if k > 1 else NONE]
        for k, (length, slope, step) in enumerate(found_segments(), start=1)
    ]
    return body(lines)


def _figure_5(rows: Sequence[Row]) -> str:
    """Tabulate errors of the estimate with and without the update, by gamma and start estimate."""
    lines = [
        [
            f"{row.adaptation_gain:g}",
            f"{number(row.start_estimate, '+g')}°",
            row.update,
            ENGINES[row.engine],
            ending(row, f"{row.steps} steps"),
            number(row.trace_off_time, ".2f"),
            *map(number, (row.trace_settled, row.begun, row.ended, row.trace_error)),
            number(row.torque, ".1f"),
            number(row.absolute_end),
        ]
        for row in select(rows, part="figure 5")
    ]
    return body(lines)
