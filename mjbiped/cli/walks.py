"""The commands `walk`, `compare`, `render` and `view`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click
import numpy as np

import mjbiped
from mjbiped.cli import options
from mjbiped.cli.commands import Choice, Command, Given, command, filled, to_write
from mjbiped.cli.main import end
from mjbiped.cli.options import Video
from mjbiped.cli.results import Drawn, Plotted
from mjbiped.cli.walkers import engine_of, mujoco_of, next_ground, walker
from mjbiped.engines.base import DEFAULT_ENGINE, ENGINES
from mjbiped.errors import shown
from mjbiped.records.summary import MEASURES, in_words, table_of
from mjbiped.rendering import ALL, look
from mjbiped.utils import domains

if TYPE_CHECKING:  # the help does not need it
    from rich.table import Table

    from mjbiped.viewing.sources import Source


@command("walk")
def walk(
    terrain: str = "mixed",
    /,
    *,
    walker_options: Annotated[Given, options.WALKER],
    engine: Annotated[str, options.ENGINE] = DEFAULT_ENGINE,
    out: Annotated[Path | None, options.RECORD] = None,
    results: Drawn,
    video: Annotated[Path | None, options.VIDEO] = None,
    pictures: Video,
) -> None:
    """Simulate a walk on TERRAIN, and report how it went.

    TERRAIN is a preset, a preset with parameters, or a file; "mixed" if left out. Slopes are positive downhill, steps
    positive up. A file is a .csv of elevations, columns x,z in m, or a .toml or .yaml with segments = [[length_m,
    slope_deg, step_m], ...].

    Walk:
        engine: Engine of the simulation: MuJoCo with contacts, or 'hybrid' with the paper's equations and impact map.

    Results:
        out: Write the record, an .npz file, which other commands read; or .csv, .parquet or .mcap for other programs.
        video: Write a video, .mp4 or .gif, with the options under "Video".

    \b
    Presets: level, incline, slopes, stairs, mixed, random, treads, waves, bumps, recorded; with parameters:
      stairs:rise=-0.06,tread=1.8    slopes:change_deg=-1    random:slope_deg=-2..2

    \b
    Examples:
      mjbiped walk mixed --initial rest --out walk.npz --video walk.mp4
      mjbiped walk stairs:rise=-0.02 --replanning-delay none --json
      mjbiped walk incline:slope_deg=2 --controller passive --distance 20
      mjbiped walk slopes --controller energy-constraint --gain ratio=-2 --gain gain=20
      mjbiped walk trail.csv --steps 200 --plot trail.pdf
      mjbiped walk stairs:rise=0.04 --robot kneed --engine hybrid --plot knees.png
      mjbiped walk bumps:seed=3 --robot compass3d --steps 20 --video space.mp4
      mjbiped walk trail.csv --controller spread.py:HipSpread --gain stiffness=25 --initial rest
    """  # noqa: D301 (click reads the backspace)
    law, ground = walker(terrain, walker_options)
    physics = engine_of(engine, walker_options)
    if video is not None and not results.quiet and _no_gl():
        click.echo("Warning: there is no OpenGL platform for the video; all else will be written.", err=True)
    stop: mjbiped.WalkInterrupted | mjbiped.WalkStopped | None = None
    try:
        done = mjbiped.walk(law, ground, engine=physics, progress=not results.quiet, **walker_options)
    except (mjbiped.WalkInterrupted, mjbiped.WalkStopped) as error:
        stop, done = error, error.walk
    done = replace(done, settings={**done.settings, "command": click.get_current_context().obj})
    results.save(done, out)
    if stop is not None:
        results.stopped(stop, f"; what was walked is in {out}" if results.written else "")
    else:
        results.draw_walk(done)
        results.write("video", video, partial(pictures.render, done, progress=not results.quiet))
    summary = done.summary()
    results.end({**summary, "settings": dict(done.settings)}, [summary])


@command("compare")
def compare(
    terrain: str = "mixed",
    /,
    *,
    walker_options: Annotated[Given, options.WALKER],
    out: Annotated[Path | None, options.DATA] = None,
    results: Plotted,
) -> None:
    """Simulate a walk on TERRAIN in both engines, and report where they diverge and why.

    The same controller walks in MuJoCo (contacts resolved in time) and in the hybrid engine (the paper's equations and
    impact map). TERRAIN is as for `mjbiped walk`. A fall is a result: the exit status stays 0.

    Results:
        out: Write both records: a.npz gives a_mujoco.npz and a_hybrid.npz.

    \b
    Examples:
      mjbiped compare mixed --steps 18 --plot compare.png
      mjbiped compare stairs:rise=-0.06 --replanning-delay none
      mjbiped compare slopes:change_deg=-1 --controller passivity --gain gain=20 --slope-source local
      mjbiped compare trail.csv --initial rest --json --out trail.npz
    """  # noqa: D301 (click reads the backspace)
    law, ground = walker(terrain, walker_options)
    mujoco = mujoco_of(walker_options)

    def write(*walks: mjbiped.Walk) -> None:
        for record in walks:
            name = record.settings["engine"]
            results.write(f"record_{name}", out and out.with_stem(f"{out.stem}_{name}"), record.save)

    try:
        done = mjbiped.compare(law, ground, mujoco=mujoco, progress=not results.quiet, **walker_options)
    except (mjbiped.WalkStopped, mjbiped.WalkInterrupted) as stop:
        write(*stop.before, stop.walk)
        kept = f"; what was walked is in {' and '.join(results.written.values())}" if results.written else ""
        results.stopped(stop, f" (engine {stop.walk.settings['engine']}){kept}")
        results.end({}, [])
    write(done.mujoco, done.hybrid)
    results.draw("comparison:plot_comparison", done)
    who = f"{done.mujoco.settings['controller']['name']} on {done.mujoco.terrain.caption}"
    results.end(done.to_dict(), [who, *_comparison_tables(done), done.verdict])


def _comparison_tables(found: mjbiped.Comparison) -> Iterator[Table]:
    """Show both engines' measures side by side, and their largest differences at a touchdown with the limits."""
    from mjbiped.analysis.divergence import COLUMNS, DISPLAYED

    measures = found.measures()
    sides = [["outcome", *(measures["outcome"][engine] for engine in ENGINES), "", "", ""]]
    for label, key, factor, form, unit, _ in MEASURES:
        row = measures[key]
        difference, percent = (
            in_words(row["difference"], factor, "+.3g"),
            in_words(row["difference_percent"], 1, "+.2f"),
        )
        sides.append([label, *(in_words(row[engine], factor, form) for engine in ENGINES), difference, percent, unit])
    yield table_of(sides, "", "MuJoCo", "hybrid", "difference", "%", "unit")
    steps, table = [], found.touchdowns
    for name, column in COLUMNS.items():
        sizes, (factor, unit) = abs(table[name]), DISPLAYED[column.unit]
        if not np.isnan(sizes).all():  # as it is without a touchdown
            k = int(np.nanargmax(sizes))
            numbers = f"{factor * table[name][k]:+.3g}", str(k + 1), f"{factor * table[f'limit_{name}'][k]:.3g}"
            steps.append([column.meaning, *numbers, unit])
    yield table_of(steps, "largest difference at a touchdown", "", "at", "limit", "unit")


