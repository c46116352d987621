"""Results of commands as tables and as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from mjbiped.gaits.kneed import KneedGait
from mjbiped.gaits.optimised import OptimisedGait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.records.measure_table import MEASURES, in_words
from mjbiped.records.tables import bare_table, table_of

if TYPE_CHECKING:
    from mjbiped.analysis.compare import Comparison
    from mjbiped.analysis.stability import Stability
    from mjbiped.reproduction.report.answers import Answer


def comparison_tables(comparison: Comparison) -> tuple[Table, Table]:
    """Return both engines' measures side by side, and their largest differences at a touchdown with the limits."""
    from mjbiped.analysis.divergence import COLUMNS, DISPLAYED

    measures = comparison.measures()
    sides = bare_table("", "MuJoCo", "hybrid", "difference", "%", "unit")
    outcome = measures["outcome"]
    sides.add_row("outcome", outcome["mujoco"], outcome["hybrid"])
    for label, key, factor, form, unit, *_ in MEASURES:
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


Told = tuple[dict[str, Any], list[RenderableType]]
"""Results in plain JSON types, and the tables and sentences that say the same."""

Line = tuple[str, str, str]
"""A line of a table: label, value as a format string over the results, unit."""

_CYCLE: tuple[Line, ...] = (
    ("period", "{period_s:.8f}", "s"),
    ("step length", "{step_length_m:.6f}", "m"),
    ("speed", "{speed_m_per_s:.6f}", "m/s"),
)

