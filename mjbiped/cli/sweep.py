"""The command `mjbiped sweep`: many walks, as a file describes them."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import options, sections
from mjbiped.cli import tables as told
from mjbiped.cli.files import INTERRUPTED, end, tell
from mjbiped.cli.study_options import OUT, WALKS, check_walkers, study_argument


@click.command("sweep", cls=sections.SectionCommand)
@study_argument
@sections.options(
    "Walks",
    *WALKS,
    (
        "--trajectories",
        bool,
        False,
        "Keep the samples of all walks too, in trajectories.parquet; needs pip install 'mjbiped[data]'.",
    ),
)
@sections.options(
    "Results",
    OUT,
    ("--parquet", bool, False, "Write the table as study.parquet too; needs pip install 'mjbiped[data]'."),
)
@options.width_option
@options.printed_options
def sweep(
    study: Path,
    workers: int | None,
    scheduler: str | None,
    fresh: bool,
    trajectories: bool,
    out: Path | None,
    parquet: bool,
    json: bool,
    quiet: bool,
) -> None:
    """Walk all the walks that STUDY asks for, a .toml file: grids, random samples, or both.

    Each walk is a row of the table, kept as soon as it has ended: interrupted or killed, the same command goes on where
    it was stopped. docs/sweeps.md describes the file.

    \b
    Examples:
      mjbiped sweep scripts/studies/random_ground.toml --out out/random_ground
      mjbiped sweep study.toml --workers 2 --json
      mjbiped sweep study.toml --parquet --trajectories
      mjbiped sweep study.toml --scheduler tcp://10.0.0.1:8786
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.sweeps.bins import summarised
    from mjbiped.sweeps.figures import draw
    from mjbiped.sweeps.parquet import FILE, check_installed, write_table
    from mjbiped.sweeps.plan import read_study
    from mjbiped.sweeps.run import run

    check_walkers(workers, scheduler)
    for option, wanted in (("--parquet", parquet), ("--trajectories", trajectories)):
        if wanted:
            check_installed(option)
    planned = read_study(study)
    folder = study.with_suffix("") if out is None else out
    try:
        rows, table = run(
            planned,
            folder,
            workers=workers,
            scheduler=scheduler,
            fresh=fresh,
            trajectories=trajectories,
            progress=not quiet,
        )
        tables = [table, write_table(table.with_suffix(".parquet"), rows)] if parquet else [table]
        tables += [folder / FILE] if trajectories else []
        files = [*tables, *draw(planned, rows, folder)]
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; what had ended is in {folder}: the same command goes on from there")
    summary = summarised(rows)
    printed = {**summary, "files": [str(file) for file in files]}
    tell(printed, told.sweep_tables(summary), files, json=json, quiet=quiet)
