"""Claims of section V, tested on our walks by engine, and counted by what was fitted to the paper's numbers.

About Table II they are tested by a reading of its grounds; about Table III and Figs. 4 to 6 on two grounds of our own.
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mjbiped.control.registry import settings_of
from mjbiped.reproduction.cell import RESOLVED_SLOPE
from mjbiped.reproduction.rows import ENGINES, NO_WALK, NONE, Row, find, in_words, number, select
from mjbiped.reproduction.section_5 import (
    ADAPTATION_GAINS,
    DIGITS,
    DRAWN_DELAYS,
    ENERGY_BASED,
    FILES,
    GROUNDS,
    IMITATED_SLOPE,
    PAPER_GAIN,
    START_ESTIMATES,
    TABLE_2,
    TABLE_3,
    meets,
)
from mjbiped.reproduction.table_2 import Results

CLAIMS: dict[str, tuple[str, str]] = tomllib.loads((FILES / "claims.toml").read_text(encoding="utf-8"))
"""Place in the paper and sentence, by name."""

GROUPS = UNFITTED, BLIND, FITTED, FOUND = "unfitted", "blind", "fitted", "found"
"""What is fitted to the paper's numbers in the walks that are tested: nothing; the reading of the grounds; the other
methods' settings as well; the ground."""

ZERO = 0.01
"""Greatest ratio of z2 with to without re-planning that counts as reduced to zero; our own bound."""

COUNTING = (UNFITTED, BLIND)
"""The groups that count as evidence: nothing but the reading of the grounds was fitted to their numbers."""

_HALF = 0.5 * 10.0**-DIGITS
_PASSIVE = round(math.sin(IMITATED_SLOPE), DIGITS)
_LEAST = 0.8  # zeta of Table III's lowest c_mt
_REMARKABLE = (0.6, 0.7, 0.8, 0.9)  # V-D
_EPSILON = math.degrees(RESOLVED_SLOPE)
_ON_CYCLE = math.degrees(settings_of("adaptive")["replanning_threshold"])


class Answer(NamedTuple):
    """The answer of one engine's walks to a claim of the paper.

    Attributes:
        claim: The claim, a sentence that is true or false by itself.
        source: Place of the claim in the paper.
        holds: Whether the claim holds; None where its walks do not exist.
        found: Our numbers.
        of: The part of the walks that was tested, where others did not come to their end; else empty.
        engine: Engine of the walks.
        group: One of `GROUPS`.
    """

    claim: str
    source: str
    holds: bool | None
    found: str = ""
    of: str = ""
    engine: str = ""
    group: str = ""

    @property
    def verdict(self) -> str:
        """The answer in words, with the numbers; a dash without an answer."""
        if self.holds is None:
            return NONE
        said = ("holds" if self.holds else "**does not hold**") + (f" for {self.of}" if self.of else "")
        return f"{said}: {self.found}" if self.found else said


def checks(results: Results) -> list[Answer]:
    """Answer all claims, engine by engine and group by group."""
    return [
        each._replace(engine=engine, group=group)
        for engine in ENGINES
        for group, answers in (
            (UNFITTED, _of_adaptive(results, engine)),
            (BLIND, _of_all_methods(results, engine, "blind")),
            (FITTED, _of_all_methods(results, engine, "fitted")),
            (UNFITTED, _of_figures(results.rows, "mixed", "On our mixed ground", engine)),
            (FOUND, _of_figures(results.rows, "found", "On the ground that was found", engine)),
        )
        for each in answers
    ]


def walks_of(rows: Iterable[Row], ground: str, engine: str) -> dict[float | None, Row]:
    """Find the walks of Table III on one of the grounds, by zeta; None: no re-planning."""
    return {row.delay: row for row in select(rows, part="table 3", ground=ground, engine=engine)}


def _answer(
    name: str, holds: bool | None, found: str = "", numbers: Iterable[float] = (), of: str = "", **words: str | float
) -> Answer:
    """Answer a claim, unless one of its numbers does not exist; words are filled into the claim's braces."""
    source, claim = CLAIMS[name]
    asked = holds is not None and not any(map(math.isnan, numbers))
    return Answer(claim.format(**words), source, *((holds, found, of) if asked else (None,)))


