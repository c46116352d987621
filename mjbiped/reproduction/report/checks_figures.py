"""Claims of section V about Table III and Figs. 4 to 6, tested on the grounds that stand for the paper's."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from mjbiped.control.registry import settings_of
from mjbiped.reproduction.grounds import TABLE_3
from mjbiped.reproduction.plan import ADAPTATION_GAINS, DRAWN_DELAYS, PAPER_GAIN, START_ESTIMATES
from mjbiped.reproduction.report.markdown import Answer, answer, delay, number, printed
from mjbiped.reproduction.report.table_3 import walks_of
from mjbiped.reproduction.rows import Row, select
from mjbiped.reproduction.traces import RESOLVED_SLOPE

_ZETAS = [zeta for zeta in TABLE_3 if zeta is not None]
_LEAST = 0.8  # zeta of Table III's lowest c_mt
_REMARKABLE = (0.6, 0.7, 0.8, 0.9)  # V-D
_NEXT_TO_NONE = (0.4, 0.5)  # zeta between whose torques Table III's without re-planning lies
_EPSILON = math.degrees(RESOLVED_SLOPE)
_ON_CYCLE = math.degrees(settings_of("adaptive")["replanning_threshold"])
ZERO = 0.01
"""Greatest ratio of z2 with to without re-planning that counts as reduced to zero; our own bound."""
_SLOW_GAIN = min(ADAPTATION_GAINS)
_FROM = " and ".join(f"{start:+g}°" for start in START_ESTIMATES).replace("-", "−")


def answers(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims about a ground that stands for the one of Table III and Figs. 4 to 6.

    Args:
        rows: Rows of the reproduction.
        ground: "mixed" or "found".
        title: Name of the ground, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    yield from _table_3(rows, ground, title, engine)
    yield from _figure_4(rows, ground, title, engine)
    if ground == "mixed":
        yield from _figure_5(rows, title, engine)
    yield from _figure_6(rows, ground, title, engine)


def _table_3(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims of Table III and section V-D; arguments as in `answers`."""
    walks = walks_of(rows, ground, engine)
    lost = [f"ζ = {delay(zeta)}: {walk.outcome}" for zeta, walk in walks.items() if not walk.finished]
    claim = f"{title} the robot comes to the end with every ζ, and without re-planning"
    yield Answer(claim, "Table III", not lost if walks else None, "; ".join(lost) or f"{len(walks)} walks")
    ended = {zeta: walk for zeta, walk in walks.items() if walk.finished}
    zetas = [zeta for zeta in _ZETAS if zeta in ended]
    of = "" if len(zetas) == len(_ZETAS) else f"the {len(zetas)} of {len(_ZETAS)} ζ that came to their end"
    torque = {zeta: ended[zeta].torque if zeta in ended else math.nan for zeta in TABLE_3}
    cost = {zeta: ended[zeta].cost["absolute", None] if zeta in ended else math.nan for zeta in TABLE_3}
    yield from _torques(torque, zetas, title, of)
    least = min(zetas, key=cost.__getitem__, default=_LEAST)
    yield answer(
        f"{title} no ζ has a lower c_mt than {_LEAST:g}",
        "Table III",
        printed(cost[_LEAST]) <= printed(cost[least]) if _LEAST in zetas and len(zetas) > 1 else None,
        f"{cost[_LEAST]:.4f}, lowest {cost[least]:.4f} at ζ = {least:g}",
        of,
    )
    high = max(_REMARKABLE, key=cost.__getitem__)
    others = [zeta for zeta in zetas if zeta not in _REMARKABLE]
    low = min(others, key=cost.__getitem__, default=_LEAST)
    yield answer(
        f"{title} each ζ from {_REMARKABLE[0]:g} to {_REMARKABLE[-1]:g} has a lower c_mt than every other ζ",
        "V-D",
        printed(cost[high]) < printed(cost[low]) if others and {*_REMARKABLE} <= {*zetas} else None,
        f"at most {cost[high]:.4f} (ζ = {high:g}); the others at least {cost[low]:.4f} (ζ = {low:g})",
        of,
    )
    yield answer(
        f"{title} c_mt without re-planning is lower than with any ζ",
        "V-D",
        printed(cost[None]) < printed(cost[least]) if None in ended and zetas else None,
        f"{cost[None]:.4f}, lowest with it {cost[least]:.4f} at ζ = {least:g}",
        of,
    )


