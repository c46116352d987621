"""The command `mjbiped robustness`: steps until a fall, and greatest disturbances, of controllers side by side."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import options, sections
from mjbiped.cli.files import INTERRUPTED, end, tell
from mjbiped.cli.study_options import OUT, WALKS, check_walkers, study_argument


@click.command("robustness", cls=sections.SectionCommand)
@study_argument
@sections.options(
    "Walks",
    *WALKS,
)
@sections.options(
    "Results",
    OUT,
)
@options.width_option
@options.printed_options
def robustness(
    study: Path, workers: int | None, scheduler: str | None, fresh: bool, out: Path | None, json: bool, quiet: bool
) -> None:
    """Measure how robust the controllers of STUDY are, a .toml file.

    Each controller walks on level ground, over single steps and changes of slope that come at all phases of its step,
    and on random ground until it falls. The walks are kept as they end: interrupted or killed, the same command goes on
    where it was stopped. docs/robustness.md describes the file and what is measured.

    \b
    Examples:
      mjbiped robustness scripts/studies/robustness.toml --out out/robustness
      mjbiped robustness study.toml --json
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.robustness.figures import draw
    from mjbiped.robustness.plan import read_plan
    from mjbiped.robustness.result import found
    from mjbiped.robustness.tables import TABLES, robustness_tables, write_tables
    from mjbiped.sweeps.run import run

    check_walkers(workers, scheduler)
    planned = read_plan(study)
    folder = study.with_suffix("") if out is None else out
    try:
        rows, table = run(planned.study, folder, workers=workers, scheduler=scheduler, fresh=fresh, progress=not quiet)
        result = found(planned, rows)
        files = [table, write_tables(result, folder / TABLES), *draw(result, folder)]
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; what had ended is in {folder}: the same command goes on from there")
    printed = {**result.summary(), "files": [str(file) for file in files]}
    tell(printed, robustness_tables(result), files, json=json, quiet=quiet)
