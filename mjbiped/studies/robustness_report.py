"""Tables and figures of a robustness study, which put all controllers side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from rich.table import Table

from mjbiped.plotting.panels import draw_survivals, head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import C_MT, GUIDE, drawn, told_apart
from mjbiped.records.summary import table_of
from mjbiped.studies.robustness import Limits, Plan
from mjbiped.studies.robustness_findings import FORGETTING, SOLE, Findings, Robustness
from mjbiped.studies.robustness_walks import ALL, DISTURBANCES, LEVEL_STEPS, rough_from
from mjbiped.utils.files import markdown_table, saved

TABLES = "robustness.md"
"""Name of the file with the tables in a study's folder."""

SOLE_WORDS = "sole: length of the foot that would hold the ankle's centre of pressure for 99 % of the time"
VIOLATING_WORDS = "in brackets on ground that no foot has as well: it pulls, or has friction over 0.8"

_LEAST_SPAN = 0.02  # of the axis of costs of transport

_TIMES = "times that of {} (95 %)"
_RANDOM = ("c_mt there", "sole (m)", "falls", "steps to a fall (95 %)", "λ₂", "misfit", "violating", _TIMES)
"""Headings of the table of a random ground; the last one names the first controller."""

Cells: TypeAlias = dict[str, str]
"""What a table says of a controller, by the headings of its columns."""


def robustness_tables(robustness: Robustness) -> list[Table]:
    """Make each engine's tables, with a row for each controller and a caption that says what the numbers mean."""
    made = []
    for engine in robustness.plan.engines:
        findings = robustness.of(engine)
        for title, cells, meanings in _contents(robustness.plan, findings[0]):
            rows = ((each["controller"], *cells(each).values()) for each in findings)
            table = table_of(rows, "controller", *cells(findings[0]))
            table.title = f"{title}, {engine} engine"
            table.caption = "; ".join((*meanings, scuffing_words(robustness.plan)))
            table.title_justify = table.caption_justify = "left"
            made.append(table)
    return made


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


def _contents(plan: Plan, first: Findings) -> Iterator[tuple[str, Callable[[Findings], Cells], tuple[str, ...]]]:
    """Title, cells and meaning of each table of an engine: level ground, soles, margins, and each random ground."""
    limits, margins = plan.limits, plan.margins
    title = f"Level ground{' and single disturbances' if limits.magnitudes else ''}"
    yield title, partial(_level, limits), (conditions(plan), VIOLATING_WORDS, SOLE_WORDS)
    if limits.magnitudes:
        meaning = f"{SOLE_WORDS}, the greatest of all phases"
        yield "Soles at these limits (m)", partial(_soles, limits.magnitudes), (meaning,)
    if margins.magnitudes:
        words = f"hardest with which {margins.share:.0%} of {plan.seeds} walks make {margins.steps} steps"
        yield f"Margins on {margins.ground}", partial(_greatest, margins.magnitudes), (words, VIOLATING_WORDS)
    for ground in plan.grounds:
        yield (
            ground,
            partial(_random, ground, first),
            (
                f"{plan.seeds} grounds, at most {plan.steps} steps on each",
                f"{SOLE_WORDS}, median of the walks",
                f"falls after the transient of {rough_from(ground):g} m and {FORGETTING} steps",
                "λ₂: probability of the next step, misfit: of its geometric distribution, off the Kaplan-Meier curve",
                "violating: steps on ground that no foot has",
            ),
        )


def scuffing_words(plan: Plan) -> str:
    """Describe the scuffing rule, on which results on ascending steps depend."""
    rule, collide = plan.scuffing, {cell.kind.collides_from_lift_off for cell in plan.controllers.values()}
    if collide == {True}:
        return "the swing foot collides from lift-off on"
    words = f"scuffing rule: the swing foot collides from {rule.reach:g} leg lengths ahead and {rule.delay:g} s on"
    return f"{words}, with knees from lift-off on" if True in collide else words


def conditions(plan: Plan) -> str:
    """Describe the cases in which the greatest disturbances were found."""
    limits, parts = plan.limits, []
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


def _level(limits: Limits, each: Findings) -> Cells:
    """Cells of level ground, the greatest single disturbances, and the area of the basin."""
    level, basin = each["level"], each["basin"]
    cells = {
        "c_mt, level": _digits(level["cost_of_transport"], ".4f"),
        "speed (m/s)": _digits(level["speed_m_per_s"], ".3f"),
        "sole (m)": _digits(level[SOLE], ".2f"),
        **_greatest(limits.magnitudes, each),
    }
    if limits.basin:
        whole = ">= " if basin["share"] == 1.0 else ""
        cells["basin (rad²/s²)"] = f"{whole}{_digits(basin['area_rad2_per_s2'], '.1f')}"
    return cells


def _soles(tests: Iterable[str], each: Findings) -> Cells:
    """Soles at the limits of disturbances."""
    return {test: _digits(each["greatest_survived"][test][SOLE], ".2f") for test in tests}


def _greatest(tried: Mapping[str, Sequence[float]], each: Findings) -> Cells:
    """The greatest disturbances survived; in brackets with walks that violate the contact."""
    cells = {}
    for test, magnitudes in tried.items():
        gentlest, hardest = magnitudes[0], magnitudes[-1]
        found, falls, bounds = each["greatest_survived"][test], ALL[test].falls, []
        for greatest in (found["magnitude"], found["with_contact_violated"]):
            beyond = "" if greatest != hardest else "<= " if falls else ">= "
            bounds.append(f"{'>' if falls else '<'} {gentlest:g}" if greatest is None else f"{beyond}{greatest:g}")
        strict, loose = bounds
        heading = f"{test} ({ALL[test].unit})" if ALL[test].unit else test
        cells[heading] = strict if loose == strict else f"{strict} ({loose})"
    return cells


