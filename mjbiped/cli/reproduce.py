"""The command `mjbiped reproduce`: section V of the paper again."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import kinds, options, sections, tables
from mjbiped.cli.files import INTERRUPTED, end, tell
from mjbiped.utils import domains


@click.command("reproduce", cls=sections.SectionCommand)
@sections.options(
    "Walks",
    ("--quick", bool, False, "Only a few short walks in MuJoCo; all of the hybrid engine's."),
    ("--workers", domains.WORKERS, None, "Processes; one for each core unless given."),
    ("--fresh", bool, False, "Delete the finished walks of an earlier run and begin again."),
)
@sections.options(
    "Results",
    ("--out", kinds.Folder(), "reproduction", "Finished walks, kept."),
    ("--report", kinds.Folder(), None, "Where page, table and figures go; --out unless given."),
)
@options.width_option
@options.printed_options
def reproduce(
    quick: bool, workers: int | None, fresh: bool, out: Path, report: Path | None, json: bool, quiet: bool
) -> None:
    """Walk section V of the paper again, in both engines: tables II and III, figures 4 to 6, and a report.

    Each finished walk is kept in --out: interrupted or killed, the same command goes on where it was stopped.

    \b
    Examples:
      mjbiped reproduce --quick
      mjbiped reproduce --out reproduction --report docs
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.reproduction.report.checks import checks
    from mjbiped.reproduction.reproduce import reproduce as walk_all
    from mjbiped.reproduction.table_2 import choices

    try:
        rows, files = walk_all(out, quick=quick, workers=workers, report=report, fresh=fresh, progress=not quiet)
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; finished walks are in {out}: the same command goes on from there")
    asked = checks(rows, choices(rows)[0])
    failed = [row for row in rows if row.outcome == "failed"]
    plain = [{**check.answer._asdict(), "engine": check.engine, "group": check.group} for check in asked]
    errors = [{"ground": row.ground, "method": row.method, "error": row.error} for row in failed]
    summary = {"walks": len(rows), "failed": errors, "checks": plain, "files": [str(file) for file in files]}
    lines = (f"failed: {row.method} on {row.ground}, {row.engine}: {row.error}" for row in failed)
    tell(summary, [tables.checks_table(asked), *lines], files, json=json, quiet=quiet)