@command("render")
def render(
    record: Annotated[Path, options.FILE],
    video: Annotated[Path | None, options.VIDEO] = None,
    /,
    *,
    results: Drawn,
    no_video: bool = False,
    pictures: Video,
) -> None:
    """Draw a video or a figure of the walk in RECORD, an .npz file.

    The video goes to VIDEO, an .mp4 or .gif file; if left out, to an .mp4 file beside the record, with its name.

    Results:
        no_video: Write the figure only.

    \b
    Examples:
      mjbiped render walk.npz
      mjbiped render walk.npz slow.mp4 --slow-motion 4 --start 10 --stop 14 --camera side
      mjbiped render walk.npz walk.gif --video-size 640x360 --fps 15 --hide chart,labels
      mjbiped render walk.npz --no-video --plot walk.svg
    """  # noqa: D301 (click reads the backspace)
    if no_video and (results.plot is None or video is not None):
        raise click.UsageError("--no-video needs a --plot to draw, and takes no VIDEO.")
    done = mjbiped.Walk.load(record)
    results.draw_walk(done)
    if not no_video:
        file = video or to_write(record.with_suffix(".mp4"), ".mp4")
        results.write("video", file, partial(pictures.render, done, progress=not results.quiet))
    results.end({}, [])


def _no_gl() -> bool:
    """Whether a video will fail."""
    from mjbiped.rendering.gl import gl_available

    return gl_available() is None


