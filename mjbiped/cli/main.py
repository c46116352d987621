"""The command line: `walk`, `compare`, `gait`, `stability` and `render`; other files here have the other commands.

Exit status: 0 for a walk that came to an end, a fall included; 2 for anything the user can mend, told in one line;
1 for a walk or a drawing that failed on its own; 130 after Ctrl-C, 143 after SIGTERM.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from rich.text import Text

from mjbiped.analysis.compare import compare
from mjbiped.cli import kinds, options, sections, tables, video_options
from mjbiped.cli.compile import compile_
from mjbiped.cli.files import INTERRUPTED, LONGEST_LINE, Files, end, terminable
from mjbiped.cli.gaits import basin, bifurcation
from mjbiped.cli.laws import taken
from mjbiped.cli.reference import reference
from mjbiped.cli.report import report
from mjbiped.cli.reproduce import reproduce
from mjbiped.cli.robots import robot_of
from mjbiped.cli.robustness import robustness
from mjbiped.cli.sweep import sweep
from mjbiped.cli.view import view
from mjbiped.cli.walkers import engine_of, mujoco_of, walker
from mjbiped.errors import MjbipedError, shortened
from mjbiped.gaits.kneed import find_kneed_gait
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.records.record import Walk
from mjbiped.robots.kinds import compass_of
from mjbiped.robots.kneed import KneedBiped
from mjbiped.rollout.walk import WalkInterrupted, WalkStopped, walk
from mjbiped.utils import domains
from mjbiped.version import __version__


class _Commands(click.Group):
    """Turns what is a user's to mend, and Ctrl-C, into a line and an exit status."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, in the order in which they stand below."""
        return list(self.commands)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command."""
        with terminable():
            try:
                with _told_shortly():
                    return super().invoke(ctx)
            except MjbipedError as error:
                end(2, str(error))
            except KeyboardInterrupt:
                end(INTERRUPTED, "interrupted")

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        """Read what stands before the command."""
        with _told_shortly():
            return super().make_context(*args, **kwargs)


@contextmanager
def _told_shortly() -> Iterator[None]:
    """Click repeats words of the command line whole, however long they are."""
    try:
        yield
    except click.UsageError as error:
        message = error.format_message()
        if len(message) <= LONGEST_LINE:
            raise
        raise click.UsageError(shortened(message, LONGEST_LINE), error.ctx) from error


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="mjbiped")
def main() -> None:
    """A laboratory for a planar compass biped that walks on unknown ground, in MuJoCo.

    \b
    Examples:
      mjbiped walk mixed --initial rest --out walk.npz --plot walk.png --video walk.mp4
      mjbiped compare mixed --plot compare.png
      mjbiped gait --slope-deg 2
      mjbiped reference --clearance 0.06 --plot reference.png
      mjbiped bifurcation --plot bifurcation.png
      mjbiped basin --slope-deg 2 --plot basin.png
      mjbiped render walk.npz --slow-motion 4
      mjbiped view random:seed=7
      mjbiped report walk.npz
      mjbiped sweep study.toml
      mjbiped robustness study.toml
      mjbiped reproduce --quick
      mjbiped compile

    `mjbiped COMMAND --help` tells more. The exit status is 0 also where the robot falls, for that is a result; 2 where
    something has to be put right, 130 after Ctrl-C, 143 after SIGTERM.
    """  # noqa: D301 (click reads the backspace)


@main.command("walk", cls=sections.SectionCommand)
@click.argument("terrain", default="mixed")
@options.walker_options
@options.engine_option
@options.record_option
@options.plot_option
@video_options.video_option
@options.printed_options
@video_options.video_options
@click.pass_context
def _walk(
    ctx: click.Context,
    /,
    out: Path | None,
    plot: Path | None,
    video: Path | None,
    json: bool,
    quiet: bool,
    **values: Any,
) -> None:
    """Let the biped walk on TERRAIN, and tell how it went.

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
    pictures = taken(ctx, values, "Video")
    video_options.check_part(pictures)
    law, ground = walker(ctx, values)
    engine = engine_of(ctx, values.pop("engine"), values)
    if video is not None and not quiet:
        _warn_without_gl()
    status, trouble = 0, ""
    try:
        done = walk(law, ground, engine=engine, progress=not quiet, **values)
    except WalkInterrupted as stop:
        done, status, trouble = stop.walk, INTERRUPTED, f"the walk was interrupted after {stop.walk.steps} steps"
    except WalkStopped as stop:
        done, status, trouble = stop.walk, 1, str(stop)
    files = Files()
    files.write("record", out, done.save)
    if trouble:
        files.fail(status, trouble + (f"; what was walked is in {out}" if files.written else ""))
    else:
        files.plot(plot, "walk:plot_walk", done)
        files.render(done, video, pictures, progress=not quiet)
    summary = done.summary()
    printed = {**summary, "settings": dict(done.settings)}
    files.end(printed, [summary], json=json, quiet=quiet)