_THEOREM: tuple[Line, ...] = (
    ("whole steps", "{steps}", ""),
    ("excitation, smallest eigenvalue of ∫WW'", "{excitation_smallest_eigenvalue}", "1/s³"),
    ("excitation, largest eigenvalue", "{excitation_largest_eigenvalue}", "1/s³"),
    ("its weak direction, from the cosine's", "{excitation_weak_direction_from_cosine_deg}", "deg"),
    ("norm of the transition matrix of a step (23)", "{transition_norm_smallest} to {transition_norm_largest}", ""),
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


def gait_told(gait: PassiveGait) -> Told:
    """A passive gait without knees; states are the robot's angles (rad), then their rates (rad/s)."""
    angles = gait.robot.angles
    summary = {
        "slope_deg": math.degrees(gait.slope),
        "state_after_impact": gait.start.tolist(),
        "state_before_impact": gait.end.tolist(),
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "speed_m_per_s": gait.speed,
        "energy_J": gait.energy,
        **_stability_of(gait),
    }
    lines = (
        ("slope", "{slope_deg:.4g}", "deg"),
        *(
            (f"{', '.join(angles)} {what} {side} impact", ", ".join(f"{{{key}[{k}]:.8f}}" for k in numbers), unit)
            for side, key in (("after", "state_after_impact"), ("before", "state_before_impact"))
            for what, numbers, unit in (
                ("angle", range(len(angles)), "rad"),
                ("rate", range(len(angles), 2 * len(angles)), "rad/s"),
            )
        ),
        *_CYCLE,
        ("energy about the stance foot", "{energy_J:.5f}", "J"),
        *_stability_lines(summary),
    )
    return summary, [_filled(lines, summary)]


def kneed_gait_told(gait: KneedGait) -> Told:
    """Report a passive gait with knees; states are of stance leg, swing thigh and shank, rad and rad/s."""
    summary = {
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
    after, before = "state_after_heel_strike", "state_before_heel_strike"
    lines = (
        ("slope", "{slope_deg:.4g}", "deg"),
        ("stance, swing angle after heel strike", f"{{{after}[0]:.8f}}, {{{after}[1]:.8f}}", "rad"),
        ("stance, swing rate after heel strike", f"{{{after}[3]:.8f}}, {{{after}[4]:.8f}}", "rad/s"),
        ("rates of all three before knee strike", "{knee}", "rad/s"),
        ("stance, swing rate before heel strike", f"{{{before}[3]:.8f}}, {{{before}[4]:.8f}}", "rad/s"),
        ("knee strike", "{knee_strike_s:.8f}", "s"),
        *_CYCLE,
        ("clearance of the swing foot", "{clearance_cm:.3f}", "cm"),
        ("greatest flexion of the knee", "{greatest_flexion_deg:.3f}", "deg"),
        *_stability_lines(summary),
    )
    knee = ", ".join(f"{rate:.6f}" for rate in summary["rates_before_knee_strike"])
    return summary, [_filled(lines, {**summary, "knee": knee, "clearance_cm": 100 * gait.clearance})]


def _filled(lines: Iterable[Line], results: Mapping[str, Any]) -> Table:
    """Fill results into the lines of a table."""
    return table_of((label, form.format_map(results), unit) for label, form, unit in lines)


def _stability_of(gait: PassiveGait) -> dict[str, Any]:
    """A gait's Floquet multipliers, and whether it is stable."""
    return {
        "multipliers": [
            {"real": value.real, "imaginary": value.imag, "modulus": abs(value)} for value in gait.multipliers.tolist()
        ],
        "stable": gait.stable,
    }


def _stability_lines(summary: Mapping[str, Any]) -> Iterator[Line]:
    """Iterate over the lines about a gait's stability."""
    for value in summary["multipliers"]:
        number = f"{value['real']:.5f}" + (f" {value['imaginary']:+.5f} i" if value["imaginary"] else "")
        yield "Floquet multiplier, modulus", f"{number}, {value['modulus']:.5f}", ""
    yield "stable", "yes" if summary["stable"] else "no", ""


def reference_told(gait: OptimisedGait) -> Told:
    """Report an optimised gait; states are the robot's angles (rad), then their rates (rad/s)."""
    told, joints = gait.measures, gait.robot.joints
    summary = {
        "speed_m_per_s": gait.speed,
        "cost_of_transport": told.cost_of_transport,
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "half_angle_rad": float(gait.end[0]),
        **{f"peak_{joint}_torque_Nm": told.peak_torque[k] for k, joint in enumerate(joints)},
        "least_normal_force_weights": told.normal_force / gait.robot.weight,
        "friction": told.friction,
        "clearance_phase": gait.clearance_phase if gait.goal.clearance else None,
        "clearance_m": told.clearance if gait.goal.clearance else None,
        "greatest_clearance_m": told.greatest_clearance,
        "state_after_impact": gait.start.tolist(),
        "state_before_impact": gait.end.tolist(),
        **({"knee_strike_s": gait.knee_strike} if gait.knee_strike else {}),
    }
    lines = [
        ("speed", "{speed_m_per_s:.4f}", "m/s"),
        ("cost of transport, level", "{cost_of_transport:.4f}", ""),
        ("period", "{period_s:.6f}", "s"),
        ("half the angle between the legs at the impact", "{half_angle_rad:.6f}", "rad"),
        ("step length", "{step_length_m:.6f}", "m"),
        *((f"peak torque, {joint}", f"{{peak_{joint}_torque_Nm:.2f}}", "N m") for joint in joints),
        ("normal force, least", "{least_normal_force_weights:.3f}", "weights"),
        ("friction used", "{friction:.3f}", ""),
    ]
    if "knee_strike_s" in summary:
        lines.append(("knee strike", "{knee_strike_s:.6f}", "s"))
    if gait.goal.clearance:
        lines.append((f"clearance at {100 * gait.clearance_phase:.1f} % of the step", "{clearance_m:.4f}", "m"))
    lines.append(("clearance ahead of the stance foot, greatest", "{greatest_clearance_m:.4f}", "m"))
    return summary, [_filled(lines, summary)]


def stability_told(found: Stability) -> Told:
    """Report on Theorem 1 along a walk; results that need more than one step are None for a walk of one."""
    norms = np.linalg.norm(found.end, axis=1)
    compared = found.ratio[np.isfinite(found.ratio)]
    left = found.condition[1:]
    within = np.diff(found.step) == 0
    summary = {
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
    shown = {key: in_words(value, 1, ".4g") for key, value in summary.items()}
    return summary, [_filled(_THEOREM, shown)]


def checks_table(answers: Iterable[Answer]) -> Table:
    """Return a table of the paper's claims, and whether they hold."""
    table = bare_table("claim", "settings", "engine", "found", "holds")
    for answer in answers:
        holds = "-" if answer.holds is None else "yes" if answer.holds else "no"
        asked = f"{holds}, of {answer.of}" if answer.of else holds
        table.add_row(*(Text(cell) for cell in (answer.claim, answer.group, answer.engine, answer.found, asked)))
    return table


def estimate_sentence(expected: Mapping[str, float]) -> Text:
    """Say how many walks a study has, and how much time and disk they are likely to take."""
    took = timedelta(seconds=max(1, round(expected["seconds"])))
    processes = "1 process" if expected["workers"] == 1 else f"{expected['workers']} processes"
    return Text(
        f"{expected['walks']} walks: about {took} h in {processes} (beside their start and compilation), "
        f"{max(0.1, expected['bytes'] / 1e6):.1f} MB of tables and samples; inferred from {expected['tried']} of them"
    )


def sweep_tables(summary: Mapping[str, Any]) -> list[RenderableType]:
    """Return a study's summary: outcomes, quantiles, measures by value, the best combination, time, and any errors."""
    outcomes = bare_table("outcome", "walks", "%")
    for outcome, count in summary["verdicts"].items():
        outcomes.add_row(outcome, str(count), f"{100.0 * count / summary['walks']:.1f}")
    quantiles = bare_table("of the finished walks", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit")
    for label, key, factor, form, unit, *_ in MEASURES:
        values = summary["finished"].get(key)
        if values is not None:
            quantiles.add_row(label, *(in_words(value, factor, form) for value in values), unit)
    shown: list[RenderableType] = [outcomes, *([quantiles] if quantiles.rows else [])]
    shown += [_value_table(name, entries) for name, entries in summary["by_value"].items() if len(entries) > 1]
    if best := summary["best"]:
        shown.append(
            Text(
                f"best: {best['combination']} ({100 * best['finished']:.0f} % of {best['walks']} finished, median cost "
                f"of transport {best['cost_of_transport']:.4f}, first cell {best['first_cell']})"
            )
        )
    if summary["walks_now"]:
        seconds = summary["seconds"]
        rate = f"{summary['walks_now'] / seconds:.3g} walks/s"
        shown.append(Text(f"{summary['walks_now']} walks in {seconds:.1f} s, {rate}"))
    if summary["errors"]:
        errors = bare_table("error", "walks", "first cell")
        for each in summary["errors"]:
            errors.add_row(Text(each["error"]), str(each["walks"]), str(each["first_cell"]))
        shown.append(errors)
    return shown


def _value_table(name: str, entries: Sequence[Mapping[str, Any]]) -> Table:
    """Return the share that finished and medians of the study's measures for each value of one quantity."""
    from mjbiped.sweeps.bins import measure_label, parameter_label
    from mjbiped.sweeps.plan import FINISHED

    measures = [key for key in entries[0] if key not in ("value", "walks")]
    table = bare_table(parameter_label(name), "walks", *(f"{measure_label(key)}" for key in measures))
    for entry in entries:
        values = [(entry[key], ".0%" if key == FINISHED else ".4g") for key in measures]
        cells = ["" if value is None else f"{value:{form}}" for value, form in values]
        table.add_row(Text(entry["value"]), str(entry["walks"]), *cells)
    return table


def as_json(values: Mapping[str, Any]) -> str:
    """Write values as a JSON object; infinity and NaN, which JSON does not have, become null."""
    return json.dumps(_plain(values), indent=2, allow_nan=False, ensure_ascii=True)


def _plain(value: object) -> Any:
    """Convert a value to one that JSON can hold."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
