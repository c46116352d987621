"""Tables of a robustness study that put all controllers side by side, on a terminal and in a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

from rich.table import Table
from rich.text import Text

from mjbiped.records.summary import bare_table
from mjbiped.robustness.limits import ALL, DISTURBANCES
from mjbiped.robustness.result import FORGETTING, SOLE, Findings, Robustness
from mjbiped.robustness.walks import LEVEL_STEPS, rough_from
from mjbiped.utils.files import saved
from mjbiped.utils.markdown import markdown_table

TABLES = "robustness.md"
"""Name of the file with the tables in a study's folder."""

SOLE_WORDS = "sole: length of the foot that would hold the ankle's centre of pressure for 99 % of the time"
VIOLATING_WORDS = "in brackets on ground that no foot has as well: it pulls, or has friction over 0.8"


def robustness_tables(robustness: Robustness) -> list[Table]:
    """Make each engine's tables: level walking and single disturbances, soles, margins, and each random ground."""
    plan, limits, margins, tables = robustness.plan, robustness.plan.limits, robustness.plan.margins, []
    for engine in plan.engines:
        tables.append(_level(robustness, engine))
        if limits.magnitudes:
            words = f"{SOLE_WORDS}, the greatest of all phases"
            tables.append(_table(robustness, engine, "Soles at these limits (m)", limits.magnitudes, _soles, words))
        if margins.magnitudes:
            words = f"hardest with which {margins.share:.0%} of {plan.seeds} walks make {margins.steps} steps"
            title, headings = f"Margins on {margins.ground}", _with_units(margins.magnitudes)
            cells = partial(_limits, tried=margins.magnitudes)
            tables.append(_table(robustness, engine, title, headings, cells, words, VIOLATING_WORDS))
        tables += [_random(robustness, engine, ground) for ground in plan.grounds]
    return tables


def texts_of(table: Table) -> tuple[list[str], list[list[str]]]:
    """Return the headings and the rows of a table."""
    columns = [list(map(str, column.cells)) for column in table.columns]
    return [str(column.header) for column in table.columns], [list(row) for row in zip(*columns, strict=True)]


def write_tables(robustness: Robustness, path: Path) -> Path:
    """Write the tables as Markdown.

    Raises:
        RecordError: The file cannot be written.
    """
    parts = (
        f"**{table.title}**\n\n{markdown_table(*texts_of(table))}\n\n{table.caption}\n"
        for table in robustness_tables(robustness)
    )
    with saved(path) as unfinished:
        unfinished.write_text("\n".join(parts), encoding="utf-8")
    return path


def _table(
    robustness: Robustness,
    engine: str,
    title: str,
    headings: Iterable[str],
    cells: Callable[[Findings], Iterable[str]],
    *meanings: str,
) -> Table:
    """Make a table with a row for each controller, and a caption that says what its numbers mean."""
    table = bare_table("controller", *headings)
    for each in robustness.of(engine):
        table.add_row(*map(Text, (each["controller"], *cells(each))))
    table.title, table.caption = f"{title}, {engine} engine", "; ".join((*meanings, scuffing_words(robustness)))
    table.title_justify = table.caption_justify = "left"
    return table


def _level(robustness: Robustness, engine: str) -> Table:
    limits = robustness.plan.limits

    def cells(each: Findings) -> Iterator[str]:
        for name, form in (("cost_of_transport", ".4f"), ("speed_m_per_s", ".3f"), (SOLE, ".2f")):
            yield _digits(each["level"][name], form)
        yield from _limits(each, limits.magnitudes)
        if limits.basin:
            basin = each["basin"]
            yield f"{'>= ' if basin['share'] == 1.0 else ''}{_digits(basin['area_rad2_per_s2'], '.1f')}"

    title = f"Level ground{' and single disturbances' if limits.magnitudes else ''}"
    headings = ["c_mt, level", "speed (m/s)", "sole (m)", *_with_units(limits.magnitudes)]
    headings += ["basin (rad²/s²)"] if limits.basin else []
    return _table(robustness, engine, title, headings, cells, conditions(robustness), VIOLATING_WORDS, SOLE_WORDS)


