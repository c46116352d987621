"""Walks and gaits in words and numbers, for people and for machines."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table
from rich.text import Text

from mjbiped.analysis.divergence import COLUMNS, DISPLAYED
from mjbiped.gaits.kneed import KneedGait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.records.measures import MEASURES, in_words
from mjbiped.records.tables import bare_table, table_of

if TYPE_CHECKING:
    from mjbiped.analysis.compare import Comparison
    from mjbiped.analysis.stability import Stability
    from mjbiped.reproduction.report.checks import Check


def comparison_tables(comparison: Comparison) -> tuple[Table, Table]:
    """Two engines' measures side by side, and the largest differences at a touchdown beside their limits."""
    measures = comparison.measures()
    sides = bare_table("", "MuJoCo", "hybrid", "difference", "%", "unit")
    outcome = measures["outcome"]
    sides.add_row("outcome", outcome["mujoco"], outcome["hybrid"])
    for label, key, factor, form, unit in MEASURES:
        row = measures[key]
        difference = in_words(row["difference"], factor, "+.3g")
        percent = in_words(row["difference_percent"], 1, "+.2f")
        cells = (in_words(row[engine], factor, form) for engine in ("mujoco", "hybrid"))
        sides.add_row(label, *cells, difference, percent, unit)
    steps = bare_table("largest difference at a touchdown", "", "at", "limit", "unit")
    table = comparison.touchdowns
    for name, column in COLUMNS.items():
        sizes = abs(table[name])
        if not len(sizes) or np.isnan(sizes).all():
            continue
        factor, unit = DISPLAYED[column.unit]
        k = int(np.nanargmax(sizes))
        limit = f"{factor * table[f'limit_{name}'][k]:.3g}"
        steps.add_row(column.meaning, f"{factor * table[name][k]:+.3g}", str(k + 1), limit, unit)
    return sides, steps


def gait_summary(gait: PassiveGait) -> dict[str, Any]:
    """What a gait is, in plain JSON types; states are q1, q2 (rad) and dq1, dq2 (rad/s)."""
    return {
        "slope_deg": math.degrees(gait.slope),
        "state_after_impact": gait.start.tolist(),
        "state_before_impact": gait.end.tolist(),
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "speed_m_per_s": gait.speed,
        "energy_J": gait.energy,
        **_stability_of(gait),
    }


def gait_table(summary: Mapping[str, Any]) -> Table:
    """A gait's summary, as `gait_summary` makes it, as a table."""
    rows = [("slope", f"{summary['slope_deg']:.4g}", "deg")]
    for label, key in (("after", "state_after_impact"), ("before", "state_before_impact")):
        q1, q2, dq1, dq2 = summary[key]
        rows.append((f"stance, swing angle {label} impact", f"{q1:.8f}, {q2:.8f}", "rad"))
        rows.append((f"stance, swing rate {label} impact", f"{dq1:.8f}, {dq2:.8f}", "rad/s"))
    rows += [
        ("period", f"{summary['period_s']:.8f}", "s"),
        ("step length", f"{summary['step_length_m']:.6f}", "m"),
        ("speed", f"{summary['speed_m_per_s']:.6f}", "m/s"),
        ("energy about the stance foot", f"{summary['energy_J']:.5f}", "J"),
    ]
    rows += _stability_rows(summary)
    return table_of(rows)


def kneed_gait_summary(gait: KneedGait) -> dict[str, Any]:
    """What a gait with knees is, in plain JSON types; states are of stance leg, swing thigh, shank, rad and rad/s."""
    return {
        "slope_deg": math.degrees(gait.slope),
        "state_after_heel_strike": gait.start.tolist(),
        "rates_before_knee_strike": gait.knee_rates.tolist(),
        "state_before_heel_strike": gait.end.tolist(),
        "knee_strike_s": gait.knee_strike,
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "speed_m_per_s": gait.speed,
        "clearance_m": gait.clearance,
        "greatest_flexion_deg": math.degrees(gait.greatest_flexion),
        **_stability_of(gait),
    }


