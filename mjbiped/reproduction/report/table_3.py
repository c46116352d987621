"""The part of the report on Table III, and Fig. 5 in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from mjbiped.control.registry import settings_of
from mjbiped.reproduction import placebo as family
from mjbiped.reproduction.grounds import TABLE_3, found_segments
from mjbiped.reproduction.plan import MIXED_STEPS, START_ESTIMATES
from mjbiped.reproduction.report.markdown import ENGINES, NONE, cost, delay, ending, number, percent, table
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.traces import RESOLVED_SLOPE
from mjbiped.terrain.segments import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain


def sections(rows: Sequence[Row]) -> dict[str, str]:
    """Fill the template's places about Table III and Fig. 5, by name."""
    return {
        "table_3_mixed": _table(rows, "mixed"),
        "table_3_found": _table(rows, "found"),
        "distance_mixed": _distance(rows, "mixed"),
        "distance_found": _distance(rows, "found"),
        "found_segments": _segments(),
        "ground_friction": f"{GROUND_FRICTION:g}",
        "mixed_steps": str(MIXED_STEPS),
        "mixed_rise": number(1000 * max(map(abs, Terrain.mixed().rises)), ".0f"),
        "printed_3": str(2 * len(TABLE_3)),
        "family": _family(),
        "figure_5": _figure_5(rows),
        "pulls": _pulls(rows),
        "epsilon": number(math.degrees(RESOLVED_SLOPE), ".2f"),
        "on_cycle": number(math.degrees(settings_of("adaptive")["replanning_threshold"]), ".2f"),
        "start_estimate": number(START_ESTIMATES[0], "g"),
    }


def walks_of(rows: Iterable[Row], ground: str, engine: str) -> dict[float | None, Row]:
    """Find the walks of Table III on one of the grounds, by zeta; None: no re-planning."""
    return {row.delay: row for row in rows if (row.part, row.ground, row.engine) == ("table 3", ground, engine)}


def distance(walks: dict[float | None, Row]) -> float:
    """Root mean square of ln(ours / paper's) of the torques and c_mt of all walks that came to their end."""
    ended = {zeta: walk for zeta, walk in walks.items() if walk.finished}
    if not ended:
        return math.nan
    pairs = [(walk.torque, TABLE_3[zeta][0]) for zeta, walk in ended.items()]
    pairs += [(walk.cost["absolute", None], TABLE_3[zeta][1]) for zeta, walk in ended.items()]
    return math.sqrt(float(np.mean([math.log(ours / paper) ** 2 for ours, paper in pairs])))


def _distance(rows: Sequence[Row], ground: str) -> str:
    values = []
    for engine in ENGINES:
        walks = walks_of(rows, ground, engine)
        ended = sum(walk.finished for walk in walks.values())
        part = "" if ended == len(walks) else f", the {ended} of {len(walks)} walks that came to their end"
        values.append(f"{number(100 * distance(walks), '.1f')} % ({ENGINES[engine]}{part})")
    return ", ".join(values)


def _table(rows: Sequence[Row], ground: str) -> str:
    """Tabulate Table III beside ours."""
    begun = {row.delay: row.torque for row in rows if row.part == "start"} if ground == "mixed" else None
    by_engine = [walks_of(rows, ground, engine) for engine in ENGINES]
    lines = []
    for zeta, (torque, paper) in TABLE_3.items():
        walks = [walks.get(zeta) for walks in by_engine]
        here = walks[0]
        lines.append(
            [
                delay(zeta),
                number(torque, ".5g"),
                *([] if begun is None else [number(begun.get(zeta), ".5g")]),
                *(_torque(walk) for walk in walks),
                percent(math.nan if here is None else here.torque, torque),
                number(paper),
                *(_cost(walk) for walk in walks),
                percent(math.nan if here is None else here.cost["absolute", None], paper),
                *(number(None if walk is None else walk.least_force, ".2f") for walk in walks),
                _friction(here),
            ]
        )
    sides = ("paper", "hybrid", "MuJoCo", "hybrid − paper")
    torques = [f"torque, {side}" for side in sides]
    if begun is not None:
        torques.insert(1, "start alone")
    forces = ("least F_n, hybrid", "least F_n, MuJoCo", "friction asked, hybrid")
    return table(("ζ", *torques, *(f"c_mt, {side}" for side in sides), *forces), lines)


def _torque(walk: Row | None) -> str:
    """Write the greatest torque, or where the walk ended before its end."""
    return NONE if walk is None else number(walk.torque, ".5g") if walk.finished else ending(walk)


def _pulls(rows: Sequence[Row]) -> str:
    """List the walks of the hybrid engine that need a ground that pulls, in words."""
    parts = []
    for ground, title in (("mixed", "our mixed ground"), ("found", "the ground that was found")):
        walks = walks_of(rows, ground, "hybrid")
        named = ["no re-planning" if zeta is None else f"ζ = {zeta:g}" for zeta, walk in walks.items() if walk.pulls]
        parts.append(f"with {' and '.join(named) if named else 'no ζ'} on {title}")
    return ", and ".join(parts)


def _friction(walk: Row | None) -> str:
    """Write the greatest |F_t / F_n|, or that the ground would have to pull, where no friction suffices."""
    if walk is not None and walk.pulls:
        return "pulls"
    return number(None if walk is None else walk.friction, ".3g")


def _cost(walk: Row | None) -> str:
    """Write c_mt up to the walk's end, or where the walk ended before it."""
    return NONE if walk is None else cost(walk, "absolute", None) if walk.finished else f"X {walk.steps + 1}"


def _segments() -> str:
    lines = [
        [str(k), number(length, ".2f"), number(slope, ".1f"), number(1000 * step, ".0f") if k > 1 else NONE]
        for k, (length, slope, step) in enumerate(found_segments(), start=1)
    ]
    return table(("segment", "length, m", "slope, ° downhill", "step, mm up"), lines)


def _family() -> str:
    """Describe the family of grounds that was searched."""
    (short, long), (up, down), (low, high) = family.LENGTHS, family.SLOPES, family.RISES
    return (
        f"grounds of {family.SEGMENTS} segments of {short:g} to {long:g} m, slopes of {number(up, 'g')}° to {down:g}° "
        f"and steps of {number(1000 * low, 'g')} to {1000 * high:g} mm between them"
    )


def _figure_5(rows: Sequence[Row]) -> str:
    """Tabulate errors of the estimate with and without the update, by gamma and start estimate."""
    lines = []
    for row in rows:
        if row.part == "figure 5":
            traces = row.traces
            errors = (number(value, ".4f") for value in (traces.settled, row.begun, row.ended, traces.error))
            end = f"{row.steps} steps" if row.finished else ending(row)
            start = f"{number(row.start_estimate, '+g')}°"
            lines.append(
                [f"{row.adaptation_gain:g}", start, row.update, ENGINES[row.engine], end,
                 number(traces.off_time, ".2f"), *errors, number(row.torque, ".1f"), number(row.cost["absolute", None])]
            )  # fmt: skip
    headings = ("γ", "start", "update (27)", "engine", "walk", "off by more than ε, s", "before the first change, °")
    errors_at = ("steps' beginnings, °", "steps' ends, °", "rms, °")
    return table((*headings, *errors_at, "torque, N m", "c_mt"), lines)