@main.command("compare", cls=sections.SectionCommand)
@click.argument("terrain", default="mixed")
@options.walker_options
@options.records_option
@options.plot_option
@options.printed_options
@click.pass_context
def _compare(
    ctx: click.Context, /, out: Path | None, plot: Path | None, json: bool, quiet: bool, **values: Any
) -> None:
    """Let the biped walk on TERRAIN in both engines, and tell where they part, and why.

    The same controller walks in MuJoCo (contacts resolved in time) and in the hybrid engine (the paper's equations and
    impact map). TERRAIN is as for `mjbiped walk`. A fall is a result: the exit status stays 0.

    \b
    Examples:
      mjbiped compare mixed --steps 18 --plot compare.png
      mjbiped compare stairs:rise=-0.06 --replanning-delay none
      mjbiped compare slopes:change_deg=-1 --controller passivity --gain gain=20 --slope-source local
      mjbiped compare trail.csv --initial rest --json --out trail.npz
    """  # noqa: D301 (click reads the backspace)
    law, ground = walker(ctx, values)
    mujoco = mujoco_of(ctx, values)
    files = Files()

    def write(*walks: Walk) -> None:
        for record in walks:
            name = record.settings["engine"]
            files.write(f"record_{name}", None if out is None else out.with_stem(f"{out.stem}_{name}"), record.save)

    try:
        done = compare(law, ground, mujoco=mujoco, progress=not quiet, **values)
    except (WalkStopped, WalkInterrupted) as stop:
        write(*stop.before, stop.walk)
        kept = f"; what was walked is in {' and '.join(files.written.values())}" if files.written else ""
        status = 1 if isinstance(stop, WalkStopped) else INTERRUPTED
        files.fail(status, f"{stop} (engine {stop.walk.settings['engine']}){kept}")
        files.end({}, [], json=json, quiet=quiet)
    write(done.mujoco, done.hybrid)
    files.plot(plot, "comparison:plot_comparison", done)
    who = f"{done.mujoco.settings['controller']['name']} on {done.mujoco.terrain.caption}"
    files.end(done.to_dict(), [who, *tables.comparison_tables(done), Text(done.verdict)], json=json, quiet=quiet)


@main.command("gait", cls=sections.SectionCommand)
@sections.options(
    "Gait",
    ("--slope-deg", domains.SLOPE_DEG, 2.0, "Slope that it walks down."),
)
@options.robot_options
@options.plot_option
@options.json_option
@click.pass_context
def _gait(ctx: click.Context, /, slope_deg: float, plot: Path | None, json: bool, **values: Any) -> None:
    """Find the passive gait of a slope, its limit cycle and stability.

    With straight legs the swing foot passes through the ground while it is beside the stance foot; with knees it clears
    the ground.

    \b
    Examples:
      mjbiped gait --slope-deg 3 --plot cycle.pdf
      mjbiped gait --slope-deg 3 --leg-inertia 0 --hip-mass 10 --json
      mjbiped gait --robot kneed --slope-deg 2.5 --plot knees.png
    """  # noqa: D301 (click reads the backspace)
    files = Files()
    robot = robot_of(ctx, values)
    if isinstance(robot, KneedBiped):
        kneed = find_kneed_gait(robot, math.radians(slope_deg))
        files.plot(plot, "gait:plot_gait", kneed)
        summary = tables.kneed_gait_summary(kneed)
        files.end(summary, [tables.kneed_gait_table(summary)], json=json, quiet=False)
        return
    gait = find_passive_gait(compass_of(robot, "this gait"), math.radians(slope_deg))
    files.plot(plot, "gait:plot_gait", gait)
    summary = tables.gait_summary(gait)
    files.end(summary, [tables.gait_table(summary)], json=json, quiet=False)