def kneed_gait_table(summary: Mapping[str, Any]) -> Table:
    """A kneed gait's summary, as `kneed_gait_summary` makes it, as a table."""
    after, before = summary["state_after_heel_strike"], summary["state_before_heel_strike"]
    knee = ", ".join(f"{rate:.6f}" for rate in summary["rates_before_knee_strike"])
    rows = [
        ("slope", f"{summary['slope_deg']:.4g}", "deg"),
        ("stance, swing angle after heel strike", f"{after[0]:.8f}, {after[1]:.8f}", "rad"),
        ("stance, swing rate after heel strike", f"{after[3]:.8f}, {after[4]:.8f}", "rad/s"),
        ("rates of all three before knee strike", knee, "rad/s"),
        ("stance, swing rate before heel strike", f"{before[3]:.8f}, {before[4]:.8f}", "rad/s"),
        ("knee strike", f"{summary['knee_strike_s']:.8f}", "s"),
        ("period", f"{summary['period_s']:.8f}", "s"),
        ("step length", f"{summary['step_length_m']:.6f}", "m"),
        ("speed", f"{summary['speed_m_per_s']:.6f}", "m/s"),
        ("clearance of the swing foot", f"{100 * summary['clearance_m']:.3f}", "cm"),
        ("greatest flexion of the knee", f"{summary['greatest_flexion_deg']:.3f}", "deg"),
    ]
    return table_of([*rows, *_stability_rows(summary)])


def _stability_of(gait: PassiveGait | KneedGait) -> dict[str, Any]:
    """The part of a gait's summary that tells of its stability."""
    return {
        "multipliers": [
            {"real": value.real, "imaginary": value.imag, "modulus": abs(value)} for value in gait.multipliers.tolist()
        ],
        "stable": gait.stable,
    }


def _stability_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """The same part of its table."""
    for value in summary["multipliers"]:
        number = f"{value['real']:.5f}" + (f" {value['imaginary']:+.5f} i" if value["imaginary"] else "")
        yield "Floquet multiplier, modulus", f"{number}, {value['modulus']:.5f}", ""
    yield "stable", "yes" if summary["stable"] else "no", ""


def stability_summary(found: Stability) -> dict[str, Any]:
    """Theorem 1 along a walk in plain JSON types; what a walk of one step does not have is None."""
    norms = np.linalg.norm(found.end, axis=1)
    compared = found.ratio[np.isfinite(found.ratio)]
    left = found.condition[1:]
    within = np.diff(found.step) == 0
    return {
        "steps": found.steps,
        "excitation_smallest_eigenvalue": float(found.excitation[:, 0].min()),
        "excitation_largest_eigenvalue": float(found.excitation[:, 1].max()),
        "excitation_weak_direction_from_cosine_deg": math.degrees(float(found.weak_direction.max())),
        "transition_norm_smallest": float(found.contraction.min()),
        "transition_norm_largest": float(found.contraction.max()),
        "condition_24_smallest": float(left.min()) if left.size else None,
        "condition_24_smallest_for_any_constants": float(found.condition_floor.min()),
        "condition_24_holds_steps": int((left < 1.0).sum()),
        "errors_26_compared_steps": int(compared.size),
        "errors_26_holds_steps": int((compared < 1.0).sum()),
        "lyapunov_largest_rise_within_a_step": max(0.0, float(np.diff(found.lyapunov)[within].max())),
        "lyapunov_largest_jump_at_a_touchdown": float(found.lyapunov_jump[1:].max()) if found.steps > 1 else None,
        "lyapunov_balance_largest": float(np.abs(found.balance).max()),
        "estimate_error_largest_rise_within_a_step": float(found.estimate_rise.max()),
        "error_before_last_touchdown": float(norms[-1]),
        "residual_largest": float(found.residual.max()),
    }


