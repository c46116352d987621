"""The commands `mjbiped sweep`, `robustness`, `reproduce` and `compile`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mjbiped.cli.commands import command
from mjbiped.cli.main import INTERRUPTED, end
from mjbiped.cli.options import ENGINE, FILE, FOLDER, Study
from mjbiped.cli.results import Figures, Results, cell
from mjbiped.records.summary import quantile_rows, table_of
from mjbiped.utils import domains

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

File = Annotated[Path, FILE]
Folder = Annotated[Path | None, FOLDER]
Workers = Annotated[int | None, domains.WORKERS]


@command("sweep")
def sweep(
    study: File,
    /,
    *,
    walks: Study,
    trajectories: bool = False,
    dry_run: bool = False,
    out: Folder = None,
    parquet: bool = False,
    results: Figures,
) -> None:
    """Run the walks that STUDY, a .toml file, describes: grids, random samples, or both.

    Each walk is a row of the table, kept as soon as it has ended: if interrupted or killed, the same command
    resumes. The page "studies" of the documentation describes the file.

    Walks:
        trajectories: Keep the samples of all walks too, in trajectories.parquet; needs pip install 'mjbiped[data]'.
        dry_run: Make a few walks only, and estimate number, time and file sizes of all walks.

    Results:
        out: Folder for table and figures; beside STUDY, with its name, unless given.
        parquet: Write the table as study.parquet too; needs pip install 'mjbiped[data]'.

    \b
    Examples:
      mjbiped sweep scripts/studies/random_ground.toml --out out/random_ground
      mjbiped sweep study.toml --dry-run
      mjbiped sweep study.toml --workers 2 --json
      mjbiped sweep study.toml --parquet --trajectories
      mjbiped sweep study.toml --scheduler tcp://10.0.0.1:8786
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.studies.figures import draw
    from mjbiped.studies.plan import read_study
    from mjbiped.studies.run import estimate, run
    from mjbiped.studies.store import FILE, write_table
    from mjbiped.studies.summary import best, by_value, summarised
    from mjbiped.utils.packages import needed

    for option, wanted in (("--parquet", parquet), ("--trajectories", trajectories)):
        if wanted:
            needed("pyarrow.parquet", "data", option)
    planned = read_study(study)
    if dry_run:
        expected = estimate(planned, workers=walks.workers, trajectories=trajectories)
        results.end(expected, [estimate_sentence(expected)])
        return
    folder = out or study.with_suffix("")
    with _resumable(folder):
        swept = run(planned, folder, trajectories=trajectories, progress=not results.quiet, **vars(walks))
        files = [swept.table]
        if parquet:
            files.append(write_table(swept.table.with_suffix(".parquet"), swept.rows))
        if trajectories:
            files.append(folder / FILE)
        files += draw(planned, swept.rows, folder)
    summary = {**summarised(swept.rows), "by_value": by_value(swept.rows, planned), "best": best(swept.rows, planned)}
    summary |= {"walks_now": swept.walks, "seconds": swept.seconds}
    results.end(summary, sweep_tables(summary), files)


@command("robustness")
def robustness(study: File, /, *, walks: Study, dry_run: bool = False, out: Folder = None, results: Figures) -> None:
    """Measure how robust the controllers of STUDY are, a .toml file.

    Each controller walks on level ground, over single steps and changes of slope that come at all phases of its step,
    and on random ground until it falls. Finished walks are kept: if interrupted or killed, the same command
    resumes. The page "studies" of the documentation describes the file and what is measured.

    Walks:
        dry_run: Make a few walks only, and estimate number and time of all walks.

    Results:
        out: Folder for table and figures; beside STUDY, with its name, unless given.

    \b
    Examples:
      mjbiped robustness scripts/studies/robustness.toml --out out/robustness
      mjbiped robustness study.toml --dry-run
      mjbiped robustness study.toml --json
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.studies.robustness import read_plan
    from mjbiped.studies.robustness_findings import Robustness
    from mjbiped.studies.robustness_report import TABLES, draw, robustness_tables, write_tables
    from mjbiped.studies.run import estimate, run

    planned = read_plan(study)
    if dry_run:
        expected = estimate(planned.study, workers=walks.workers)
        results.end(expected, [estimate_sentence(expected)])
        return
    folder = out or study.with_suffix("")
    with _resumable(folder):
        rows, table, *_ = run(planned.study, folder, progress=not results.quiet, **vars(walks))
        result = Robustness(planned, rows)
        files = [table, write_tables(result, folder / TABLES), *draw(result, folder)]
    results.end(result.summary(), robustness_tables(result), files)


@command("reproduce")
def reproduce(
    *,
    quick: bool = False,
    workers: Workers = None,
    fresh: bool = False,
    out: Annotated[Path, FOLDER] = Path("reproduction"),
    report: Folder = None,
    results: Figures,
) -> None:
    """Reproduce section V of the paper in both engines: tables II and III, figures 4 to 6, and a report.

    Finished walks are kept in --out: if interrupted or killed, the same command resumes.

    Walks:
        quick: Only a few short walks in MuJoCo; all of the hybrid engine's.
        workers: Number of processes; one for each core unless given.
        fresh: Delete the finished walks of an earlier run and begin again.

    Results:
        out: Folder where finished walks are kept.
        report: Folder for page, table and figures; --out unless given.

    \b
    Examples:
      mjbiped reproduce --quick
      mjbiped reproduce --out reproduction --report docs
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.studies.reproduction.claims import checks, what_counts
    from mjbiped.studies.reproduction.reproduce import reproduce as walk_all

    quiet = results.quiet
    with _resumable(out):
        done, files = walk_all(out, quick=quick, workers=workers, fresh=fresh, report=report, progress=not quiet)
    asked = checks(done)
    failed = [row for row in done.rows if row.outcome == "failed"]
    errors = [{"ground": row.ground, "method": row.method, "error": row.error} for row in failed]
    lines = (f"failed: {row.method} on {row.ground}, {row.engine}: {row.error}" for row in failed)
    claims = ([a.claim, a.group, a.engine, a.found, f"{cell(a.holds)}{f', of {a.of}' if a.of else ''}"] for a in asked)
    summary = {"walks": len(done.rows), "failed": errors, "checks": [answer._asdict() for answer in asked]}
    results.end(
        summary, [table_of(claims, "claim", "settings", "engine", "found", "holds"), what_counts(asked), *lines], files
    )


