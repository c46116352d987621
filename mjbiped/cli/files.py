"""Output files, printed results and exit status of a command."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

import click

from mjbiped.cli.ending import INTERRUPTED, end
from mjbiped.errors import MjbipedError, explained
from mjbiped.numerics.announcement import announce
from mjbiped.records.arrays import write_arrays

if TYPE_CHECKING:  # what prints is loaded when there are results: no help and no refused word waits for it
    from rich.console import Console, RenderableType

    from mjbiped.records.record import Walk


@dataclass
class Results:
    """Requested results of a command, the files written so far, and failures.

    One failure does not stop the next file.

    Attributes:
        out: File or folder of the results; None where it is not asked for, as the other paths.
        plot: File of a figure.
        plot_multipliers: File of a figure of multipliers.
        plot_width: Name of the figures' width, which is already set.
        panels: Panels of the figure of a walk; None for the usual ones.
        video: File of a video.
        no_video: Whether there is to be no video.
        json: Whether the results are printed as JSON.
        quiet: Whether only errors (and JSON) are printed.
        written: Paths written, by kind of file.
        failures: Messages of what failed.
    """

    out: Path | None = None
    plot: Path | None = None
    plot_multipliers: Path | None = None
    plot_width: str = ""
    panels: tuple[str, ...] | None = None
    video: Path | None = None
    no_video: bool = False
    json: bool = False
    quiet: bool = False
    written: dict[str, str] = field(default_factory=dict, init=False)
    failures: list[str] = field(default_factory=list, init=False)
    _status: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        """Let compilations be announced, or not."""
        announce(wanted=not self.quiet)

    def save_arrays(self, arrays: Mapping[str, Any]) -> None:
        """Write arrays into `out`, an .npz file."""
        self.write("data", self.out, partial(write_arrays, arrays=arrays))

    def save(self, walk: Walk) -> None:
        """Write the record of a walk into `out`, in the format that its suffix names."""
        if self.out is None or self.out.suffix == ".npz":
            self.write("record", self.out, walk.save)
            return
        from mjbiped.exchange.records import parts_of  # for these formats alone

        for kind, (file, make) in parts_of(walk, self.out).items():
            self.write(kind, file, make)

    def draw(self, function: str, *shown: object) -> None:
        """Write the figure `plot`.

        Args:
            function: Name of the function that draws it, as "module:name" in `mjbiped.plotting`. It is imported only
                here, since Matplotlib takes long to load.
            *shown: Arguments of that function before the path.
        """
        chosen = {} if self.panels is None else {"panels": self.panels}
        self.write("plot", self.plot, lambda file: resolve_name(f"mjbiped.plotting.{function}")(*shown, file, **chosen))

    def render(self, walk: Walk, pictures: dict[str, Any]) -> None:
        """Write the video of a walk; `pictures` are the options in the section "Video"."""

        def draw(file: Path) -> None:
            from mjbiped.rendering.video import render_video

            width, height = pictures["video_size"]
            settings = {name: value for name, value in pictures.items() if name != "video_size"}
            render_video(walk, file, width=width, height=height, progress=not self.quiet, **settings)

        self.write("video", self.video, draw)

    def write(self, kind: str, path: Path | None, make: Callable[[Path], None]) -> None:
        """Write a file of any kind, if one is asked for and Ctrl-C was not pressed during an earlier one."""
        if path is None or self._status == INTERRUPTED:
            return
        try:
            make(path)
        except KeyboardInterrupt:
            self.fail(INTERRUPTED, f"the {kind} {path} was not written: interrupted")
        except MjbipedError as error:
            self.fail(2, f"the {kind} {path} was not written: {error}")
        except Exception as error:  # a drawing that fails must not hide what has been computed
            self.fail(1, f"the {kind} {path} was not written: {explained(error)}")
        else:
            self.written[kind] = str(path)

    def fail(self, status: int, message: str) -> None:
        """Note a failure; the greatest status counts."""
        self.failures.append(message)
        self._status = max(self._status, status)

    def end(
        self,
        summary: Mapping[str, object],
        shown: Iterable[RenderableType] | None = None,
        files: Sequence[Path] | None = None,
    ) -> None:
        """Print the results, and end the command if there were failures.

        Args:
            summary: All results, for JSON.
            shown: Tables and sentences, a text being a line of its own, however long; a table of the results unless
                given.
            files: Files that were written; those of `written` unless given.
        """
        paths = list(self.written.values()) if files is None else [str(file) for file in files]
        if self.json:
            from mjbiped.cli.tables import as_json

            click.echo(as_json({**summary, "files": self.written if files is None else paths}))
        elif not self.quiet:
            if shown is None:
                from mjbiped.cli.tables import summary_table

                shown = [summary_table(summary)]
            for each in shown:
                if isinstance(each, str):
                    click.echo(click.format_filename(each))
                else:
                    _console().print(each)
            for path in paths:
                click.echo(f"wrote {click.format_filename(path)}")  # a name may not be valid UTF-8
        if self.failures:
            end(self._status, *self.failures)


_PIPED = 200  # characters: no line of our tables is longer


def _console() -> Console:
    """As wide as the terminal, or as COLUMNS says; in a pipe or a file so wide that no line is broken."""
    from rich.console import Console

    fits = sys.stdout.isatty() or "COLUMNS" in os.environ
    return Console(highlight=False, width=None if fits else _PIPED)