def _torques(torque: Mapping[float | None, float], zetas: Sequence[float], title: str, of: str) -> Iterator[Answer]:
    """Test the claims about greatest torques, which are NaN for walks that did not come to their end."""
    falls = all(torque[a] > torque[b] for a, b in pairwise(zetas)) if len(zetas) > 1 else None
    found = (
        f"{torque[zetas[0]]:.5g} N m at ζ = {zetas[0]:g} to {torque[zetas[-1]]:.5g} at {zetas[-1]:g}" if zetas else ""
    )
    yield answer(f"{title} a smaller ζ takes a higher greatest torque", "V-D", falls, found, of)
    high, low = _NEXT_TO_NONE
    between = (("without", None), (f"ζ = {high:g}:", high), (f"ζ = {low:g}:", low))
    known = not any(math.isnan(torque[zeta]) for _, zeta in between)
    yield Answer(
        f"{title} the greatest torque without re-planning lies between those of ζ = {high:g} and {low:g}",
        "Table III",
        torque[low] < torque[None] < torque[high] if known else None,
        ", ".join(f"{name} {number(torque[zeta], '.4g')}" for name, zeta in between) + " N m",
    )


def _walks_of_figure_5(rows: Sequence[Row], engine: str, gain: float, update: str) -> list[Row]:
    """Walks with one gamma, with or without the update (27), by `plan.START_ESTIMATES`; none unless all exist."""
    found = select(rows, part="figure 5", engine=engine, adaptation_gain=gain, update=update)
    by_start = {row.start_estimate: row for row in found}
    return [by_start[start] for start in START_ESTIMATES] if by_start.keys() >= set(START_ESTIMATES) else []


