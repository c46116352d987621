"""The commands `walk`, `compare` and `render`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import mjbiped
from mjbiped.cli import kinds, options, sections
from mjbiped.cli.ending import INTERRUPTED
from mjbiped.cli.files import Results
from mjbiped.cli.sections import results, taken
from mjbiped.cli.walkers import engine_of, mujoco_of, walker


@click.command("walk", cls=sections.SectionCommand)
@click.argument("terrain", default="mixed")
@options.walker_options
@options.engine_option
@results(options.RECORD, *options.PLOT, options.PANELS, options.VIDEO_FILE, *options.PRINTED)
@options.video_options
@click.pass_context
def walk(ctx: click.Context, /, results: Results, **values: Any) -> None:
    """Simulate a walk on TERRAIN, and report how it went.

    TERRAIN is a preset, a preset with parameters, or a file; "mixed" if left out. Slopes are positive downhill, steps
    positive up. A file is a .csv of elevations, columns x,z in m, or a .toml or .yaml with segments = [[length_m,
    slope_deg, step_m], ...].

    \b
    Presets: level, incline, slopes, stairs, mixed, random, treads, waves, recorded; with parameters:
      stairs:rise=-0.06,tread=1.8    slopes:change_deg=-1    random:slope_deg=-2..2

    \b
    Examples:
      mjbiped walk mixed --initial rest --out walk.npz --video walk.mp4
      mjbiped walk stairs:rise=-0.02 --replanning-delay none --json
      mjbiped walk incline:slope_deg=2 --controller passive --distance 20
      mjbiped walk slopes --controller energy-constraint --gain ratio=-2 --gain gain=20
      mjbiped walk trail.csv --steps 200 --plot trail.pdf
      mjbiped walk stairs:rise=0.04 --robot kneed --engine hybrid --plot knees.png
      mjbiped walk trail.csv --controller spread.py:HipSpread --gain stiffness=25 --initial rest
    """  # noqa: D301 (click reads the backspace)
    pictures = taken(ctx, values, options.VIDEO)
    _check_part(pictures)
    law, ground = walker(ctx, values)
    engine = engine_of(ctx, values.pop("engine"), values)
    if results.video is not None and not results.quiet:
        _warn_without_gl()
    status, trouble = 0, ""
    try:
        done = mjbiped.walk(law, ground, engine=engine, progress=not results.quiet, **values)
    except mjbiped.WalkInterrupted as stop:
        done, status, trouble = stop.walk, INTERRUPTED, f"the walk was interrupted after {stop.walk.steps} steps"
    except mjbiped.WalkStopped as stop:
        done, status, trouble = stop.walk, 1, str(stop)
    done = replace(done, settings={**done.settings, "command": ctx.obj})
    results.save(done)
    if trouble:
        results.fail(status, trouble + (f"; what was walked is in {results.out}" if results.written else ""))
    else:
        results.draw("walk:plot_walk", done)
        results.render(done, pictures)
    summary = done.summary()
    results.end({**summary, "settings": dict(done.settings)}, [summary])


@click.command("compare", cls=sections.SectionCommand)
@click.argument("terrain", default="mixed")
@options.walker_options
@results(options.RECORDS, *options.PLOT, *options.PRINTED)
@click.pass_context
def compare(ctx: click.Context, /, results: Results, **values: Any) -> None:
    """Simulate a walk on TERRAIN in both engines, and report where they diverge and why.

    The same controller walks in MuJoCo (contacts resolved in time) and in the hybrid engine (the paper's equations and
    impact map). TERRAIN is as for `mjbiped walk`. A fall is a result: the exit status stays 0.

    \b
    Examples:
      mjbiped compare mixed --steps 18 --plot compare.png
      mjbiped compare stairs:rise=-0.06 --replanning-delay none
      mjbiped compare slopes:change_deg=-1 --controller passivity --gain gain=20 --slope-source local
      mjbiped compare trail.csv --initial rest --json --out trail.npz
    """  # noqa: D301 (click reads the backspace)
    from rich.text import Text

    from mjbiped.cli.tables import comparison_tables

    law, ground = walker(ctx, values)
    mujoco = mujoco_of(ctx, values)

    def write(*walks: mjbiped.Walk) -> None:
        for record in walks:
            name, out = record.settings["engine"], results.out
            results.write(f"record_{name}", out and out.with_stem(f"{out.stem}_{name}"), record.save)

    try:
        done = mjbiped.compare(law, ground, mujoco=mujoco, progress=not results.quiet, **values)
    except (mjbiped.WalkStopped, mjbiped.WalkInterrupted) as stop:
        write(*stop.before, stop.walk)
        kept = f"; what was walked is in {' and '.join(results.written.values())}" if results.written else ""
        status = 1 if isinstance(stop, mjbiped.WalkStopped) else INTERRUPTED
        results.fail(status, f"{stop} (engine {stop.walk.settings['engine']}){kept}")
        results.end({}, [])
    write(done.mujoco, done.hybrid)
    results.draw("comparison:plot_comparison", done)
    who = f"{done.mujoco.settings['controller']['name']} on {done.mujoco.terrain.caption}"
    results.end(done.to_dict(), [who, *comparison_tables(done), Text(done.verdict)])


@click.command("render", cls=sections.SectionCommand)
@click.argument("record", type=click.Path(path_type=Path))
@click.argument("video", required=False, type=kinds.VIDEO)
@results(*options.PLOT, options.PANELS, ("--no-video", bool, "Write the figure only."), options.QUIET)
@options.video_options
def render(record: Path, results: Results, **pictures: object) -> None:
    """Draw the walk of RECORD, an .npz file: a video, a figure.

    The video goes to VIDEO, an .mp4 or .gif file; if left out, to an .mp4 file beside the record, with its name.

    \b
    Examples:
      mjbiped render walk.npz
      mjbiped render walk.npz slow.mp4 --slow-motion 4 --start 10 --stop 14 --camera side
      mjbiped render walk.npz walk.gif --video-size 640x360 --fps 15 --hide chart,labels
      mjbiped render walk.npz --no-video --plot walk.svg
    """  # noqa: D301 (click reads the backspace)
    if results.no_video and (results.plot is None or results.video is not None):
        raise click.UsageError("--no-video leaves a --plot to be drawn, and no VIDEO.")
    _check_part(pictures)
    done = mjbiped.Walk.load(record)
    if results.video is None and not results.no_video:
        results.video = kinds.VIDEO(record.with_suffix(".mp4"))
    results.draw("walk:plot_walk", done)
    results.render(done, pictures)
    results.end({}, [])


def _check_part(pictures: Mapping[str, Any]) -> None:
    """Refuse a video that ends before it begins.

    Raises:
        click.UsageError: The video ends before it begins.
    """
    start, stop = pictures["start"], pictures["stop"]
    if start is not None and stop is not None and start > stop:
        raise click.UsageError(f"--start {start:g} comes after --stop {stop:g}; swap them.")


def _warn_without_gl() -> None:
    """Warn before a walk that its video will fail."""
    from mjbiped.rendering.gl import gl_available

    if gl_available() is None:
        click.echo("Warning: there is no OpenGL platform for the video; all else will be written.", err=True)
