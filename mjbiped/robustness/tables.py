"""The findings of a robustness study as tables that put all controllers side by side."""

from __future__ import annotations

import math

from rich.table import Table

from mjbiped.analysis.survival import Survival
from mjbiped.records.tables import bare_table
from mjbiped.robustness.result import Findings, Robustness


def robustness_tables(robustness: Robustness) -> list[Table]:
    """One table an engine: a column for each controller."""
    return [_table(robustness, engine) for engine in robustness.plan.engines]


def scuffing_words(robustness: Robustness) -> str:
    """The scuffing rule in words: results on ascending steps depend on it."""
    rule = robustness.plan.scuffing
    return (
        f"scuffing rule: swing foot collides from {rule.reach:g} leg lengths ahead on, {rule.delay:g} s after lift-off"
    )


def conditions(robustness: Robustness) -> str:
    """What the numbers are of, in words."""
    plan = robustness.plan
    within = "" if plan.torque is None else f" within {plan.torque:g} N m"
    return (
        f"greatest that {plan.share:.0%} of {plan.phases} phases of the step survive{within}; {plan.seeds} random "
        f"grounds of each kind, at most {plan.steps} steps on each"
    )


def _table(robustness: Robustness, engine: str) -> Table:
    plan, findings = robustness.plan, robustness.of(engine)
    table = bare_table(f"engine {engine}", *(each.controller for each in findings), "unit")
    table.add_row("cost of transport, level", *(_digits(each.level_cost, ".4f") for each in findings), "")
    table.add_row("speed, level", *(_digits(each.level.get("speed_m_per_s"), ".3f") for each in findings), "m/s")
    for test in plan.disturbances:
        table.add_row(f"greatest {test}", *(_limit(each, test) for each in findings), findings[0].limits[test].unit)
    for ground in plan.grounds:
        table.add_row(ground.replace(",", ", "))
        table.add_row("  mean steps to a fall", *(_mean(each.survival.get(ground)) for each in findings), "steps")
        table.add_row("  95 % interval", *(_interval(each.survival.get(ground)) for each in findings), "steps")
        if len(findings) > 1 and all(ground in each.survival for each in findings):
            ratios = robustness.ratios(engine, ground)
            table.add_row(
                f"  times that of {findings[0].controller}",
                "",
                *(_ratio(ratios[each.controller]) for each in findings[1:]),
                "",
            )
    table.caption = f"{conditions(robustness)}; {scuffing_words(robustness)}"
    return table


def _digits(value: float | None, form: str) -> str:
    return "-" if value is None or math.isnan(value) else format(value, form)


def _limit(each: Findings, test: str) -> str:
    limit = each.limits[test]
    if not limit.magnitudes:
        return "-"
    return f"{'' if limit.reached else '>= '}{limit.greatest:g}"


def _count(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _mean(walks: Survival | None) -> str:
    if walks is None:
        return "-"
    return _count(walks.mean) if walks.falls else "no fall"


def _interval(walks: Survival | None) -> str:
    return "-" if walks is None else " to ".join(map(_count, walks.interval))


def _ratio(values: tuple[float, float, float]) -> str:
    middle, low, high = values
    return f">= {low:.3g}" if math.isinf(middle) else f"{middle:.3g} ({low:.3g} to {_count(high)})"
