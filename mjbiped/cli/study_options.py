"""What the commands have in common that walk the many walks of a study's file."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import kinds
from mjbiped.cli.sections import Row
from mjbiped.utils import domains

study_argument = click.argument("study", type=click.Path(path_type=Path))

WALKS: tuple[Row, ...] = (
    ("--workers", domains.WORKERS, None, "Processes; one for each core unless given."),
    (
        "--scheduler",
        kinds.Kind("ADDRESS", str),
        None,
        "Let the workers of this Dask scheduler walk, as tcp://host:8786; needs pip install 'mjbiped[cluster]'.",
    ),
    ("--fresh", bool, False, "Delete the rows of an earlier run and begin again."),
)
"""Who walks, and whether from the beginning."""

OUT: Row = (
    "--out",
    kinds.Folder(),
    None,
    "Where table and figures go; unless given, a folder beside STUDY that has its name.",
)


def check_walkers(workers: int | None, scheduler: str | None) -> None:
    """Refuse a number of processes here where a scheduler's workers walk.

    Raises:
        click.UsageError: Both are given.
    """
    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers is for this machine; the workers of a --scheduler are its own.")