@filled(marks=f"torque, force, ghost, estimate, traces, shadows, caption, or {ALL}")
@dataclass
class Window:
    """What the window shows.

    View:
        slow_motion: Seconds in the window per second of the walk, at the start.
        hide: Elements to hide, separated by commas: {marks}.
        flags: A visual flag of MuJoCo to set at the start, such as contactforce; with no- before it to clear; may be
            repeated.
        seconds: Time after which the window closes, s.
    """

    slow_motion: Annotated[float, domains.SLOW_MOTION] = 1.0
    hide: Annotated[tuple[str, ...], Choice("NAMES")] = ()
    flags: Annotated[tuple[str, ...], Choice("NAME"), "flag"] = ()
    seconds: Annotated[float | None, domains.TIME, "for"] = None


class _KeysInHelp(Command):
    """A command whose help ends with the keys of the window."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, then the keys and the mouse."""
        from mjbiped.viewing import KEYS, MOUSE

        super().format_options(ctx, formatter)
        with formatter.section("Keys and mouse in the window"):
            formatter.write_dl([*((key.name, key.does) for key in KEYS.values()), *MOUSE.items()])


@partial(_KeysInHelp, "view")
def view(
    what: Annotated[str, str, "[TERRAIN | RECORD]"] = "mixed",
    /,
    *,
    window: Window,
    walker_options: Annotated[Given, options.WALKER],
) -> None:
    """Watch the biped walk on TERRAIN in a window, and push it; or watch the walk of RECORD, an .npz file, again.

    The window is MuJoCo's viewer. As long as nobody pushes, the walk is that of `mjbiped walk` in MuJoCo, with the same
    options. TERRAIN is as for `mjbiped walk`. Without a screen use `mjbiped render`. On macOS the window needs MuJoCo's
    own Python: mjpython -m mjbiped view.

    \b
    Examples:
      mjbiped view
      mjbiped view random:seed=7 --slow-motion 4
      mjbiped view incline:slope_deg=2 --controller passive --flag contactforce
      mjbiped view walk.npz --hide ghost,traces
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.viewing import Player
    from mjbiped.viewing.sources import Replay
    from mjbiped.viewing.window import ground, require_screen, view

    shows = look(window.hide, window.flags)
    if what.endswith(".npz"):
        walker_options.refuse(walker_options, "walks that are made", f"the record {shown(what)}")
        make: Callable[[], Source] = partial(Replay, mjbiped.Walk.load(what))
    else:
        make = _live(what, walker_options)
    require_screen()
    player = Player(make(), speed=1.0 / window.slow_motion)
    try:
        view(player, shows, seconds=window.seconds)
    except mjbiped.WalkStopped as stop:
        end(1, str(stop))
    finally:
        player.source.close()
    source, moment = player.source, player.source.moment()
    told = f"closed at {moment.time:.2f} s, step {moment.step}, of the walk on {ground(source.terrain)}"
    click.echo(f"{told}: {source.ended or 'walking'}")


def _live(text: str, given: Given) -> Callable[[], Source]:
    """Check the options of a walk, and return a function that starts it."""
    from mjbiped.engines.plan import Terms, make_plan
    from mjbiped.viewing.sources import LiveWalk

    grounds = next_ground(text, given.get("seed"))
    controller, terrain = walker(text, given)
    terms = Terms(mujoco_of(given), given.get("steps"), given.get("distance"), given["robot"], None, given["scuffing"])
    initial, disturbances = given.get("initial", "gait"), given["disturbances"]
    plan = make_plan(terms, controller, terrain, initial, disturbances=disturbances)
    if grounds is None:
        return partial(LiveWalk, plan)
    return partial(
        LiveWalk, plan, lambda: make_plan(terms, controller, grounds(), initial, plan.description, disturbances)
    )
