"""The command line: imports a command when it is called, and turns its end into a message and an exit status.

Exit status: 0 for a walk that came to an end, a fall included; 2 for anything that the user can correct, with one line
that says how; 1 for any other failed walk or drawing; 130 after Ctrl-C, 143 after SIGTERM.
"""

from __future__ import annotations

import signal
import threading
from collections import UserDict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from pkgutil import resolve_name
from types import FrameType
from typing import Any, NoReturn

import click

from mjbiped.errors import MjbipedError, shortened
from mjbiped.version import __version__

INTERRUPTED, TERMINATED = 130, 143
"""Exit status after Ctrl-C and after SIGTERM, as shells have it."""

LONGEST_LINE = 1000
"""Greatest number of characters in an error message."""

_COMMANDS = {
    name: f"{module}:{name.replace('-', '_')}"
    for module, names in {
        "walks": "walk compare render view",
        "gaits": "gait reference stability",
        "maps": "return-map bifurcation basin",
        "lateral": "lateral-basin",
        "export": "export report figures",
        "studies": "sweep robustness reproduce compile",
    }.items()
    for name in names.split()
}
"""Where each command is, as "module:name" of this package."""


@contextmanager
def terminable() -> Iterator[None]:
    """Let SIGTERM act like Ctrl-C with an exit status of its own: what has been done is kept, and reported.

    A second SIGTERM ends the process at once.
    """
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL:
        yield  # the calling program handles signals
        return
    received = []

    def interrupt(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    except click.exceptions.Exit as stop:
        if received:
            raise click.exceptions.Exit(TERMINATED) from stop
        raise
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def end(status: int, *messages: str) -> NoReturn:
    """Print errors and end with an exit status."""
    for message in messages:
        click.echo(f"Error: {shortened(' '.join(message.splitlines()), LONGEST_LINE)}", err=True)
    raise click.exceptions.Exit(status)


def _sentence(place: str) -> str:
    """Return the first line of a command's docstring from its source: an import would take a second."""
    module, name = place.split(":")
    source = Path(__file__).with_name(f"{module}.py").read_text(encoding="utf-8")
    return source.partition(f"\ndef {name}(")[2].partition('"""')[2].partition("\n")[0]


class _ByName(UserDict[str, Any]):
    """The commands by their names; each is imported when it is looked up."""

    def __getitem__(self, name: str) -> Any:
        """Import a command."""
        return resolve_name(f"mjbiped.cli.{self.data[name]}")


class _Commands(click.Group):
    """Group of commands that turns user errors and Ctrl-C into one line and an exit status."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, in the order in which the help lists them."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands into the help, without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, _sentence(place)) for name, place in _COMMANDS.items()])

    def invoke(self, ctx: click.Context) -> object:
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
        """Read the options before the command."""
        with _told_shortly():
            return super().make_context(*args, **kwargs)


@contextmanager
def _told_shortly() -> Iterator[None]:
    """Shorten click's messages, which repeat words of the command line however long they are."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:  # its message is the whole help
        raise
    except click.UsageError as error:
        message = error.format_message()
        if len(message) <= LONGEST_LINE:
            raise
        raise click.UsageError(shortened(message, LONGEST_LINE), error.ctx) from error


@click.group(
    cls=_Commands,
    commands=_ByName(_COMMANDS),
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(__version__, prog_name="mjbiped")
def main() -> None:
    """A laboratory for bipeds, planar and in space, that walk on unknown ground, in MuJoCo.

    \b
    Examples:
      mjbiped walk mixed --initial rest --out walk.npz --plot walk.png --video walk.mp4
      mjbiped compare mixed --plot compare.png
      mjbiped gait --slope-deg 2
      mjbiped reference --clearance 0.06 --plot reference.png
      mjbiped return-map --slope-deg 3.2 --plot map.png
      mjbiped bifurcation --plot bifurcation.png
      mjbiped basin --slope-deg 2 --plot basin.png
      mjbiped figures slides
      mjbiped render walk.npz --slow-motion 4
      mjbiped export walk.npz walk.mcap
      mjbiped view random:seed=7
      mjbiped report walk.npz
      mjbiped sweep study.toml
      mjbiped robustness study.toml
      mjbiped reproduce --quick
      mjbiped compile

    `mjbiped COMMAND --help` describes a command. The exit status is 0 even if the robot falls, which is a result; 2 if
    the input has to be corrected, 130 after Ctrl-C, 143 after SIGTERM.
    """  # noqa: D301 (click reads the backspace)


if __name__ == "__main__":
    main()
