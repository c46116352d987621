"""The files that a command writes, and how a command ends."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from types import FrameType
from typing import Any, NoReturn

import click
from rich.console import Console, RenderableType

from mjbiped.cli.tables import as_json
from mjbiped.errors import MjbipedError, explained, shortened
from mjbiped.records.arrays import write_arrays
from mjbiped.records.record import Walk

INTERRUPTED, TERMINATED = 130, 143
"""Exit status after Ctrl-C and after SIGTERM, as shells have it."""

LONGEST_LINE = 1000
"""Characters of an error, at most."""


class Files:
    """Files that a command has written, and what went wrong on the way; one failure does not stop the next file.

    Attributes:
        written: Paths by kind of file.
        failures: Messages.
    """

    def __init__(self) -> None:
        """Begin with none."""
        self.written: dict[str, str] = {}
        self.failures: list[str] = []
        self._status = 0

    def save_arrays(self, path: Path | None, arrays: Mapping[str, Any]) -> None:
        """Write arrays, an .npz file."""
        self.write("data", path, partial(write_arrays, arrays=arrays))

    def plot(self, path: Path | None, function: str, *shown: object) -> None:
        """Write a figure.

        Args:
            path: Its file; None where no figure is asked for.
            function: What draws it, as "module:name" in `mjbiped.plotting`. It is imported only where it is used, for
                Matplotlib takes long to load, and called with what is shown and then the path.
            *shown: What the figure is of.
        """
        self.write("plot", path, lambda file: resolve_name(f"mjbiped.plotting.{function}")(*shown, file))

    def render(self, walk: Walk, path: Path | None, pictures: dict[str, Any], *, progress: bool) -> None:
        """Write a video of a walk; `pictures` are the values of `mjbiped.cli.video_options.video_options`."""

        def draw(file: Path) -> None:
            from mjbiped.rendering.video import render_video

            width, height = pictures["video_size"]
            settings = {name: value for name, value in pictures.items() if name != "video_size"}
            render_video(walk, file, width=width, height=height, progress=progress, **settings)

        self.write("video", path, draw)

    def write(self, kind: str, path: Path | None, make: Callable[[Path], None]) -> None:
        """Write a file of any kind, if one is asked for and Ctrl-C has not been pressed while another was written."""
        if path is None or self._status == INTERRUPTED:
            return
        try:
            make(path)
        except KeyboardInterrupt:
            self.fail(INTERRUPTED, f"the {kind} {path} was not written: interrupted")
        except MjbipedError as error:
            self.fail(2, f"the {kind} {path} was not written: {error}")
        except Exception as error:  # whatever a drawing fails of must not hide what has been computed
            self.fail(1, f"the {kind} {path} was not written: {explained(error)}")
        else:
            self.written[kind] = str(path)

    def fail(self, status: int, message: str) -> None:
        """Note a failure; the greatest status counts."""
        self.failures.append(message)
        self._status = max(self._status, status)

    def end(self, summary: Mapping[str, Any], shown: Iterable[RenderableType], *, json: bool, quiet: bool) -> None:
        """Print what came of the command, as `tell`, and end it, with its failures if there are any."""
        tell({**summary, "files": self.written}, shown, self.written.values(), json=json, quiet=quiet)
        if self.failures:
            end(self._status, *self.failures)


def tell(
    summary: Mapping[str, Any], shown: Iterable[RenderableType], files: Iterable[object], *, json: bool, quiet: bool
) -> None:
    """Print what came of a command on the standard output.

    Args:
        summary: All of it, for machines.
        shown: Tables and sentences, for people; a text is a line of its own however long it is.
        files: That were written.
        json: Whether machines read it.
        quiet: Whether people want none of it.
    """
    if json:
        click.echo(as_json(summary))
    elif not quiet:
        for each in shown:
            if isinstance(each, str):
                click.echo(click.format_filename(each))
            else:
                Console(highlight=False).print(each)
        for file in files:
            click.echo(f"wrote {click.format_filename(str(file))}")  # its name may be no UTF-8


@contextmanager
def terminable() -> Iterator[None]:
    """Let SIGTERM do what Ctrl-C does, with an exit status of its own: what has been done is kept, and told.

    A second one ends the process at once.
    """
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL:
        yield  # somebody else's to decide
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
