"""The command `mjbiped report`: a walk or a study as one interactive page."""

from __future__ import annotations

from pathlib import Path

import click

from mjbiped.cli import kinds, options, sections
from mjbiped.cli.files import Files
from mjbiped.errors import InputError, shown
from mjbiped.records.record import Walk


@click.command("report", cls=sections.SectionCommand)
@click.argument("source", metavar="RECORD", type=click.Path(path_type=Path))
@sections.options(
    "Results",
    (
        "--out",
        kinds.output(".html"),
        None,
        "The page, an .html file; unless given, it is named after RECORD and stands beside it (of a folder: in it).",
    ),
    ("--no-video", bool, False, "Leave out the video, which takes longest."),
)
@options.quiet_option
def report(source: Path, out: Path | None, no_video: bool, quiet: bool) -> None:
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
    if study and no_video:
        raise click.UsageError("--no-video is for the report of a walk; that of a study has no video.")
    page = out or kinds.output(".html")(source / "report.html" if study else source.with_suffix(".html"))
    files = Files()
    if study:
        report_study(source, page)
        files.written["report"] = str(page)
    else:
        done = Walk.load(source)
        files.write(
            "report",
            page,
            lambda path: report_walk(done, path, record=source.name, video=not no_video, progress=not quiet),
        )
    files.end({}, [], json=False, quiet=quiet)
