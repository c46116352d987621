"""The commands `mjbiped sweep`, `robustness`, `reproduce`, `report` and `compile`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from mjbiped.cli import kinds, options, sections, tables
from mjbiped.cli.ending import INTERRUPTED, end
from mjbiped.cli.files import Results
from mjbiped.cli.sections import results
from mjbiped.engines.names import ENGINES
from mjbiped.errors import InputError, shown
from mjbiped.records.record import Walk


class _Sweep:
    """Options of a sweep.

    Attributes:
        trajectories: Keep the samples of all walks too, in trajectories.parquet; needs pip install 'mjbiped[data]'.
        dry_run: Walk a few of them only, and tell how many there are, their time and the size of the files.
        parquet: Write the table as study.parquet too; needs pip install 'mjbiped[data]'.
    """

    trajectories = dry_run = parquet = bool


_TRAJECTORIES, _DRY_RUN, _PARQUET = sections.rows_of(_Sweep)


@click.command("sweep", cls=sections.SectionCommand)
@options.study_argument
@sections.options("Walks", *options.STUDY, _TRAJECTORIES, _DRY_RUN)
@results(options.STUDY_FOLDER, _PARQUET, options.WIDTH, *options.PRINTED)
def sweep(study: Path, results: Results, trajectories: bool, parquet: bool, dry_run: bool, **walks: Any) -> None:
    """Run the walks that STUDY, a .toml file, describes: grids, random samples, or both.

    Each walk is a row of the table, kept as soon as it has ended: if interrupted or killed, the same command
    resumes. docs/sweeps.md describes the file.

    \b
    Examples:
      mjbiped sweep scripts/studies/random_ground.toml --out out/random_ground
      mjbiped sweep study.toml --dry-run
      mjbiped sweep study.toml --workers 2 --json
      mjbiped sweep study.toml --parquet --trajectories
      mjbiped sweep study.toml --scheduler tcp://10.0.0.1:8786
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.sweeps.figures import draw
    from mjbiped.sweeps.plan import read_study
    from mjbiped.sweeps.run import estimate, run
    from mjbiped.sweeps.store import FILE, write_table
    from mjbiped.sweeps.summary import best, by_value, summarised
    from mjbiped.utils.packages import needed

    _check_walkers(**walks)
    for option, wanted in (("--parquet", parquet), ("--trajectories", trajectories)):
        if wanted:
            needed("pyarrow.parquet", "data", option)
    planned = read_study(study)
    if dry_run:
        expected = estimate(planned, workers=walks["workers"], trajectories=trajectories)
        results.end(expected, [tables.estimate_sentence(expected)])
        return
    folder = results.out or study.with_suffix("")
    with _resumable(folder):
        swept = run(planned, folder, trajectories=trajectories, progress=not results.quiet, **walks)
        files = [swept.table]
        if parquet:
            files.append(write_table(swept.table.with_suffix(".parquet"), swept.rows))
        if trajectories:
            files.append(folder / FILE)
        files += draw(planned, swept.rows, folder)
    summary = {**summarised(swept.rows), "by_value": by_value(swept.rows, planned), "best": best(swept.rows, planned)}
    summary |= {"walks_now": swept.walks, "seconds": swept.seconds}
    results.end(summary, tables.sweep_tables(summary), files)


@click.command("robustness", cls=sections.SectionCommand)
@options.study_argument
@sections.options("Walks", *options.STUDY, _DRY_RUN)
@results(options.STUDY_FOLDER, options.WIDTH, *options.PRINTED)
def robustness(study: Path, results: Results, dry_run: bool, **walks: Any) -> None:
    """Measure how robust the controllers of STUDY are, a .toml file.

    Each controller walks on level ground, over single steps and changes of slope that come at all phases of its step,
    and on random ground until it falls. Finished walks are kept: if interrupted or killed, the same command
    resumes. docs/robustness.md describes the file and what is measured.

    \b
    Examples:
      mjbiped robustness scripts/studies/robustness.toml --out out/robustness
      mjbiped robustness study.toml --dry-run
      mjbiped robustness study.toml --json
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.robustness.plan import read_plan
    from mjbiped.robustness.report import TABLES, draw, robustness_tables, write_tables
    from mjbiped.robustness.result import Robustness
    from mjbiped.sweeps.run import estimate, run

    _check_walkers(**walks)
    planned = read_plan(study)
    if dry_run:
        expected = estimate(planned.study, workers=walks["workers"])
        results.end(expected, [tables.estimate_sentence(expected)])
        return
    folder = results.out or study.with_suffix("")
    with _resumable(folder):
        rows, table, *_ = run(planned.study, folder, progress=not results.quiet, **walks)
        result = Robustness(planned, rows)
        files = [table, write_tables(result, folder / TABLES), *draw(result, folder)]
    results.end(result.summary(), robustness_tables(result), files)


@click.command("reproduce", cls=sections.SectionCommand)
@sections.options(
    "Walks",
    ("--quick", bool, "Only a few short walks in MuJoCo; all of the hybrid engine's."),
    options.WORKERS,
    ("--fresh", bool, "Delete the finished walks of an earlier run and begin again."),
)
@results(
    ("--out", kinds.FOLDER, "Folder where finished walks are kept.", "reproduction"),
    ("--report", kinds.FOLDER, "Folder for page, table and figures; --out unless given."),
    options.WIDTH,
    *options.PRINTED,
)
def reproduce(results: Results, **walks: Any) -> None:
    """Reproduce section V of the paper in both engines: tables II and III, figures 4 to 6, and a report.

    Finished walks are kept in --out: if interrupted or killed, the same command resumes.

    \b
    Examples:
      mjbiped reproduce --quick
      mjbiped reproduce --out reproduction --report docs
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.reproduction.claims import checks, what_counts
    from mjbiped.reproduction.reproduce import reproduce as walk_all

    folder = results.out
    assert folder is not None
    with _resumable(folder):
        done, files = walk_all(folder, progress=not results.quiet, **walks)
    asked = checks(done)
    failed = [row for row in done.rows if row.outcome == "failed"]
    errors = [{"ground": row.ground, "method": row.method, "error": row.error} for row in failed]
    lines = (f"failed: {row.method} on {row.ground}, {row.engine}: {row.error}" for row in failed)
    summary = {"walks": len(done.rows), "failed": errors, "checks": [answer._asdict() for answer in asked]}
    results.end(summary, [tables.checks_table(asked), what_counts(asked), *lines], files)