def _random(robustness: Robustness, engine: str, ground: str) -> Table:
    plan, first = robustness.plan, robustness.of(engine)[0]
    headings = ["c_mt there", "sole (m)", "falls", "steps to a fall (95 %)", "λ₂", "misfit", "violating"]
    return _table(
        robustness,
        engine,
        ground,
        [*headings, f"times that of {first['controller']} (95 %)"],
        lambda each: (*_survival(each, ground), _times(each, first, ground)),
        f"{plan.seeds} grounds, at most {plan.steps} steps on each",
        f"{SOLE_WORDS}, median of the walks",
        f"falls after the transient of {rough_from(ground):g} m and {FORGETTING} steps",
        "λ₂: probability of the next step, misfit: of its geometric distribution, off the Kaplan-Meier curve",
        "violating: steps on ground that no foot has",
    )


def scuffing_words(robustness: Robustness) -> str:
    """Describe the scuffing rule, on which results on ascending steps depend."""
    rule, collide = robustness.plan.scuffing, {cell.kind.collides_from_lift_off for cell in robustness.plan.study.cells}
    if collide == {True}:
        return "the swing foot collides from lift-off on"
    words = f"scuffing rule: the swing foot collides from {rule.reach:g} leg lengths ahead and {rule.delay:g} s on"
    return f"{words}, with knees from lift-off on" if True in collide else words


def conditions(robustness: Robustness) -> str:
    """Describe the cases in which the greatest disturbances were found."""
    limits, parts = robustness.plan.limits, []
    if limits.magnitudes:
        parts.append(f"greatest disturbances that {limits.share:.0%} of {limits.phases} phases of the step survive")
    if limits.basin:
        parts.append(f"basin of {limits.basin}² first rates of the legs")
    if not parts:
        return f"{LEVEL_STEPS} steps on level ground"
    within = "" if limits.torque is None else f", within {limits.torque:g} N m"
    return f"{'; '.join(parts)}{within}"


def _digits(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)


def _with_units(tried: Iterable[str]) -> list[str]:
    """Headings of disturbances."""
    units = {test: ALL[test].unit for test in tried}
    return [f"{test} ({unit})" if unit else test for test, unit in units.items()]


def _soles(each: Findings) -> list[str]:
    """Write the soles at the limits of single disturbances."""
    return [_digits(found[SOLE], ".2f") for test, found in each["greatest_survived"].items() if test in DISTURBANCES]


def _limits(each: Findings, tried: Mapping[str, tuple[float, ...]]) -> Iterator[str]:
    """Write the greatest disturbances survived; in brackets with walks that violate the contact."""
    for test, magnitudes in tried.items():
        found, falls = each["greatest_survived"][test], ALL[test].falls
        strict, loose = (_bound(found[name], magnitudes, falls) for name in ("magnitude", "with_contact_violated"))
        yield strict if loose == strict else f"{strict} ({loose})"


def _bound(greatest: float | None, tried: tuple[float, ...], falls: bool) -> str:
    if greatest is None:
        return f"{'>' if falls else '<'} {tried[0]:g}"
    return f"{'' if greatest != tried[-1] else '<= ' if falls else '>= '}{greatest:g}"


def _count(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _survival(each: Findings, ground: str) -> tuple[str, ...]:
    """Write what was found on a random ground, in the order of the columns; dashes where nothing was walked."""
    found = each["survival"].get(ground)
    if found is None:
        return ("-",) * 7
    falls: tuple[str, ...] = ("-",) * 4
    if not math.isnan(found["mean_steps_to_fall"]):
        low, high = map(_count, found["interval"])
        falls = "0", f"no fall (> {low})", "1", "-"
        if found["falls_after_transient"]:
            mean = f"{_count(found['mean_steps_to_fall'])} ({low} to {high})"
            misfit = f"{found['misfit_of_kaplan_meier']:.3f}"
            falls = str(found["falls_after_transient"]), mean, f"{found['second_eigenvalue']:.5f}", misfit
    violating = f"{100.0 * found['share_of_steps_violating_contact']:.2g} %"
    return _digits(found["cost_of_transport"], ".4f"), _digits(found[SOLE], ".2f"), *falls, violating


def _times(each: Findings, first: Findings, ground: str) -> str:
    """Write the ratio of the number of steps to a fall to the first controller's, with its interval."""
    found = each["survival"].get(ground, {})
    if "ratio_to_first" not in found:
        return ""
    if not first["survival"][ground]["falls_after_transient"] or math.isnan(found["mean_steps_to_fall"]):
        return "-"
    middle, low, high = found["ratio_to_first"]
    return f"> {_count(low)}" if math.isinf(middle) else f"{_count(middle)} ({_count(low)} to {_count(high)})"