def _random(ground: str, first: Findings, each: Findings) -> Cells:
    """What was found on a random ground; dashes where nothing was walked, or all fell in the transient."""
    found, cells = each["survival"].get(ground), {}
    if found is not None:
        cells = {
            "c_mt there": _digits(found["cost_of_transport"], ".4f"),
            "sole (m)": _digits(found[SOLE], ".2f"),
            "violating": f"{100.0 * found['share_of_steps_violating_contact']:.2g} %",
            _TIMES: _times(first["survival"].get(ground), found),
        }
        if not math.isnan(found["mean_steps_to_fall"]):
            next_step = found["second_eigenvalue"]
            cells |= {
                "falls": str(found["falls_after_transient"]),
                "steps to a fall (95 %)": _mean(found),
                "λ₂": "1" if next_step == 1.0 else f"{next_step:.5f}",
                "misfit": _digits(found["misfit_of_kaplan_meier"], ".3f"),
            }
    return {heading.format(first["controller"]): cells.get(heading, "-") for heading in _RANDOM}


def _mean(found: Findings) -> str:
    """Mean number of steps to a fall, with its interval."""
    low, high = map(_count, found["interval"])
    mean = found["mean_steps_to_fall"]
    return f"no fall (> {low})" if math.isinf(mean) else f"{_count(mean)} ({low} to {high})"


def _times(first: Findings | None, found: Findings) -> str:
    """Ratio of the number of steps to a fall to the first controller's, with its interval."""
    if first is None or "ratio_to_first" not in found:
        return ""
    if not first["falls_after_transient"] or math.isnan(found["mean_steps_to_fall"]):
        return "-"
    middle, low, high = found["ratio_to_first"]
    return f"> {_count(low)}" if math.isinf(middle) else f"{_count(middle)} ({_count(low)} to {_count(high)})"


def _count(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def draw(robustness: Robustness, folder: Path) -> Iterator[Path]:
    """Draw all figures of a study, one of each kind for each engine.

    Yields:
        Their files.

    Raises:
        RenderError: One cannot be written.
    """
    plan = robustness.plan
    for engine in plan.engines:
        suffix = f"_{engine}" if len(plan.engines) > 1 else ""
        for plot, shown in ((plot_survival, plan.grounds), (plot_limits, plan.limits.magnitudes)):
            if shown:
                path = folder / f"{plot.__name__.removeprefix('plot_')}{suffix}.png"
                plot(robustness, engine, path)
                yield path


def plot_survival(robustness: Robustness, engine: str, path: Path | None = None) -> Figure:
    """Draw, for each random ground, the share of walks that go on against the steps made, with 95 % bands."""
    plan, grounds = robustness.plan, robustness.plan.grounds
    with drawn(path) as figure:
        text = wrapped(f"{plan.seeds} grounds of each kind, {engine} engine; {scuffing_words(plan)}")
        figure.set_figheight(0.6 + 2.6 * len(grounds) + head(figure, text))
        panels = figure.subplots(len(grounds), 1, squeeze=False)[:, 0]
        for number, (axes, ground) in enumerate(zip(panels, grounds, strict=True)):
            curves = {each: robustness.survival(engine, each, ground) for each in plan.controllers}
            draw_survivals(axes, curves, plan.steps)
            titled(axes, chr(ord("a") + number), plain(ground))
        panels[-1].set_xlabel("steps (logarithmic)")
        legend_below(figure, *panels[0].get_legend_handles_labels())
    return figure


def plot_limits(robustness: Robustness, engine: str, path: Path | None = None) -> Figure:
    """Draw the greatest disturbances that each controller survives, each over its cost of transport on level ground."""
    plan, findings, tests = robustness.plan, robustness.of(engine), robustness.plan.limits.magnitudes
    costs = [each["level"]["cost_of_transport"] for each in findings]
    known = [cost for cost in costs if not math.isnan(cost)] or [0.0]
    middle = (min(known) + max(known)) / 2.0
    half = max(0.6 * (max(known) - min(known)), _LEAST_SPAN / 2.0)  # rounding must not look like a difference
    with drawn(path) as figure:
        text = wrapped(f"{engine} engine; {conditions(plan)} (open: all that were tried); {scuffing_words(plan)}")
        columns, rows = min(2, len(tests)), math.ceil(len(tests) / 2)
        figure.set_figheight(0.8 + 2.6 * rows + head(figure, text))
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for axes in panels[len(tests) :]:
            axes.remove()
        for number, (axes, test) in enumerate(zip(panels, tests, strict=False)):
            for place, (each, cost) in enumerate(zip(findings, costs, strict=True)):
                (colour, mark, _), limit = told_apart(place), each["greatest_survived"][test]
                fill = "none" if limit["beyond_what_was_tried"] else colour
                shape = {"color": colour, "markersize": 7, "markerfacecolor": fill}
                axes.plot(cost, limit["magnitude"] or 0.0, mark, label=plain(each["controller"]), **shape)
            titled(axes, chr(ord("a") + number), test)
            axes.set_ylim(bottom=0.0)
            axes.set_ylabel({"m": "height (m)", "deg": "change (deg)"}[DISTURBANCES[test].unit])
            axes.xaxis.set_major_locator(MaxNLocator(3))
            axes.set_xlim(max(0.0, middle - half), middle + half)
            axes.margins(y=0.15)
            axes.grid(color=GUIDE, alpha=0.3)
        for axes in panels[: len(tests)][-columns:]:
            axes.set_xlabel(f"{C_MT} on level ground")
        legend_below(figure, *panels[0].get_legend_handles_labels())
    return figure
