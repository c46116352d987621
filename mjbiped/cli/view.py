"""The command `mjbiped view`: a walk in a window, live or from its record."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from mjbiped.cli import kinds, options, sections
from mjbiped.cli.ending import end
from mjbiped.cli.sections import refuse, taken
from mjbiped.cli.walkers import mujoco_of, next_ground, walker
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.errors import shown
from mjbiped.records.record import Walk
from mjbiped.rendering.look import ALL, look
from mjbiped.rollout.walk import WalkStopped
from mjbiped.utils import domains
from mjbiped.viewing.player import KEYS, MOUSE, Player

if TYPE_CHECKING:  # the help does not need it
    from mjbiped.viewing.sources import Source

_VIEW = "View"
_MARKS = ("torque", "force", "ghost", "estimate", "traces", "shadows", "caption")
_RECORD = ".npz"


class _KeysInHelp(sections.SectionCommand):
    """A command whose help ends with the keys of the window."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, then the keys and the mouse."""
        super().format_options(ctx, formatter)
        with formatter.section("Keys and mouse in the window"):
            formatter.write_dl([*((key.name, key.does) for key in KEYS.values()), *MOUSE.items()])


class _Window:
    """Options of the window.

    Attributes:
        slow_motion: Seconds in the window per second of the walk, at the start.
        hide: Elements to hide, separated by commas: {marks}.
        flags: A visual flag of MuJoCo to set at first, such as contactforce; with no- before it to clear; may be
            repeated.
        seconds: Time after which the window closes, s.
    """

    slow_motion = domains.SLOW_MOTION, 1.0
    hide = kinds.HIDDEN, ()
    flags = kinds.VISUAL_FLAG, (), "--flag flags"
    seconds = domains.TIME, None, "--for seconds"


@click.command("view", cls=_KeysInHelp)
@click.argument("what", metavar="[TERRAIN | RECORD]", default="mixed")
@sections.options(_VIEW, *sections.rows_of(_Window, marks=f"{', '.join(_MARKS)}, or {ALL}"))
@options.walker_options
@click.pass_context
def view(ctx: click.Context, /, what: str, **values: object) -> None:
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
    settings = taken(ctx, values, _VIEW)
    from mjbiped.viewing.sources import Replay  # for this command alone
    from mjbiped.viewing.window import ground, require_screen, view

    if what.endswith(_RECORD):
        walks = [each for each in ctx.command.params if getattr(each, "section", _VIEW) != _VIEW]
        refuse(ctx, walks, "walks that are made", f"the record {shown(what)}")
        make: Callable[[], Source] = partial(Replay, Walk.load(what))
    else:
        make = _live(ctx, what, values)
    require_screen()
    player = Player(make(), speed=1.0 / settings["slow_motion"])
    try:
        view(player, look(settings["hide"], settings["flags"]), seconds=settings["seconds"])
    except WalkStopped as stop:
        end(1, str(stop))
    finally:
        player.source.close()
    source, moment = player.source, player.source.moment()
    told = f"closed at {moment.time:.2f} s, step {moment.step}, of the walk on {ground(source.terrain)}"
    click.echo(f"{told}: {source.ended or 'walking'}")


def _live(ctx: click.Context, text: str, values: dict[str, Any]) -> Callable[[], Source]:
    """Check the options of a walk, and return a function that starts it."""
    from mjbiped.viewing.sources import LiveWalk

    seed = values["seed"]
    values["terrain"] = text
    controller, terrain = walker(ctx, values)
    engine = mujoco_of(ctx, values)
    initial = values.pop("initial")
    disturbances = values.pop("disturbances")
    terms = Terms(engine, sample_period=None, **values)
    plan = make_plan(terms, controller, terrain, initial, disturbances=disturbances)
    grounds = next_ground(text, seed)
    if grounds is None:
        return partial(LiveWalk, plan)
    same = (initial, plan.description, disturbances)
    return partial(LiveWalk, plan, lambda: make_plan(terms, controller, grounds(), *same))
