"""Tables of a robustness study that put all controllers side by side, on a terminal and in a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeAlias

from rich.table import Table
from rich.text import Text

from mjbiped.analysis.survival import Survival
from mjbiped.errors import RecordError
from mjbiped.records.tables import bare_table
from mjbiped.robustness.limits import Limit
from mjbiped.robustness.result import FORGETTING, Findings, Robustness
from mjbiped.robustness.walks import LEVEL, LEVEL_STEPS, Trial, rough_from
from mjbiped.utils.files import saved

TABLES = "robustness.md"
"""Name of the file with the tables in a study's folder."""

SOLE_WORDS = "sole: length of the foot that would hold the ankle's centre of pressure for 99 % of the time"
VIOLATING_WORDS = "in brackets on ground that no foot has as well: it pulls, or has friction over 0.8"


Columns: TypeAlias = dict[str, Callable[[Findings], str]]
"""Functions that write a controller's cell, by the column's heading."""


class Sheet(NamedTuple):
    """A table's texts, for a terminal and for Markdown.

    Attributes:
        title: Subject of the table.
        headings: Headings of the columns.
        rows: Cells of each controller.
        caption: What the numbers mean.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str


def sheets(robustness: Robustness) -> Iterator[Sheet]:
    """Make each engine's tables: level walking and single disturbances, soles, margins, and each random ground."""
    plan = robustness.plan
    for engine in plan.engines:
        yield _level(robustness, engine)
        if plan.limits.magnitudes:
            yield _soles(robustness, engine)
        if plan.margins.magnitudes:
            yield _margins(robustness, engine)
        for ground in plan.grounds:
            yield _random(robustness, engine, ground)


def _sheet(title: str, findings: Sequence[Findings], columns: Columns, caption: str) -> Sheet:
    """Make a table with a row for each controller."""
    rows = tuple((each.controller, *(cell(each) for cell in columns.values())) for each in findings)
    return Sheet(title, ("controller", *columns), rows, caption)


def _level(robustness: Robustness, engine: str) -> Sheet:
    plan, findings = robustness.plan, robustness.of(engine)
    columns: Columns = {
        "c_mt, level": lambda each: _digits(each.level_cost, ".4f"),
        "speed (m/s)": lambda each: _digits(each.level.get("speed_m_per_s"), ".3f"),
        "sole (m)": lambda each: _digits(each.soles[LEVEL], ".2f"),
        **_limits(findings, plan.limits),
    }
    if plan.basin:
        columns["basin (rad²/s²)"] = _basin
    title = f"Level ground{' and single disturbances' if plan.limits.magnitudes else ''}, {engine} engine"
    return _sheet(
        title,
        findings,
        columns,
        f"{conditions(robustness)}; {VIOLATING_WORDS}; {SOLE_WORDS}; {scuffing_words(robustness)}",
    )


def _soles(robustness: Robustness, engine: str) -> Sheet:
    return _sheet(
        f"Soles at these limits (m), {engine} engine",
        robustness.of(engine),
        {test: partial(_sole, test=test) for test in robustness.plan.limits.magnitudes},
        f"{SOLE_WORDS}, the greatest of all phases; {scuffing_words(robustness)}",
    )


def _margins(robustness: Robustness, engine: str) -> Sheet:
    plan, findings = robustness.plan, robustness.of(engine)
    return _sheet(
        f"Margins on {plan.margin_ground}, {engine} engine",
        findings,
        _limits(findings, plan.margins),
        f"hardest with which {plan.margins.share:.0%} of {plan.seeds} walks make {plan.margins.steps} steps; "
        f"{VIOLATING_WORDS}; {scuffing_words(robustness)}",
    )


def _random(robustness: Robustness, engine: str, ground: str) -> Sheet:
    plan, findings = robustness.plan, robustness.of(engine)
    survival = {each.controller: _survival(each.settled.get(ground)) for each in findings}
    return _sheet(
        f"{ground}, {engine} engine",
        findings,
        {
            "c_mt there": lambda each: _digits(each.costs.get(ground), ".4f"),
            "sole (m)": lambda each: _digits(each.soles.get(ground), ".2f"),
            "falls": lambda each: survival[each.controller][0],
            "steps to a fall (95 %)": lambda each: survival[each.controller][1],
            "λ₂": lambda each: survival[each.controller][2],
            "misfit": lambda each: survival[each.controller][3],
            "violating": lambda each: _share(each.violating.get(ground, math.nan)),
            f"times that of {findings[0].controller} (95 %)": lambda each: _times(robustness, each, ground),
        },
        f"{plan.seeds} grounds, at most {plan.steps} steps on each; {SOLE_WORDS}, median of the walks; falls after the "
        f"transient of {rough_from(ground):g} m and {FORGETTING} steps; λ₂: probability of the next step, misfit: of "
        "its geometric distribution, off the Kaplan-Meier curve; violating: steps on ground that no foot has; "
        f"{scuffing_words(robustness)}",
    )


