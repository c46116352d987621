"""The pages of the report: tables and numbers of the results, by functions that the pages' templates call."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product

import numpy as np
from jinja2 import Environment, StrictUndefined

from mjbiped.records.measures import WORK_KINDS
from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.cell import LENGTHS
from mjbiped.studies.reproduction.claims import Answer, by_claim, checks, missed, walks_of
from mjbiped.studies.reproduction.results import (
    ENGINES,
    NO_WALK,
    NONE,
    Choice,
    Results,
    Row,
    engine_shown,
    excess,
    find,
    in_words,
    number,
    select,
    side_distances,
)  # fmt: skip

PAGE = "reproduction.md"
TABLES = "tables/reproduction.md"
TEMPLATES = {PAGE: "template_page.md", TABLES: "template_tables.md"}
FITS = "fits.json"
"""Texts of the page about the searches that `scripts/paper/fits.py` makes."""


def stored(file: str) -> str:
    """Read a text that is part of this package."""
    return paper.FILES.joinpath(file).read_text(encoding="utf-8")


def render(results: Results) -> dict[str, str]:
    """Write the page and its tables, by file name, from a reproduction and the stored results of the fits."""
    return {name: _filled(stored(file), results) for name, file in TEMPLATES.items()}


def section(results: Results, heading: str) -> str:
    """Write the section of the page of tables that has a heading."""
    return _filled(stored(TEMPLATES[TABLES]).partition(f"\n### {heading}\n")[2].partition("\n#")[0], results)


def _filled(template: str, results: Results) -> str:
    """Fill a template with a reproduction; its functions are those of this module and some others."""
    environment = Environment(
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    environment.filters |= {
        "number": number,
        "excess": excess,
        "zeta": in_words,
        "law": _law,
        "engine": ENGINES.get,
        "ending": lambda walk: walk.ending(f"{walk.steps} steps"),
        "cost": lambda walk, choice=None: (choice or results.best).written(walk),
    }
    own = (alike, apart, beside, distances, mujoco_steps, pairs, parted, printed, pulls, shown, sides, started, turned)
    environment.globals |= {each.__name__: each for each in (*own, by_claim, engine_shown, find, missed)}
    environment.globals |= {"paper": paper, "ENGINES": ENGINES, "WORK_KINDS": WORK_KINDS, "LENGTHS": LENGTHS}
    fits, answers = json.loads(stored(f"fits/{FITS}")), cache(partial(checks, results))
    return environment.from_string(template).render(results=results, rows=results.rows, answers=answers, fits=fits)


def printed(method: str, ground: str) -> str:
    """Write c_mt of Table II: X for a walk that did not come to its end, a dash for a method that it lacks."""
    value = paper.TABLE_2.get(method, {}).get(ground)
    return NONE if value is None else "X" if math.isnan(value) else number(value)


def mujoco_steps(rows: Sequence[Row]) -> int:
    """Number of steps of MuJoCo's walks on the grounds of Table II."""
    return max((row.steps for row in select(rows, part="table 2", engine="mujoco")), default=0)


def alike(answers: Sequence[Answer]) -> str:
    """Count the claims that both engines answer in the same way, and list the others."""
    both = {key: {each.holds for each in said} for key, said in by_claim(answers).items()}
    both = {key: holds for key, holds in both.items() if None not in holds}
    apart = [f"\n* {claim}" for (_, claim, _), holds in both.items() if len(holds) == 2]
    return f"{len(both) - len(apart)} of {len(both)}" + (f"; they differ on\n{''.join(apart)}" if apart else ".")


def shown(results: Results) -> Iterator[tuple[str, str, list[Row]]]:
    """Of each number of Table II: ground, method, and the walks of both engines, blind, settled and fitted in turn.

    The adaptive controller has the paper's gains, and its zeta was chosen with the reading: its walks are "fitted".
    """
    for (k, ground), method in product(enumerate(paper.GROUNDS), paper.METHODS):
        settings = ("blind", results.sources[0], "fitted")
        walks = [results.walks(method, given, engine)[k] for given in settings for engine in ENGINES]
        yield ground, method, [NO_WALK] * 4 + walks[4:] if method == "adaptive" else walks


def beside(results: Results, method: str, ground: str, walks: Sequence[Row]) -> Iterator[str]:
    """Write c_mt of the walks of both engines, and by how much the hybrid one's exceeds the paper's, set by set."""
    best, known = results.best, paper.TABLE_2.get(method, {}).get(ground, math.nan)
    for here, there in zip(walks[::2], walks[1::2], strict=True):
        yield from (best.written(here), best.written(there), excess(best.cost(here), known))


def started(results: Results) -> Iterator[tuple[str, str, list[Row]]]:
    """Of each method: its name, the error of the slope told at the start, in words, and its fitted walks."""
    for method in paper.ENERGY_BASED:
        wrong = select(results.rows, part="misjudged", method=method)
        yield method, "right", results.walks(method)
        yield method, f"{number(paper.START_ERROR, '+g')}°", wrong[::2]
        yield method, f"{number(-paper.START_ERROR, '+g')}°", wrong[1::2]


