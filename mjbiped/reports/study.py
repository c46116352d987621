"""Report of a study, from the folder of its table."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, RecordError
from mjbiped.records.measure_table import MEASURES as SHOWN
from mjbiped.records.measure_table import in_words, quantile_rows
from mjbiped.reports.page import check_installed, write_page
from mjbiped.reports.study_figures import study_figures
from mjbiped.reports.walk import flattened
from mjbiped.sweeps.bins import summarised
from mjbiped.sweeps.cell import MEASURES, Row
from mjbiped.sweeps.store import read_table

TABLE = "study.sqlite"
"""File in a study's folder from which a report is made."""

MOST_ROWS = 3000
"""Greatest number of walks on the page; a study may have hundreds of thousands."""


def report_study(folder: Path, path: Path) -> None:
    """Write the report of a study: one HTML page with outcomes, interactive figures and the table.

    Args:
        folder: Folder in which `mjbiped sweep` writes; it may still be running.
        path: The page.

    Raises:
        InputError: The folder holds no study, or none of its walks has ended; or Plotly or Jinja is not installed.
        RecordError: The study's table is damaged, or the page cannot be written.
    """
    check_installed()
    table = folder / TABLE
    if not table.is_file():
        raise InputError(f"{folder} holds no {TABLE}: expected a walk's record (.npz), or the folder of a sweep")
    rows, identity = read_table(table)
    if not rows:
        raise InputError(f"no walk of the study in {folder} has ended yet")
    varied = _checked(table, rows)
    summary = summarised(rows)
    declared = identity.get("study", {})
    names = [*(name for name in rows[0] if name not in MEASURES), *(each.key for each in SHOWN)]
    forms = {key: (factor, form) for _, key, factor, form, *_ in SHOWN}
    listed = {key: f"{label} ({unit})" if unit else label for label, key, _, _, unit, *_ in SHOWN}
    told = f"The first {MOST_ROWS} of {len(rows)}; all are in study.csv." if len(rows) > MOST_ROWS else ""
    write_page(
        path,
        "study.html",
        study_figures(rows, varied),
        {},
        title=folder.resolve().name,
        outcome=f"Study of {len(rows)} walks, {summary['outcomes'].get('finished', 0)} finished",
        outcome_headings=["outcome", "walks", "%"],
        outcomes=[[name, count, f"{100.0 * count / len(rows):.1f}"] for name, count in summary["verdicts"].items()],
        errors=[[each["error"], each["walks"], each["first_cell"]] for each in summary["errors"]],
        quantile_headings=["measure", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit"],
        quantiles=quantile_rows(summary["finished"]),
        table_note=f"Click a heading to sort by it. {told}".strip(),
        headings=[listed.get(name, name) for name in names],
        rows=[[_cell(row[name], forms.get(name)) for name in names] for row in rows[:MOST_ROWS]],
        parameters=list(flattened(declared)) if isinstance(declared, dict) else [],
        command=shlex.join(["mjbiped", "sweep", f"{folder}.toml", "--out", str(folder)]),
    )


def _checked(table: Path, rows: Sequence[Row]) -> list[str]:
    """Check the columns, and return those that vary.

    Raises:
        RecordError: The rows are not those of a study.
    """
    missing = [name for name in ("cell", "outcome", "error", *MEASURES) if name not in rows[0]]
    if missing:
        raise RecordError(f"{table} is no study's table of this mjbiped: it lacks {', '.join(missing)}")
    return [name for name in rows[0] if name not in ("cell", "sample", "outcome", "error", *MEASURES)]


def _cell(value: Any, form: tuple[float, str] | None) -> str:
    if value is None:
        return ""
    if form is not None:
        return in_words(value, *form)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