main.add_command(reference)
main.add_command(bifurcation)
main.add_command(basin)


@main.command("stability", cls=sections.SectionCommand)
@click.argument("record", type=click.Path(path_type=Path))
@sections.options(
    "Walk",
    (
        "--controller",
        kinds.OWN_CONTROLLER,
        None,
        "Where the law is that walked, if it is one of your own: no record decides what code is loaded.",
    ),
)
@options.plot_option
@options.json_option
def _stability(record: Path, controller: str | None, plot: Path | None, json: bool) -> None:
    """Evaluate the paper's Theorem 1 along the walk of RECORD, an .npz file.

    The walk is an adaptive controller's, of either engine. docs/stability.md explains the numbers.

    \b
    Examples:
      mjbiped walk mixed --engine hybrid --no-estimate-update --out walk.npz
      mjbiped stability walk.npz --plot stability.png
      mjbiped stability mine.npz --controller mine.py:MyAdaptive
    """  # noqa: D301 (click reads the backspace)
    # SciPy's linear algebra is for this command alone
    from mjbiped.analysis.stability import recorded_controller, stability

    done = Walk.load(record)
    found = stability(done, recorded_controller(done, controller))
    files = Files()
    files.plot(plot, "stability:plot_stability", {record.stem: found})
    summary = tables.stability_summary(found)
    files.end(summary, [tables.stability_table(summary)], json=json, quiet=False)


@main.command("render", cls=sections.SectionCommand)
@click.argument("record", type=click.Path(path_type=Path))
@video_options.video_argument
@options.plot_option
@video_options.no_video_option
@options.quiet_option
@video_options.video_options
def _render(record: Path, video: Path | None, plot: Path | None, no_video: bool, quiet: bool, **pictures: Any) -> None:
    """Draw the walk of RECORD, an .npz file: a video, a figure.

    The video goes to VIDEO, an .mp4 or .gif file; if left out, an .mp4 file is named after the record and stands beside
    it.

    \b
    Examples:
      mjbiped render walk.npz
      mjbiped render walk.npz slow.mp4 --slow-motion 4 --from 10 --to 14 --camera side
      mjbiped render walk.npz walk.gif --video-size 640x360 --fps 15 --hide chart,labels
      mjbiped render walk.npz --no-video --plot walk.svg
    """  # noqa: D301 (click reads the backspace)
    if no_video and (plot is None or video is not None):
        raise click.UsageError("--no-video leaves a --plot to be drawn, and no VIDEO.")
    video_options.check_part(pictures)
    done = Walk.load(record)
    if video is None and not no_video:
        video = video_options.VIDEO_PATH(record.with_suffix(".mp4"))
    files = Files()
    files.plot(plot, "walk:plot_walk", done)
    files.render(done, video, pictures, progress=not quiet)
    files.end({}, [], json=False, quiet=quiet)


main.add_command(view)
main.add_command(report)
main.add_command(sweep)
main.add_command(robustness)
main.add_command(reproduce)
main.add_command(compile_)


def _warn_without_gl() -> None:
    """Say before a walk that its video will fail."""
    from mjbiped.rendering.gl import gl_available

    if gl_available() is None:
        click.echo("Warning: there is no OpenGL platform for the video; all else will be written.", err=True)


if __name__ == "__main__":
    main()