_PAGE = "The page, an .html file; unless given, beside RECORD with its name (for a folder: in it)."
_NO_VIDEO: sections.Row = ("--no-video", bool, "Leave out the video, which takes longest.")


@click.command("report", cls=sections.SectionCommand)
@click.argument("source", metavar="RECORD", type=click.Path(path_type=Path))
@results(("--out", kinds.output(".html"), _PAGE), _NO_VIDEO, options.QUIET)
def report(source: Path, results: Results) -> None:
    """Write an interactive page about the walk of RECORD, an .npz file, or about a study: the folder of a sweep.

    The page holds all that it needs: it opens without a server and without a network, and can be sent as it is. It
    needs Plotly and Jinja: pip install 'mjbiped[report]'. docs/reports.md says what is on it.

    \b
    Examples:
      mjbiped report walk.npz
      mjbiped report walk.npz --no-video --out pages/walk.html
      mjbiped report out/random_ground
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.reports.page import check_installed
    from mjbiped.reports.study import report_study
    from mjbiped.reports.walk import report_walk

    check_installed()
    if not source.exists():
        raise InputError(f"there is no {shown(str(source))}: expected a walk's record (.npz), or the folder of a sweep")
    if source.suffix.lower() == ".toml":
        raise InputError(
            f"{shown(str(source))} is a study's file: expected is the folder of its sweep, which is "
            f"{source.with_suffix('')} unless `mjbiped sweep` was told another"
        )
    study = source.is_dir()
    if study and results.no_video:
        raise click.UsageError("--no-video is for the report of a walk; that of a study has no video.")
    page = results.out or kinds.output(".html")(source / "report.html" if study else source.with_suffix(".html"))
    if study:
        report_study(source, page)
        results.written["report"] = str(page)
    else:
        done, video = Walk.load(source), not results.no_video
        settings: dict[str, Any] = {"video": video, "progress": not results.quiet}
        results.write("report", page, lambda path: report_walk(done, path, **settings))
    results.end({}, [])


@click.command("compile", cls=sections.SectionCommand)
@click.argument("controllers", nargs=-1)
@sections.options(
    "Machine code",
    ("--engine", click.Choice(tuple(ENGINES)), "Only for this engine; for all unless given."),
    options.WORKERS,
    ("--clear", bool, "Delete all machine code that is kept, and compile nothing."),
)
@results(*options.PRINTED)
def compile_(results: Results, controllers: tuple[str, ...], clear: bool, **given: Any) -> None:
    """Compile the machine code for walks with CONTROLLERS in advance; for all registered ones unless given.

    Name your own by its class, as for `mjbiped walk`.

    The machine code is kept in the user's cache, or in the folder that the environment variable NUMBA_CACHE_DIR names:
    set it for an image or a cluster, here and where the walks are made. It fits one kind of processor and one version
    of the project. Existing machine code is not compiled again; beyond 1 GB the oldest is deleted.

    \b
    Examples:
      mjbiped compile
      mjbiped compile adaptive passive --engine hybrid
      mjbiped compile spread.py:HipSpread
      mjbiped compile --clear
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.numerics import cache
    from mjbiped.rollout.precompilation import precompile

    engine, workers = given["engine"], given["workers"]
    if clear:
        if controllers or engine or workers:
            raise click.UsageError("--clear deletes all machine code; give it alone.")
        deleted = cache.clear()
        results.end({"deleted_bytes": deleted}, [f"deleted {deleted / 1e6:.1f} MB of machine code in {cache.root()}"])
        return
    engines = None if engine is None else (engine,)
    made = precompile(controllers or None, engines=engines, workers=workers, progress=not results.quiet)
    lines = [f"compiled for the {name} engine: {', '.join(names)}" for name, names in made.items()]
    results.end({"compiled": made}, lines)


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """On Ctrl-C, say that the same command resumes the study."""
    try:
        yield
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; what had ended is in {folder}: the same command goes on from there")


def _check_walkers(workers: int | None, scheduler: str | None, **_: object) -> None:
    """Refuse a number of local processes together with a scheduler, which has workers of its own.

    Raises:
        click.UsageError: Both are given.
    """
    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers is for this machine; the workers of a --scheduler are its own.")