def _of_adaptive(results: Results, engine: str) -> Iterator[Answer]:
    """Test claims about the adaptive controller on level ground, where reading and zeta make no difference."""
    value = results.best.cost(results.walks("adaptive", engine=engine)[0])
    yield _level_number(value, "adaptive")
    off = abs(TABLE_2["adaptive"]["level"] - _PASSIVE)
    near = abs(round(value, DIGITS) - _PASSIVE) < off + _HALF
    yield _answer("level_passive", near, number(value, ".5f"), [value], off=off)


def _of_all_methods(results: Results, engine: str, settings: str) -> Iterator[Answer]:
    """Test claims about all methods; reading and zeta were fitted to the table's numbers.

    Args:
        results: The reproduction.
        engine: "hybrid" or "mujoco".
        settings: The other methods' settings, "blind" or "fitted".
    """
    by_method = {method: results.walks(method, settings, engine) for method in TABLE_2}
    walks = {ground: {method: by_method[method][k] for method in TABLE_2} for k, ground in enumerate(GROUNDS)}
    costs = {ground: {method: results.best.cost(walk) for method, walk in walks[ground].items()} for ground in walks}
    shown = {ground: {method: round(cost, DIGITS) for method, cost in costs[ground].items()} for ground in costs}

    def asked(name: str, on: str, methods: Iterable[str], holds: bool, more: str = "", **words: Any) -> Answer:
        mine = {method: costs[on][method] for method in methods}
        found = ", ".join(f"{method} {number(cost)}" for method, cost in mine.items())
        return _answer(name, holds, more + found, mine.values(), **words)

    def against_level(name: str, ground: str, sign: float) -> Answer:
        here, level = costs[ground], costs["level"]
        holds = all(sign * (shown[ground][method] - shown["level"][method]) > _HALF for method in here)
        found = ", ".join(f"{method} {number(here[method])} against {number(level[method])}" for method in here)
        return _answer(name, holds, found, [*here.values(), *level.values()])

    def similar(ground: str) -> Answer:
        """Test V-A's "similar energy efficiency on uneven terrains": as similar as the table's own numbers."""
        papers, ours = [TABLE_2[method][ground] for method in TABLE_2], shown[ground].values()
        allowed, spread = round(max(papers) - min(papers), DIGITS), max(ours) - min(ours)
        holds, more = spread < allowed + _HALF, f"{number(spread)}; "
        return asked("similar", ground, TABLE_2, holds, more, ground=ground, allowed=allowed)

    for method in ENERGY_BASED:
        yield _level_number(costs["level"][method], method)
    level = shown["level"]
    for method in ("PBC", "ECC"):
        nearer = abs(level["adaptive"] - _PASSIVE) < abs(level[method] - _PASSIVE) - _HALF
        yield asked("closer_to_passive", "level", ("adaptive", method), nearer, method=method)
    yield asked("same_as_ketc", "level", ("adaptive", "KETC"), level["adaptive"] == level["KETC"])
    yield against_level("higher_than_level", "stair 1", 1.0)
    lowest = shown["stair 1"]["adaptive"] < min(shown["stair 1"][method] for method in ENERGY_BASED)
    yield asked("lowest", "stair 1", TABLE_2, lowest)
    yield similar("stair 1")
    yield against_level("lower_than_level", "slope 1", -1.0)
    yield similar("slope 1")
    for ground in ("stair 2", "slope 2"):
        for method, walk in walks[ground].items():
            yield _comes_through(walk, results, method, ground)
    higher = shown["slope 2"]["ECC"] > shown["slope 2"]["adaptive"]
    yield asked("higher_than_adaptive", "slope 2", ("adaptive", "ECC"), higher)


def _name(method: str) -> str:
    return "the adaptive controller" if method == "adaptive" else method


def _level_number(value: float, method: str) -> Answer:
    """Compare a number of level ground, to half a unit of its last digit."""
    paper, found = TABLE_2[method]["level"], number(value, ".5f")
    return _answer("level_number", meets(value, paper), found, [value], method=_name(method), paper=paper)


def _comes_through(walk: Row, results: Results, method: str, ground: str) -> Answer:
    """Test whether a method makes the steps over which the reading takes c_mt, or fails to, as in the table."""
    crossed, walked = math.isnan(TABLE_2[method][ground]), math.isfinite(results.best.cost(walk))
    found = f"c_mt {results.best.written(walk)}" if walked else f"{walk.outcome} after {walk.steps} steps"
    name, holds = "not_walked" if crossed else "walked", walked != crossed if walk.outcome else None
    return _answer(name, holds, found, ground=ground.capitalize(), method=_name(method))