@command("compile")
def compile(
    controllers: tuple[str, ...] = (),
    /,
    *,
    engine: Annotated[str | None, ENGINE] = None,
    workers: Workers = None,
    clear: bool = False,
    results: Results,
) -> None:
    """Compile the machine code for walks with CONTROLLERS in advance; for all registered ones unless given.

    Name your own by its class, as for `mjbiped walk`.

    The machine code is kept in the user's cache, or in the folder that the environment variable NUMBA_CACHE_DIR names:
    for an image or a cluster, set the same folder for this command and for the walks. The machine code fits one kind of
    processor and one version of the project. Existing machine code is not compiled again; beyond 1 GB the oldest
    is deleted.

    Machine code:
        engine: Only for this engine; for all unless given.
        workers: Number of processes; one for each core unless given.
        clear: Delete all machine code that is kept, and compile nothing.

    \b
    Examples:
      mjbiped compile
      mjbiped compile adaptive passive --engine hybrid
      mjbiped compile spread.py:HipSpread
      mjbiped compile --clear
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.numerics import cache
    from mjbiped.rollout.walk import precompile

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


def estimate_sentence(expected: Mapping[str, float]) -> str:
    """Say how many walks a study has, and how much time and disk they are likely to take."""
    minutes, seconds = divmod(max(1, round(expected["seconds"])), 60)
    hours, minutes = divmod(minutes, 60)
    took = f"{hours} h {minutes} min" if hours else f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    return (
        f"{expected['walks']} walks: about {took} in {expected['workers']} process{'es' * (expected['workers'] > 1)} "
        f"(beside their start and compilation), {max(0.1, expected['bytes'] / 1e6):.1f} MB of tables and samples; "
        f"inferred from {expected['tried']} of them"
    )


def sweep_tables(summary: Mapping[str, Any]) -> Iterator[RenderableType]:
    """Show a study's outcomes, quantiles, measures by value, the best combination, time, and any errors."""
    walks, quantiles = summary["walks"], quantile_rows(summary["finished"])
    outcomes = ([outcome, str(count), f"{100.0 * count / walks:.1f}"] for outcome, count in summary["verdicts"].items())
    yield table_of(outcomes, "outcome", "walks", "%")
    if quantiles:
        yield table_of(quantiles, "of the finished walks", *(f"{100 * q:g} %" for q in summary["quantiles"]), "unit")
    for name, entries in summary["by_value"].items():
        if len(entries) > 1:
            yield _value_table(name, entries)
    if best := summary["best"]:
        yield (
            f"best: {best['combination']} ({100 * best['finished']:.0f} % of {best['walks']} finished, "
            f"median cost of transport {best['cost_of_transport']:.4f}, first cell {best['first_cell']})"
        )
    if now := summary["walks_now"]:
        yield f"{now} walks in {summary['seconds']:.1f} s, {now / summary['seconds']:.3g} walks/s"
    if summary["errors"]:
        yield table_of(([*map(str, each.values())] for each in summary["errors"]), "error", "walks", "first cell")


def _value_table(name: str, entries: Sequence[Mapping[str, Any]]) -> Table:
    """Make a table of the share that finished and medians of the study's measures for each value of a quantity."""
    from mjbiped.studies.bins import measure_label, parameter_label
    from mjbiped.studies.plan import FINISHED

    measures = [key for key in entries[0] if key not in ("value", "walks")]
    forms = {key: "{:.0%}" if key == FINISHED else "{:.4g}" for key in measures}
    rows = (
        [each["value"], str(each["walks"])]
        + ["" if each[key] is None else form.format(each[key]) for key, form in forms.items()]
        for each in entries
    )
    return table_of(rows, parameter_label(name), "walks", *map(measure_label, measures))


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """On Ctrl-C, say that the same command resumes the study."""
    try:
        yield
    except KeyboardInterrupt:
        end(INTERRUPTED, f"interrupted; what had ended is in {folder}: the same command goes on from there")
