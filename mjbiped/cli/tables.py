"""Results of commands as tables and as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from mjbiped.records.summary import MEASURES, bare_table, in_words, quantile_rows, table_of

if TYPE_CHECKING:
    from mjbiped.analysis.compare import Comparison
    from mjbiped.studies.reproduction.claims import Answer


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


_UNITS = {"m_per_s": "m/s", "Nm": "N m", "weights": "weights", "deg": "deg", "rad": "rad", "m": "m", "s": "s", "J": "J"}
"""Units by the ends of names."""


def summary_table(summary: Mapping[str, Any]) -> Table:
    """Return a table of results: a row for each name, which ends with the unit, and for each part of a mapping."""
    rows = []
    for name, value in summary.items():
        end = next((end for end in _UNITS if name.endswith(f"_{end}")), "")
        label, unit = name.removesuffix(f"_{end}").replace("_", " "), _UNITS.get(end, "")
        if isinstance(value, Mapping):
            rows += [(f"{label}, {part}", _cell(each), unit) for part, each in value.items()]
        else:
            nested = isinstance(value, list) and any(isinstance(each, list | Mapping) for each in value)
            rows += [(label, _cell(each), unit) for each in (value if nested else [value])]
    return table_of(rows)


def _cell(value: object) -> str:
    """Write a result; a dash stands for one that does not exist."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_cell(each)}" for name, each in value.items())
    if isinstance(value, list):
        return ", ".join(map(_cell, value))
    if value is None or isinstance(value, bool):
        return {None: "-", True: "yes", False: "no"}[value]
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def checks_table(answers: Iterable[Answer]) -> Table:
    """Return a table of the paper's claims, and whether they hold."""
    table = bare_table("claim", "settings", "engine", "found", "holds")
    for answer in answers:
        asked = f"{_cell(answer.holds)}, of {answer.of}" if answer.of else _cell(answer.holds)
        table.add_row(*(Text(cell) for cell in (answer.claim, answer.group, answer.engine, answer.found, asked)))
    return table


def estimate_sentence(expected: Mapping[str, float]) -> Text:
    """Say how many walks a study has, and how much time and disk they are likely to take."""
    processes = "1 process" if expected["workers"] == 1 else f"{expected['workers']} processes"
    return Text(
        f"{expected['walks']} walks: about {_duration(expected['seconds'])} in {processes} (beside their start and "
        f"compilation), {max(0.1, expected['bytes'] / 1e6):.1f} MB of tables and samples; inferred from "
        f"{expected['tried']} of them"
    )


def _duration(seconds: float) -> str:
    """Write a duration in its two largest units."""
    minutes, rest = divmod(max(1, round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"


def sweep_tables(summary: Mapping[str, Any]) -> list[RenderableType]:
    """Return a study's summary: outcomes, quantiles, measures by value, the best combination, time, and any errors."""
    outcomes = bare_table("outcome", "walks", "%")
    for outcome, count in summary["verdicts"].items():
        outcomes.add_row(outcome, str(count), f"{100.0 * count / summary['walks']:.1f}")
    quantiles = bare_table("of the finished walks", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit")
    for row in quantile_rows(summary["finished"]):
        quantiles.add_row(*row)
    shown: list[RenderableType] = [outcomes, *([quantiles] if quantiles.rows else [])]
    shown += [_value_table(name, entries) for name, entries in summary["by_value"].items() if len(entries) > 1]
    if best := summary["best"]:
        share = f"{100 * best['finished']:.0f} % of {best['walks']} finished"
        cost = f"median cost of transport {best['cost_of_transport']:.4f}"
        shown.append(Text(f"best: {best['combination']} ({share}, {cost}, first cell {best['first_cell']})"))
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
    from mjbiped.studies.bins import measure_label, parameter_label
    from mjbiped.studies.plan import FINISHED

    measures = [key for key in entries[0] if key not in ("value", "walks")]
    table = bare_table(parameter_label(name), "walks", *(f"{measure_label(key)}" for key in measures))
    for entry in entries:
        values = [(entry[key], ".0%" if key == FINISHED else ".4g") for key in measures]
        cells = ["" if value is None else f"{value:{form}}" for value, form in values]
        table.add_row(Text(entry["value"]), str(entry["walks"]), *cells)
    return table


def as_json(values: Mapping[str, object]) -> str:
    """Write values as a JSON object; infinity and NaN, which JSON does not have, become null."""
    return json.dumps(_plain(values), indent=2, allow_nan=False, ensure_ascii=True)


def _plain(value: object) -> object:
    """Convert a value to one that JSON can hold."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