Walks: TypeAlias = Mapping[float | None, Row]
"""Walks of Table III on a ground by zeta; None: no re-planning."""

Say: TypeAlias = Callable[..., Answer]
"""`_answer` with the words of the ground and of its bounds."""


def _of_figures(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims about a ground that stands for the one of Table III and Figs. 4 to 6.

    Args:
        rows: Rows of the reproduction.
        ground: "mixed" or "found".
        title: Name of the ground, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    walks = walks_of(rows, ground, engine)
    starts = " and ".join(f"{start:+g}°" for start in START_ESTIMATES).replace("-", "−")
    start = starts if ground == "mixed" else "0°"
    say = partial(_answer, on=title, start=start, epsilon=_EPSILON, on_cycle=_ON_CYCLE, zero=100 * ZERO)
    yield from _table_3(walks, say)
    if ground == "mixed":
        yield from _figure_4(_walks_of_figure_5(rows, engine, PAPER_GAIN, "yes"), say)
        yield from _figure_5(rows, engine, say)
    else:
        yield from _figure_4([walks.get(DRAWN_DELAYS[1], NO_WALK)], say)
    yield from _figure_6(walks, say)


def _table_3(walks: Walks, say: Say) -> Iterator[Answer]:
    """Test the claims of Table III and section V-D."""
    lost = [f"ζ = {in_words(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    yield say("ends", not lost if walks else None, "; ".join(lost) or f"{len(walks)} walks")
    ended = {zeta: walk if (walk := walks.get(zeta, NO_WALK)).finished else NO_WALK for zeta in TABLE_3}
    torque = {zeta: walk.torque for zeta, walk in ended.items()}
    cost = {zeta: float(walk.absolute_end) for zeta, walk in ended.items()}
    every = [zeta for zeta in TABLE_3 if zeta is not None]
    zetas = [zeta for zeta in every if ended[zeta].finished]
    of = "" if zetas == every else f"the {len(zetas)} of {len(every)} ζ that came to their end"

    def claim(name: str, asked: bool, holds: bool, found: str) -> Answer:
        return say(name, holds if asked else None, found, of=of)

    first, last = min(zetas, default=_LEAST), max(zetas, default=_LEAST)
    falls = all(torque[a] > torque[b] for a, b in itertools.pairwise(zetas))
    found = f"{torque[first]:.5g} N m at ζ = {first:g} to {torque[last]:.5g} at {last:g}"
    yield claim("falling_torque", len(zetas) > 1, falls, found)
    between = {"without": torque[None], "ζ = 0.4:": torque[0.4], "ζ = 0.5:": torque[0.5]}
    found = ", ".join(f"{name} {number(value, '.4g')}" for name, value in between.items()) + " N m"
    yield say("torque_between", torque[0.5] < torque[None] < torque[0.4], found, between.values())
    shown = {zeta: round(value, DIGITS) for zeta, value in cost.items()}
    least = min(zetas, key=cost.__getitem__, default=_LEAST)
    found = f"{cost[_LEAST]:.4f}, lowest {cost[least]:.4f} at ζ = {least:g}"
    yield claim("least_cost", _LEAST in zetas and len(zetas) > 1, shown[_LEAST] <= shown[least], found)
    others = [zeta for zeta in zetas if zeta not in _REMARKABLE]
    high, low = max(_REMARKABLE, key=cost.__getitem__), min(others, key=cost.__getitem__, default=_LEAST)
    found = f"at most {cost[high]:.4f} (ζ = {high:g}); the others at least {cost[low]:.4f} (ζ = {low:g})"
    yield claim("remarkable", bool(others) and {*_REMARKABLE} <= {*zetas}, shown[high] < shown[low], found)
    found = f"{cost[None]:.4f}, lowest with it {cost[least]:.4f} at ζ = {least:g}"
    yield claim("cheaper_without", ended[None].finished and bool(zetas), shown[None] < shown[least], found)


def _walks_of_figure_5(rows: Sequence[Row], engine: str, gain: float, update: str) -> list[Row]:
    """Walks with one gamma, with or without the update (27), by `START_ESTIMATES`."""
    mine = {"part": "figure 5", "engine": engine, "adaptation_gain": gain, "update": update}
    return [find(rows, start_estimate=start, **mine) for start in START_ESTIMATES]


def _figure_4(walks: Sequence[Row], say: Say) -> Iterator[Answer]:
    """Test the claims of section V-B, Fig. 4(b) to (d)."""
    yield _below(say, "settled", _greatest(walks, "trace_settled"), _EPSILON)
    yield _below(say, "later", _greatest(walks, "trace_later"), _EPSILON)
    straight = _greatest(walks, "trace_straight")
    bent = float(np.min([walk.trace_bent if walk.finished else math.nan for walk in walks]))
    found = f"at most {straight:.2f} N m from it, re-planned at least {bent:.2f} N m"
    yield say("straight", straight < bent, found, [straight, bent])
    yield _below(say, "z1", _greatest(walks, "trace_z1"), _ON_CYCLE)


def _figure_5(rows: Sequence[Row], engine: str, say: Say) -> Iterator[Answer]:
    """Test the claims of section V-C about the estimate update."""
    with_it, without = (_walks_of_figure_5(rows, engine, PAPER_GAIN, update) for update in ("yes", "no"))
    if not all(walk.finished for walk in with_it + without):
        with_it = without = [NO_WALK]

    def less(name: str, column: str, form: str, unit: str) -> Answer:
        """Test whether a number is smaller with the update than without, from every start."""
        both = [(getattr(a, column), getattr(b, column)) for a, b in zip(with_it, without, strict=True)]
        found = "; ".join(f"{number(a, form)}{unit} against {number(b, form)}{unit}" for a, b in both)
        return say(name, all(a < b for a, b in both), found, itertools.chain(*both))

    yield less("off_time", "trace_off_time", ".2f", " s")
    yield _below(say, "ended", _greatest(without, "ended"), _EPSILON, " at most")
    yield less("begun", "begun", ".4f", "°")
    slow = _walks_of_figure_5(rows, engine, min(ADAPTATION_GAINS), "yes")
    yield _below(say, "jump", _greatest(slow, "jump"), _EPSILON, f" of errors up to {_greatest(slow, 'begun'):.2f}°")


def _figure_6(walks: Walks, say: Say) -> Iterator[Answer]:
    """Test the claims of section V-D, Fig. 6, about re-planning."""
    for name, form, unit, most in (
        ("travel", ".2f", "°", 1.0),
        ("error", ".4f", "°", 1.0),
        ("z2", ".4f", " rad/s", ZERO),
    ):
        *values, without = (_greatest([walks.get(zeta, NO_WALK)], f"trace_{name}") for zeta in DRAWN_DELAYS)
        first = " and ".join(f"{number(value, form)}{unit}" for value in values)
        found = f"{first} against {number(without, form)}{unit}"
        yield say(name, max(values) < most * without, found, [*values, without])


def _greatest(walks: Sequence[Row], name: str) -> float:
    """Greatest number of some walks; NaN unless all walks have it and came to their end."""
    return float(np.max([getattr(walk, name) if walk.finished else math.nan for walk in walks]))


def _below(say: Say, name: str, value: float, bound: float, more: str = "") -> Answer:
    """Answer the claim that an angle is below a bound, degrees."""
    return say(name, value < bound, f"{number(value, '.4f')}°{more}", [value])


def by_claim(answers: Iterable[Answer], groups: Sequence[str] = GROUPS) -> dict[tuple[str, str, str], list[Answer]]:
    """Gather the engines' answers by group, claim and source: a claim counts once, in however many engines.

    Args:
        answers: Any number of answers.
        groups: The groups that are wanted.
    """
    found: dict[tuple[str, str, str], list[Answer]] = {}
    for each in answers:
        if each.group in groups:
            found.setdefault((each.group, each.claim, each.source), []).append(each)
    return found


def missed(answers: Iterable[Answer], *groups: str) -> str:
    """Count the claims of some groups that an engine denies, out of those that have an answer."""
    known = [{each.holds for each in said} - {None} for said in by_claim(answers, groups).values()]
    return f"{sum(False in said for said in known)} of {sum(map(bool, known))}"


def what_counts(answers: Iterable[Answer]) -> str:
    """Say which rows count, and how many of their claims do not hold."""
    return (
        f'What counts are the rows "{UNFITTED}" and "{BLIND}", whose settings were not chosen by the paper\'s numbers: '
        f"{missed(answers, *COUNTING)} claims do not hold in every engine that walked them. "
        f'In the rows "{FITTED}" the gains, in "{FOUND}" the ground were searched for so that they agree.'
    )
