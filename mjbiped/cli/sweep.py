"""The command `mjbiped sweep`: many walks, as a file describes them."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import options, tables
from mjbiped.cli.files import INTERRUPTED, end, tell
from mjbiped.utils import domains


@click.command("sweep", cls=options.SectionCommand)
@click.argument("study", type=click.Path(path_type=Path))
@options.options(
    "Walks",
    ("--workers", domains.WORKERS, None, "Processes; one for each core unless given."),
    (
        "--scheduler",
        options.Kind("ADDRESS", str),
        None,
        "Let the workers of this Dask scheduler walk, as tcp://host:8786; needs pip install 'mjbiped[cluster]'.",
    ),
    ("--fresh", bool, False, "Delete the rows of an earlier run and begin again."),
)
@options.options(
    "Results",
    (
        "--out",
        options.Folder(),
        None,
        "Where table and figures go; unless given, a folder beside STUDY that has its name.",
    ),
)
@options.width_option
@options.printed_options
def sweep(
    study: Path, workers: int | None, scheduler: str | None, fresh: bool, out: Path | None, json: bool, quiet: bool
) -> None:
    """Walk all the walks that STUDY asks for, a .toml file: grids, random samples, or both.

    Each walk is a row of the table, kept as soon as it has ended: interrupted or killed, the same command goes on where
    it was stopped. docs/sweeps.md describes the file.

    \b
    Examples:
      mjbiped sweep scripts/studies/random_ground.toml --out out/random_ground
      mjbiped sweep study.toml --workers 2 --json
      mjbiped sweep study.toml --scheduler tcp://10.0.0.1:8786
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.sweeps.figures import draw
    from mjbiped.sweeps.plan import read_study
    from mjbiped.sweeps.run import run
    from mjbiped.sweeps.summary import summarised

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers is for this machine; the workers of a --scheduler are its own.")
    planned = read_study(study)
    folder = study.with_suffix("") if out is None else out
    try:
        rows, table = run(planned, folder, workers=workers, scheduler=scheduler, fresh=fresh, progress=not quiet)
        files = [table, *draw(planned, rows, folder)]
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; what had ended is in {folder}: the same command goes on from there")
    summary = summarised(rows)
    printed = {**summary, "files": [str(file) for file in files]}
    tell(printed, tables.sweep_tables(summary), files, json=json, quiet=quiet)