def stability_table(summary: Mapping[str, Any]) -> Table:
    """What `stability_summary` says, as a table."""
    shown = {key: in_words(value, 1, ".4g") for key, value in summary.items()}
    return table_of(
        (label, form.format_map(shown), unit)
        for label, form, unit in (
            ("whole steps", "{steps}", ""),
            ("excitation, smallest eigenvalue of ∫WW'", "{excitation_smallest_eigenvalue}", "1/s³"),
            ("excitation, largest eigenvalue", "{excitation_largest_eigenvalue}", "1/s³"),
            ("its weak direction, from the cosine's", "{excitation_weak_direction_from_cosine_deg}", "deg"),
            (
                "norm of the transition matrix of a step (23)",
                "{transition_norm_smallest} to {transition_norm_largest}",
                "",
            ),
            ("left side of (24), smallest", "{condition_24_smallest}", ""),
            ("left side of (24), smallest of any constants", "{condition_24_smallest_for_any_constants}", ""),
            ("steps where (24) holds", "{condition_24_holds_steps}", ""),
            ("steps where ‖η‖ fell (26)", "{errors_26_holds_steps} of {errors_26_compared_steps}", ""),
            ("V_a, largest rise within a step", "{lyapunov_largest_rise_within_a_step}", ""),
            ("V_a, largest jump at a touchdown", "{lyapunov_largest_jump_at_a_touchdown}", ""),
            ("V_a against (16) with (17), worst", "{lyapunov_balance_largest}", ""),
            ("estimate's error, largest rise within a step", "{estimate_error_largest_rise_within_a_step}", ""),
            ("‖η‖ before the last touchdown", "{error_before_last_touchdown}", ""),
            ("walk against (22), worst of a step", "{residual_largest}", ""),
        )
    )


def bifurcation_told(summary: Mapping[str, Any]) -> Iterator[Table | str]:
    """What the command `bifurcation` says of its summary: the onsets, and where the robot is lost."""
    table = bare_table("period", "begins at", "distance from the last", "ratio of distances", numbers=True)
    onsets, ratios = summary["onsets_deg"], ["", "", *(f"{ratio:.4f}" for ratio in summary["ratios"])]
    for number, onset in enumerate(onsets):
        distance = f"{onset - onsets[number - 1]:.5f}°" if number else ""
        table.add_row(str(2 ** (number + 1)), f"{onset:.5f}°", distance, ratios[number])
    yield table
    if summary["cascade_end"]:
        yield summary["cascade_end"]
    if len(onsets) > 1:
        yield f"aperiodic beyond {summary['accumulation_deg']:.4f}°, if Feigenbaum's ratio holds"
    if math.isfinite(summary["lost_deg"]):
        yield f"falls on {summary['lost_deg']:.3f}° and steeper"
    yield f"{summary['slopes'] * summary['steps']} steps in {summary['diagram_s']:.1f} s"


def checks_table(checks: Iterable[Check]) -> Table:
    """The paper's claims and whether they hold."""
    table = bare_table("claim", "settings", "engine", "found", "holds")
    for check in checks:
        answer = check.answer
        holds = "-" if answer.holds is None else "yes" if answer.holds else "no"
        asked = f"{holds}, of {answer.of}" if answer.of else holds
        table.add_row(*(Text(cell) for cell in (answer.claim, check.group, check.engine, answer.found, asked)))
    return table


def sweep_tables(summary: Mapping[str, Any]) -> list[Table]:
    """What `mjbiped.sweeps.bins.summarised` says of a study: outcomes, quantiles, and errors where there are any."""
    outcomes = bare_table("outcome", "walks", "%")
    for outcome, count in summary["verdicts"].items():
        outcomes.add_row(outcome, str(count), f"{100.0 * count / summary['walks']:.1f}")
    quantiles = bare_table("of the finished walks", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit")
    for label, key, factor, form, unit in MEASURES:
        values = summary["finished"].get(key)
        if values is not None:
            quantiles.add_row(label, *(in_words(value, factor, form) for value in values), unit)
    tables = [outcomes] + ([quantiles] if quantiles.rows else [])
    if summary["errors"]:
        errors = bare_table("error", "walks", "first cell")
        for each in summary["errors"]:
            errors.add_row(Text(each["error"]), str(each["walks"]), str(each["first_cell"]))
        tables.append(errors)
    return tables


def as_json(values: Mapping[str, Any]) -> str:
    """Values as a JSON object; numbers that JSON does not know (infinite, not a number) become null."""
    return json.dumps(_plain(values), indent=2, allow_nan=False, ensure_ascii=True)


def _plain(value: Any) -> Any:
    """A value that JSON can hold."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
