"""Claims of section V about Table III and Figs. 4 to 6, tested on the grounds that stand for the paper's."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

from mjbiped.control.registry import settings_of
from mjbiped.reproduction.grounds import TABLE_3
from mjbiped.reproduction.plan import ADAPTATION_GAINS, DRAWN_DELAYS, PAPER_GAIN, START_ESTIMATES
from mjbiped.reproduction.report.answers import Answer, Words, answer
from mjbiped.reproduction.report.markdown import delay, number, printed
from mjbiped.reproduction.report.table_3 import walks_of
from mjbiped.reproduction.rows import NO_WALK, Row, find
from mjbiped.reproduction.traces import RESOLVED_SLOPE

_ZETAS = [zeta for zeta in TABLE_3 if zeta is not None]
_LEAST = 0.8  # zeta of Table III's lowest c_mt
_REMARKABLE = (0.6, 0.7, 0.8, 0.9)  # V-D
_EPSILON = math.degrees(RESOLVED_SLOPE)
ZERO = 0.01
"""Greatest ratio of z2 with to without re-planning that counts as reduced to zero; our own bound."""
_ON_CYCLE = math.degrees(settings_of("adaptive")["replanning_threshold"])

_WORDS: Words = {
    "epsilon": _EPSILON,
    "on_cycle": _ON_CYCLE,
    "zero": 100 * ZERO,
    "start": " and ".join(f"{start:+g}°" for start in START_ESTIMATES).replace("-", "−"),
}

Walks = Mapping[float | None, Row]
"""Walks of Table III on a ground by zeta; None: no re-planning."""


def answers(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims about a ground that stands for the one of Table III and Figs. 4 to 6.

    Args:
        rows: Rows of the reproduction.
        ground: "mixed" or "found".
        title: Name of the ground, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    walks, words = walks_of(rows, ground, engine), {**_WORDS, "on": title}
    yield from _table_3(walks, words)
    if ground == "mixed":
        yield from _figure_4(_walks_of_figure_5(rows, engine, PAPER_GAIN, "yes"), words)
        yield from _figure_5(rows, engine, words)
    else:
        yield from _figure_4([walks.get(DRAWN_DELAYS[1], NO_WALK)], {**words, "start": "0°"})
    yield from _figure_6(walks, words)


def _table_3(walks: Walks, words: Words) -> Iterator[Answer]:
    """Test the claims of Table III and section V-D."""
    lost = [f"ζ = {delay(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    yield answer("ends", words, not lost if walks else None, "; ".join(lost) or f"{len(walks)} walks")
    ended = {zeta: walk if (walk := walks.get(zeta, NO_WALK)).finished else NO_WALK for zeta in TABLE_3}
    torque = {zeta: walk.torque for zeta, walk in ended.items()}
    cost = {zeta: float(walk.absolute_end) for zeta, walk in ended.items()}
    zetas = [zeta for zeta in _ZETAS if ended[zeta].finished]
    of = "" if len(zetas) == len(_ZETAS) else f"the {len(zetas)} of {len(_ZETAS)} ζ that came to their end"

    def claim(name: str, asked: bool, holds: bool, found: str) -> Answer:
        return answer(name, words, holds if asked else None, found, of=of)

    first, last = (zetas[0], zetas[-1]) if zetas else (_LEAST, _LEAST)
    falls = all(torque[a] > torque[b] for a, b in itertools.pairwise(zetas))
    found = f"{torque[first]:.5g} N m at ζ = {first:g} to {torque[last]:.5g} at {last:g}"
    yield claim("falling_torque", len(zetas) > 1, falls, found)
    between = {"without": torque[None], "ζ = 0.4:": torque[0.4], "ζ = 0.5:": torque[0.5]}
    found = ", ".join(f"{name} {number(value, '.4g')}" for name, value in between.items()) + " N m"
    yield answer("torque_between", words, torque[0.5] < torque[None] < torque[0.4], found, between.values())
    least = min(zetas, key=cost.__getitem__, default=_LEAST)
    holds, found = printed(cost[_LEAST]) <= printed(cost[least]), f"lowest {cost[least]:.4f} at ζ = {least:g}"
    yield claim("least_cost", _LEAST in zetas and len(zetas) > 1, holds, f"{cost[_LEAST]:.4f}, {found}")
    others = [zeta for zeta in zetas if zeta not in _REMARKABLE]
    high, low = max(_REMARKABLE, key=cost.__getitem__), min(others, key=cost.__getitem__, default=_LEAST)
    found = f"at most {cost[high]:.4f} (ζ = {high:g}); the others at least {cost[low]:.4f} (ζ = {low:g})"
    asked = bool(others) and {*_REMARKABLE} <= {*zetas}
    yield claim("remarkable", asked, printed(cost[high]) < printed(cost[low]), found)
    holds, found = printed(cost[None]) < printed(cost[least]), f"lowest with it {cost[least]:.4f} at ζ = {least:g}"
    yield claim("cheaper_without", ended[None].finished and bool(zetas), holds, f"{cost[None]:.4f}, {found}")


def _walks_of_figure_5(rows: Sequence[Row], engine: str, gain: float, update: str) -> list[Row]:
    """Walks with one gamma, with or without the update (27), by `plan.START_ESTIMATES`."""
    mine = {"part": "figure 5", "engine": engine, "adaptation_gain": gain, "update": update}
    return [find(rows, start_estimate=start, **mine) for start in START_ESTIMATES]


def _figure_4(walks: Sequence[Row], words: Words) -> Iterator[Answer]:
    """Test the claims of section V-B, Fig. 4(b) to (d)."""
    yield _below("settled", _greatest(walks, "trace_settled"), _EPSILON, words)
    yield _below("later", _greatest(walks, "trace_later"), _EPSILON, words)
    straight, bent = _greatest(walks, "trace_straight"), -_greatest(walks, "trace_bent", -1.0)
    found = f"at most {straight:.2f} N m from it, re-planned at least {bent:.2f} N m"
    yield answer("straight", words, straight < bent, found, [straight, bent])
    yield _below("z1", _greatest(walks, "trace_z1"), _ON_CYCLE, words)


def _figure_5(rows: Sequence[Row], engine: str, words: Words) -> Iterator[Answer]:
    """Test the claims of section V-C about the estimate update."""
    with_it, without = (_walks_of_figure_5(rows, engine, PAPER_GAIN, update) for update in ("yes", "no"))
    if not all(walk.finished for walk in with_it + without):
        with_it = without = [NO_WALK]

    def less(name: str, column: str, form: str, unit: str) -> Answer:
        """Test whether a number is smaller with the update than without, from every start."""
        both = [(getattr(a, column), getattr(b, column)) for a, b in zip(with_it, without, strict=True)]
        found = "; ".join(f"{number(a, form)}{unit} against {number(b, form)}{unit}" for a, b in both)
        return answer(name, words, all(a < b for a, b in both), found, itertools.chain(*both))

    yield less("off_time", "trace_off_time", ".2f", " s")
    yield _below("ended", _greatest(without, "ended"), _EPSILON, words, " at most")
    yield less("begun", "begun", ".4f", "°")
    slow = _walks_of_figure_5(rows, engine, min(ADAPTATION_GAINS), "yes")
    yield _below("jump", _greatest(slow, "jump"), _EPSILON, words, f" of errors up to {_greatest(slow, 'begun'):.2f}°")


def _figure_6(walks: Walks, words: Words) -> Iterator[Answer]:
    """Test the claims of section V-D, Fig. 6, about re-planning."""
    drawn = [walks.get(zeta, NO_WALK) for zeta in DRAWN_DELAYS]
    for name, form, unit, most in (
        ("travel", ".2f", "°", 1.0),
        ("error", ".4f", "°", 1.0),
        ("z2", ".4f", " rad/s", ZERO),
    ):
        *values, without = (_greatest([walk], f"trace_{name}") for walk in drawn)
        first = " and ".join(f"{number(value, form)}{unit}" for value in values)
        found = f"{first} against {number(without, form)}{unit}"
        yield answer(name, words, max(values) < most * without, found, [*values, without])


def _greatest(walks: Sequence[Row], name: str, sign: float = 1.0) -> float:
    """Greatest number of some walks, times a sign; NaN unless all walks have it and came to their end."""
    values = [sign * getattr(walk, name) if walk.finished else math.nan for walk in walks]
    return math.nan if any(map(math.isnan, values)) else max(values)


def _below(name: str, value: float, bound: float, words: Words, more: str = "") -> Answer:
    """Answer the claim that an angle is below a bound, degrees."""
    return answer(name, words, value < bound, f"{number(value, '.4f')}°{more}", [value])