def turned(results: Results) -> str:
    """List where a wrong slope at the start turns a number into an X, or an X into a number, in words."""
    cost = results.best.cost
    found = [
        f"{method} on {walk.ground} ({told})"
        for method, told, walks in started(results)
        for right, walk in zip(results.walks(method), walks, strict=True)
        if math.isnan(cost(right)) != math.isnan(cost(walk))
    ]
    return ", ".join(found) or "nowhere"


def sides(results: Results, pair: Sequence[str]) -> Iterator[tuple[Choice, list[Row]]]:
    """Find the nearest reading of each pattern of the stairs or of the slopes, and its walks."""
    nearest: dict[str, Choice] = {}
    for side in sorted(side_distances(results.rows, pair), key=lambda side: side.distance):
        nearest.setdefault(side.stairs[0], side)
    for side in nearest.values():
        if not math.isfinite(side.distance):  # a fall, however it is read: in which step is shown for one setting
            side = replace(side, delay=0.8, kind="absolute", length=max(LENGTHS))
        places = [paper.Place(ground, *side.stairs) for ground in pair]
        yield side, results.walks("adaptive", side.delay, places=places)


def pairs(rows: Sequence[Row]) -> list[tuple[Row, Row, list[float]]]:
    """Walks of Table II that were made in both engines, the hybrid one first.

    And c_mt in both over the steps of MuJoCo's walk; empty where one did not come so far.
    """
    mine, found = [row for row in rows if row.part in ("table 2", "blind", "fitted")], []
    here, there = (
        {(row.part, row.place_read, row.method, row.delay, row.slope_source): row for row in mine if row.engine == name}
        for name in ENGINES
    )
    for key, other in there.items():
        both = here[key], other
        came = other.finished and here[key].steps >= other.steps
        found.append((*both, [float(getattr(walk, f"absolute_{other.steps}")) for walk in both] if came else []))
    return found


def parted(rows: Sequence[Row]) -> str:
    """Count the walks that ended differently: not in the same step, nor both as far as the shorter was to go."""
    both = pairs(rows)
    ended = [(here, there) for here, there, costs in both if not costs]
    others = [there for here, there in ended if here.finished or there.finished or here.steps != there.steps]
    if not others:
        return f"All {len(both)} end alike."
    named = "; ".join(dict.fromkeys(f"{row.method} on {row.ground} {row.pattern}" for row in others))
    return f"{len(others)} of {len(both)} end in another step than in the other engine: {named}."


def apart(rows: Sequence[Row]) -> str:
    """Describe the difference of the engines' c_mt: median, ninth decile, and the walk that differs most."""
    compared = [(abs(costs[1] / costs[0] - 1.0), there) for _, there, costs in pairs(rows) if costs]
    if not compared:
        return "no walk was compared"
    off = [difference for difference, _ in compared]
    middle, nine_tenths, most = (number(100 * float(np.quantile(off, part)), ".2g") for part in (0.5, 0.9, 1.0))
    last = compared[int(np.argmax(off))][1]
    return (
        f"c_mt of the {len(off)} walks of Table II that come to their end in both differs by {middle} % in the median, "
        f"by up to {nine_tenths} % in nine of ten, and by {most} % at most ({_law(last)}, on {last.ground} "
        f"{last.pattern})"
    )


def _law(row: Row) -> str:
    """Name a method with its settings."""
    if row.method == "adaptive":
        return f"adaptive, ζ = {in_words(row.delay)}"
    return f"{row.method}, {row.gains.replace('-', '−')}, {row.slope_source}"


def distance(walks: Mapping[float | None, Row]) -> float:
    """Root mean square of ln(ours / paper's) of the torques and c_mt of all walks that came to their end."""
    ended = {zeta: walk for zeta, walk in walks.items() if walk.finished}
    if not ended:
        return math.nan
    ours = [(walk.torque, walk.absolute_end) for walk in ended.values()]
    return math.sqrt(float(np.mean(np.log(np.divide(ours, [paper.TABLE_3[zeta] for zeta in ended])) ** 2)))


def distances(rows: Sequence[Row], ground: str) -> str:
    """Write the distance of each engine's walks on a ground from Table III."""
    values = []
    for engine, name in ENGINES.items():
        walks = walks_of(rows, ground, engine)
        ended = sum(walk.finished for walk in walks.values())
        part = "" if ended == len(walks) else f", the {ended} of {len(walks)} walks that came to their end"
        values.append(f"{number(100 * distance(walks), '.1f')} % ({name}{part})")
    return ", ".join(values)


def pulls(rows: Sequence[Row]) -> str:
    """List the walks of the hybrid engine that need a ground that pulls, in words."""
    parts = []
    for ground, title in (("mixed", "our mixed ground"), ("found", "the ground that was found")):
        pulled = [zeta for zeta, walk in walks_of(rows, ground, "hybrid").items() if walk.least_force < 0.0]
        named = ["no re-planning" if zeta is None else f"ζ = {zeta:g}" for zeta in pulled]
        parts.append(f"with {' and '.join(named) or 'no ζ'} on {title}")
    return ", and ".join(parts)