def robustness_tables(robustness: Robustness) -> list[Table]:
    """Make the tables for a terminal."""
    tables = []
    for sheet in sheets(robustness):
        table = bare_table(*sheet.headings)
        for row in sheet.rows:
            table.add_row(*map(Text, row))
        table.title, table.caption = sheet.title, sheet.caption
        table.title_justify = table.caption_justify = "left"
        tables.append(table)
    return tables


def write_tables(robustness: Robustness, path: Path) -> Path:
    """Write the tables as Markdown.

    Raises:
        RecordError: The file cannot be written.
    """
    parts = []
    for sheet in sheets(robustness):
        lines = [sheet.headings, ["---"] * len(sheet.headings), *sheet.rows]
        table = "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
        parts.append(f"**{sheet.title}**\n\n{table}\n{sheet.caption}\n")
    with saved(path, RecordError) as unfinished:
        unfinished.write_text("\n".join(parts), encoding="utf-8")
    return path


def scuffing_words(robustness: Robustness) -> str:
    """Describe the scuffing rule, on which results on ascending steps depend."""
    rule, collide = robustness.plan.scuffing, {cell.kind.collides_from_lift_off for cell in robustness.plan.study.cells}
    if collide == {True}:
        return "the swing foot collides from lift-off on"
    words = f"scuffing rule: the swing foot collides from {rule.reach:g} leg lengths ahead and {rule.delay:g} s on"
    return f"{words}, with knees from lift-off on" if True in collide else words


def conditions(robustness: Robustness) -> str:
    """Describe the cases in which the greatest disturbances were found."""
    plan, limits, parts = robustness.plan, robustness.plan.limits, []
    if limits.magnitudes:
        parts.append(f"greatest disturbances that {limits.share:.0%} of {plan.phases} phases of the step survive")
    if plan.basin:
        parts.append(f"basin of {plan.basin}² first rates of the legs")
    if not parts:
        return f"{LEVEL_STEPS} steps on level ground"
    within = "" if limits.torque is None else f", within {limits.torque:g} N m"
    return f"{'; '.join(parts)}{within}"


def _digits(value: float | None, form: str) -> str:
    return "-" if value is None or math.isnan(value) else format(value, form)


def _limits(findings: Sequence[Findings], trial: Trial) -> Columns:
    """Make the columns of the greatest disturbances survived."""
    units = {test: findings[0].limits[test].unit for test in trial.magnitudes}
    return {f"{test} ({unit})" if unit else test: partial(_limit, test=test) for test, unit in units.items()}


def _sole(each: Findings, test: str) -> str:
    return _digits(each.soles[test], ".2f")


def _limit(each: Findings, test: str) -> str:
    strict, loose = _bound(each.limits[test]), _bound(each.limits_violating[test])
    return strict if loose == strict else f"{strict} ({loose})"


def _bound(limit: Limit) -> str:
    if not limit.magnitudes:
        return "-"
    falling = limit.magnitudes[0] > limit.magnitudes[-1]
    if limit.greatest is None:
        return f"{'>' if falling else '<'} {limit.magnitudes[0]:g}"
    beyond = "<= " if falling else ">= "
    return f"{'' if limit.reached else beyond}{limit.greatest:g}"


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{100.0 * value:.2g} %"


def _basin(each: Findings) -> str:
    return f"{'>= ' if each.basin == 1.0 else ''}{_digits(each.basin_area, '.1f')}"


def _count(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _survival(walks: Survival | None) -> tuple[str, ...]:
    """Write the number of falls, the mean number of steps to a fall with its interval, second eigenvalue and misfit."""
    if walks is None or not (walks.falls or any(walks.steps)):
        return ("-",) * 4
    low, high = walks.interval
    if not walks.falls:
        return "0", f"no fall (> {_count(low)})", "1", "-"
    mean = f"{_count(walks.mean)} ({_count(low)} to {_count(high)})"
    return str(walks.falls), mean, f"{walks.eigenvalue:.5f}", f"{walks.misfit:.3f}"


def _times(robustness: Robustness, each: Findings, ground: str) -> str:
    """Write the ratio of the number of steps to a fall to the first controller's, with its interval."""
    first = robustness.of(each.engine)[0]
    if each is first or ground not in each.settled or ground not in first.settled:
        return ""
    if not first.settled[ground].falls or math.isnan(each.settled[ground].mean):
        return "-"
    middle, low, high = robustness.ratios(each.engine, ground)[each.controller]
    return f"> {_count(low)}" if math.isinf(middle) else f"{_count(middle)} ({_count(low)} to {_count(high)})"