def _figure_4(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims of section V-B, Fig. 4(b) to (d); arguments as in `answers`."""
    if ground == "mixed":
        walks = _walks_of_figure_5(rows, engine, PAPER_GAIN, "yes")
        wrong = f"from a start estimate of {_FROM}"
    else:
        walks = [walk for zeta, walk in walks_of(rows, ground, engine).items() if zeta == DRAWN_DELAYS[1]]
        wrong = "from a start estimate of 0°"

    def within(claim: str, panel: str, name: str, bound: float) -> Answer:
        """Test whether the greatest of some angles is below a bound, degrees."""
        value = _greatest(walks, name)
        source, holds = f"V-B, Fig. 4({panel})", _known(value, value < bound)
        return answer(f"{title}, {wrong}, {claim}", source, holds, f"{number(value, '.4f')}°")

    claim = f"the slope estimate is within ε = {_EPSILON:.2f}° of the truth before the ground first changes"
    yield within(claim, "b", "settled", _EPSILON)
    yield within("it stays within ε from then on", "b", "later", _EPSILON)
    straight, bent = _greatest(walks, "straight"), -_greatest(walks, "bent", -1.0)
    yield answer(
        f"{title}, the torques of every step that follows the imitated gait are nearer to a straight line than those "
        "of any re-planned step",
        "V-B, Fig. 4(c)",
        _known(straight + bent, straight < bent),
        f"at most {straight:.2f} N m from it, re-planned at least {bent:.2f} N m",
    )
    claim = f"both legs stay within {_ON_CYCLE:.2f}° of the reference, re-planned or not"
    yield within(claim, "d", "z1", _ON_CYCLE)


def _figure_5(rows: Sequence[Row], title: str, engine: str) -> Iterator[Answer]:
    """Test the claims of section V-C about the estimate update; arguments as in `answers`."""
    with_it, without = (_walks_of_figure_5(rows, engine, PAPER_GAIN, update) for update in ("yes", "no"))
    if not all(walk.finished for walk in with_it + without):
        with_it = without = []
    ground = f"{title}, from a start estimate of {_FROM}"

    def less(claim: str, name: str, form: str, unit: str) -> Answer:
        """Test whether a number is smaller with the update than without, from every start."""
        both = [(_value(a, name), _value(b, name)) for a, b in zip(with_it, without, strict=bool(with_it and without))]
        found = "; ".join(f"{number(a, form)}{unit} against {number(b, form)}{unit}" for a, b in both)
        return answer(f"{ground}: {claim}", "V-C, Fig. 5", all(a < b for a, b in both) if both else None, found)

    claim = "with the update (27) the estimate is wrong by more than ε for a shorter time than without"
    yield less(claim, "off_time", ".2f", " s")
    ended = _greatest(without if with_it else [], "ended")
    claim = f"{ground}: without the update the adaptive law (17) brings it within ε by the end of every step"
    yield answer(claim, "V-C, Fig. 5", _known(ended, ended < _EPSILON), f"{number(ended, '.4f')}° at most")
    claim = "with the update the greatest error of the estimate after a touchdown is smaller than without"
    yield less(claim, "begun", ".4f", "°")
    slow = _walks_of_figure_5(rows, engine, _SLOW_GAIN, "yes")
    jump, error = _greatest(slow, "jump"), _greatest(slow, "begun")
    yield answer(
        f"{ground}, γ = {_SLOW_GAIN:g}: the update makes no wrong estimate right, that is left to (17): it changes the "
        "error at no touchdown by more than ε",
        "V-C, Fig. 5",
        _known(jump, jump < _EPSILON),
        f"{number(jump, '.4f')}° of errors up to {error:.2f}°",
    )


def _value(walk: Row, name: str) -> float:
    return float(getattr(walk.traces if hasattr(walk.traces, name) else walk, name))


def _greatest(walks: Sequence[Row], name: str, sign: float = 1.0) -> float:
    """Greatest number of some walks, times a sign; NaN unless all walks have it and came to their end."""
    values = [sign * _value(walk, name) if walk.finished else math.nan for walk in walks]
    return max(values) if values and not any(map(math.isnan, values)) else math.nan


def _known(value: float, holds: bool) -> bool | None:
    """Return whether a claim about a number holds; None for NaN."""
    return None if math.isnan(value) else holds


def _figure_6(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Test the claims of section V-D, Fig. 6, about re-planning; arguments as in `answers`."""
    walks = walks_of(rows, ground, engine)
    drawn = [walks[zeta] for zeta in DRAWN_DELAYS if zeta in walks and walks[zeta].finished]
    planned = " and ".join(f"ζ = {zeta:g}" for zeta in DRAWN_DELAYS if zeta is not None)
    for claim, name, form, unit, most in (
        ("the slope estimate is smoother, its error moves less up and down than without", "travel", ".2f", "°", 1.0),
        ("the slope estimate is more accurate, its root mean square error is smaller than without",
         "error", ".4f", "°", 1.0),
        (f"z₂ of (9) is reduced to zero, at its greatest to less than {100 * ZERO:g} % of that without",
         "z2", ".4f", " rad/s", ZERO),
    ):  # fmt: skip
        values = [_value(walk, name) for walk in drawn]
        message, holds = "", None
        if len(drawn) == len(DRAWN_DELAYS) and not any(map(math.isnan, values)):
            holds = max(values[:-1]) < most * values[-1]
            first = " and ".join(f"{number(value, form)}{unit}" for value in values[:-1])
            message = f"{first} against {number(values[-1], form)}{unit}"
        yield Answer(f"{title}, with re-planning ({planned}) {claim}", "V-D, Fig. 6", holds, message)
