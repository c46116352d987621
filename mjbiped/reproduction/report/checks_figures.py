"""What section V says of Figs. 4 to 6, asked of our walks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from mjbiped.control.registry import settings_of
from mjbiped.reproduction.plan import ADAPTATION_GAINS, DRAWN_DELAYS, PAPER_GAIN, START_ESTIMATES
from mjbiped.reproduction.report.answers import Answer
from mjbiped.reproduction.report.markdown import number
from mjbiped.reproduction.report.table_3 import walks_of
from mjbiped.reproduction.rows import Row
from mjbiped.reproduction.traces import RESOLVED_SLOPE

_EPSILON = math.degrees(RESOLVED_SLOPE)
_ON_CYCLE = math.degrees(settings_of("adaptive")["replanning_threshold"])
ZERO = 0.01
"""Share of what z2 is without re-planning up to which it counts as reduced to zero: our bound."""
_SLOW_GAIN = min(ADAPTATION_GAINS)
_FROM = " and ".join(f"{start:+g}°" for start in START_ESTIMATES).replace("-", "−")


def walks_of_figure_5(rows: Sequence[Row], engine: str, gain: float, update: str) -> list[Row]:
    """The walks with one gamma, with or without the update (27), by `plan.START_ESTIMATES`; none unless all are."""
    by_start = {
        row.start_estimate: row
        for row in rows
        if (row.part, row.engine, row.adaptation_gain, row.update) == ("figure 5", engine, gain, update)
    }
    return [by_start[start] for start in START_ESTIMATES] if by_start.keys() >= set(START_ESTIMATES) else []


def figure_4(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Section V-B of Fig. 4(b) to (d).

    Args:
        rows: Of the reproduction.
        ground: "mixed" or "found".
        title: Where that is, to begin a sentence with.
        engine: "hybrid" or "mujoco".
    """
    if ground == "mixed":
        walks = walks_of_figure_5(rows, engine, PAPER_GAIN, "yes")
        wrong = f"from a start estimate of {_FROM}"
    else:
        walks = [walk for zeta, walk in walks_of(rows, ground, engine).items() if zeta == DRAWN_DELAYS[1]]
        wrong = "from a start estimate of 0°"
    if not walks or not all(walk.finished for walk in walks):
        walks = []

    def asked(claim: str, panel: str, name: str, bound: float) -> Answer:
        """Whether the greatest of some angles is below a bound, degrees."""
        values = [_value(walk, name) for walk in walks]
        known = bool(values) and not any(map(math.isnan, values))
        found = f"{number(max(values), '.4f')}°" if known else ""
        holds = max(values) < bound if known else None
        return Answer(f"{title}, {wrong}, {claim}", f"V-B, Fig. 4({panel})", holds, found)

    claim = f"the slope estimate is within ε = {_EPSILON:.2f}° of the truth before the ground first changes"
    yield asked(claim, "b", "settled", _EPSILON)
    yield asked("it stays within ε from then on", "b", "later", _EPSILON)
    straight, bent = ([getattr(walk.traces, name) for walk in walks] for name in ("straight", "bent"))
    known = bool(walks) and not any(map(math.isnan, straight + bent))
    yield Answer(
        f"{title}, the torques of every step that follows the imitated gait are nearer to a straight line than those "
        "of any re-planned step",
        "V-B, Fig. 4(c)",
        max(straight) < min(bent) if known else None,
        f"at most {max(straight):.2f} N m from it, re-planned at least {min(bent):.2f} N m" if known else "",
    )
    claim = f"both legs stay within {_ON_CYCLE:.2f}° of the reference, re-planned or not"
    yield asked(claim, "d", "z1", _ON_CYCLE)


def figure_5(rows: Sequence[Row], title: str, engine: str) -> Iterator[Answer]:
    """Section V-C: the estimate update; arguments as in `figure_4`."""
    with_it, without = (walks_of_figure_5(rows, engine, PAPER_GAIN, update) for update in ("yes", "no"))
    slow = walks_of_figure_5(rows, engine, _SLOW_GAIN, "yes")
    there = bool(with_it and without) and all(walk.finished for walk in with_it + without)
    ground = f"{title}, from a start estimate of {_FROM}"

    def pairs(name: str, form: str, unit: str) -> tuple[bool | None, str]:
        """Whether a number is smaller with the update than without, from every start."""
        if not there:
            return None, ""
        both = [(_value(here, name), _value(other, name)) for here, other in zip(with_it, without, strict=True)]
        message = "; ".join(f"{number(a, form)}{unit} against {number(b, form)}{unit}" for a, b in both)
        return all(a < b for a, b in both), message

    holds, found = pairs("off_time", ".2f", " s")
    claim = f"{ground}: with the update (27) the estimate is wrong by more than ε for a shorter time than without"
    yield Answer(claim, "V-C, Fig. 5", holds, found)
    claim = f"{ground}: without the update the adaptive law (17) brings it within ε by the end of every step"
    ended = [walk.ended for walk in without]
    found = f"{number(max(ended), '.4f')}° at most" if there else ""
    yield Answer(claim, "V-C, Fig. 5", max(ended) < _EPSILON if there else None, found)
    holds, found = pairs("begun", ".4f", "°")
    claim = f"{ground}: with the update the greatest error of the estimate after a touchdown is smaller than without"
    yield Answer(claim, "V-C, Fig. 5", holds, found)
    claim = (
        f"{ground}, γ = {_SLOW_GAIN:g}: the update makes no wrong estimate right, that is left to (17): it changes the "
        "error at no touchdown by more than ε"
    )
    if slow and all(walk.finished for walk in slow):
        jump, error = max(walk.jump for walk in slow), max(walk.begun for walk in slow)
        yield Answer(claim, "V-C, Fig. 5", jump < _EPSILON, f"{number(jump, '.4f')}° of errors up to {error:.2f}°")
    else:
        yield Answer(claim, "V-C, Fig. 5", None)


def _value(walk: Row, name: str) -> float:
    return float(getattr(walk.traces if hasattr(walk.traces, name) else walk, name))


def figure_6(rows: Sequence[Row], ground: str, title: str, engine: str) -> Iterator[Answer]:
    """Section V-D of Fig. 6: the estimate with re-planning and without it; arguments as in `figure_4`."""
    walks = walks_of(rows, ground, engine)
    drawn = [walks.get(zeta) for zeta in DRAWN_DELAYS]
    planned = " and ".join(f"ζ = {zeta:g}" for zeta in DRAWN_DELAYS if zeta is not None)
    for claim, name, form, unit, most in (
        ("the slope estimate is smoother, its error moves less up and down than without", "travel", ".2f", "°", 1.0),
        ("the slope estimate is more accurate, its root mean square error is smaller than without",
         "error", ".4f", "°", 1.0),
        (f"z₂ of (9) is reduced to zero, at its greatest to less than {100 * ZERO:g} % of that without",
         "z2", ".4f", " rad/s", ZERO),
    ):  # fmt: skip
        there = [walk for walk in drawn if walk is not None and walk.finished]
        values = [_value(walk, name) for walk in there]
        message, holds = "", None
        if len(there) == len(drawn) and not any(map(math.isnan, values)):
            holds = max(values[:-1]) < most * values[-1]
            first = " and ".join(f"{number(value, form)}{unit}" for value in values[:-1])
            message = f"{first} against {number(values[-1], form)}{unit}"
        yield Answer(f"{title}, with re-planning ({planned}) {claim}", "V-D, Fig. 6", holds, message)
