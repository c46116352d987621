"""The part of the report on Table III, and Fig. 5 in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from mjbiped.reproduction.grounds import TABLE_3, found_segments
from mjbiped.reproduction.report.markdown import ENGINES, NONE, cost, delay, ending, excess, number, share
from mjbiped.reproduction.rows import Row, select
from mjbiped.utils.markdown import markdown_table


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
    ours = [(walk.torque, walk.cost["absolute", None]) for walk in ended.values()]
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
    begun = {row.delay: row.torque for row in select(rows, part="start")} if ground == "mixed" else None
    by_engine = [walks_of(rows, ground, engine) for engine in ENGINES]
    lines = []
    for zeta, (torque, paper) in TABLE_3.items():
        walks = [walks.get(zeta) for walks in by_engine]
        here = walks[0]
        ours, price = (math.nan, math.nan) if here is None else (here.torque, here.cost["absolute", None])
        lines.append(
            [
                delay(zeta),
                number(torque, ".5g"),
                *([] if begun is None else [number(begun.get(zeta), ".5g")]),
                *(ending(walk, number(None if walk is None else walk.torque, ".5g")) for walk in walks),
                excess(ours, torque),
                number(paper),
                *(cost(walk, "absolute", None) for walk in walks),
                excess(price, paper),
                *(number(None if walk is None else walk.least_force, ".2f") for walk in walks),
                "pulls" if here and here.pulls else number(None if here is None else here.friction, ".3g"),
            ]
        )
    sides = ("paper", "hybrid", "MuJoCo", "hybrid − paper")
    torques = [f"torque, {side}" for side in sides]
    if begun is not None:
        torques.insert(1, "start alone")
    forces = ("least F_n, hybrid", "least F_n, MuJoCo", "friction asked, hybrid")
    return markdown_table(("ζ", *torques, *(f"c_mt, {side}" for side in sides), *forces), lines, 1)


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
    return markdown_table(("segment", "length, m", "slope, ° downhill", "step, mm up"), lines, 1)


def _figure_5(rows: Sequence[Row]) -> str:
    """Tabulate errors of the estimate with and without the update, by gamma and start estimate."""
    lines = []
    for row in select(rows, part="figure 5"):
        errors = (row.traces.settled, row.begun, row.ended, row.traces.error)
        lines.append(
            [
                f"{row.adaptation_gain:g}",
                f"{number(row.start_estimate, '+g')}°",
                row.update,
                ENGINES[row.engine],
                ending(row, f"{row.steps} steps"),
                number(row.traces.off_time, ".2f"),
                *map(number, errors),
                number(row.torque, ".1f"),
                number(row.cost["absolute", None]),
            ]
        )
    headings = ("γ", "start", "update (27)", "engine", "walk", "off by more than ε, s", "before the first change, °")
    errors_at = ("steps' beginnings, °", "steps' ends, °", "rms, °")
    return markdown_table((*headings, *errors_at, "torque, N m", "c_mt"), lines, 1)
