"""What a command leaves: printed results, output files, and the exit status."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any

import click

from mjbiped.cli import options
from mjbiped.cli.commands import filled
from mjbiped.cli.main import INTERRUPTED, end
from mjbiped.errors import MjbipedError, explained
from mjbiped.exchange import parts_of
from mjbiped.numerics.cache import announce
from mjbiped.plotting import DEFAULT_WIDTH, WIDTHS, figure_width
from mjbiped.records.summary import table_of
from mjbiped.utils.domains import Words

if TYPE_CHECKING:  # what prints is loaded when there are results: no help and no refused word waits for it
    from rich.console import RenderableType
    from rich.table import Table

    from mjbiped.records.record import Walk

Summary = dict[str, Any]
"""Results in plain JSON types, by names that end with the unit, if there is one."""

_PIPED = 200  # characters: no line of our tables is longer


@dataclass
class Results:
    """Results that are printed, the files written so far, and failures; one does not stop the next file.

    Results:
        json: Print the results as JSON instead of a table.
        quiet: Print errors only, and JSON if asked for.
    """

    json: bool = False
    quiet: bool = False
    written: dict[str, str] = field(default_factory=dict, init=False)
    """Paths written, by kind of file."""
    failures: list[str] = field(default_factory=list, init=False)
    """Messages of what failed."""
    status: int = field(default=0, init=False)
    """The exit status."""

    def __post_init__(self) -> None:
        """Let compilations be announced, or not."""
        announce(wanted=not self.quiet)

    def write(self, kind: str, path: Path | None, make: Callable[[Path], None]) -> None:
        """Write a file of any kind, if one is asked for and Ctrl-C was not pressed during an earlier one."""
        if path is None or self.status == INTERRUPTED:
            return
        try:
            make(path)
        except KeyboardInterrupt:
            self.fail(INTERRUPTED, f"the {kind} {path} was not written: interrupted")
        except Exception as error:  # a drawing that fails must not hide what has been computed
            mistake = isinstance(error, MjbipedError)
            self.fail(
                2 if mistake else 1, f"the {kind} {path} was not written: {error if mistake else explained(error)}"
            )
        else:
            self.written[kind] = str(path)

    def save(self, walk: Walk, path: Path | None) -> None:
        """Write the record of a walk, if it is asked for, in the format that the suffix names."""
        for kind, (file, make) in (parts_of(walk, path) if path else {}).items():
            self.write(kind, file, make)

    def fail(self, status: int, message: str) -> None:
        """Note a failure; the greatest status counts."""
        self.failures.append(message)
        self.status = max(self.status, status)

    def stopped(self, stop: BaseException, kept: str) -> None:
        """Note that a computation was interrupted or failed, and what is kept of it."""
        self.fail(INTERRUPTED if isinstance(stop, KeyboardInterrupt) else 1, f"{str(stop) or 'interrupted'}{kept}")

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
            click.echo(as_json({**summary, "files": self.written if files is None else paths}))
        elif not self.quiet:
            for each in (*([summary_table(summary)] if shown is None else shown), *(f"wrote {path}" for path in paths)):
                _print(each)
        if self.failures:
            end(self.status, *self.failures)


@filled(widths=", ".join(f"{name} {width.inches:g} in" for name, width in WIDTHS.items()))
@dataclass
class Figures(Results):
    """Results with figures.

    Results:
        plot_width: Width of figures: {widths}; page is for the screen, double and single are columns in print, slide is
            16:9.
    """

    plot_width: Annotated[str, Words(tuple(WIDTHS))] = DEFAULT_WIDTH

    def __post_init__(self) -> None:
        """Set the width of all figures until the command ends."""
        super().__post_init__()
        click.get_current_context().with_resource(figure_width(self.plot_width))


@dataclass
class Plotted(Figures):
    """Results with a figure.

    Results:
        plot: Write a figure, .png, .pdf or .svg.
    """

    plot: Annotated[Path | None, options.PLOT] = None

    def draw(self, function: str, *shown: object, **settings: object) -> None:
        """Write the figure.

        Args:
            function: Name of the function that draws it, as "module:name" in `mjbiped.plotting`. It is imported only
                here, since Matplotlib takes long to load.
            *shown: Arguments of that function before the path.
            **settings: Its arguments by name.
        """
        self.write(
            "plot", self.plot, lambda file: resolve_name(f"mjbiped.plotting.{function}")(*shown, file, **settings)
        )


@dataclass
class Drawn(Plotted):
    """Results with the figure of a walk.

    Results:
        panels: Panels of the figure, as torque,phase; all that have values unless given.
    """

    panels: Annotated[tuple[str, ...] | None, options.PANELS] = None

    def draw_walk(self, walk: Walk) -> None:
        """Write the figure of a walk."""
        self.draw("walk:plot_walk", walk, panels=self.panels)


def _print(result: RenderableType) -> None:
    """Print a table as wide as the terminal, or as COLUMNS says; in a pipe so wide that no line is broken."""
    if isinstance(result, str):
        click.echo(click.format_filename(result))  # a name may not be valid UTF-8
        return
    from rich.console import Console

    fits = sys.stdout.isatty() or "COLUMNS" in os.environ
    Console(highlight=False, width=None if fits else _PIPED).print(result)


_UNITS = {"m_per_s": "m/s", "Nm": "N m", "weights": "weights", "deg": "deg", "rad": "rad", "m": "m", "s": "s", "J": "J"}
"""Units by the ends of names."""


def summary_table(summary: Mapping[str, object]) -> Table:
    """Return a table of results: a row for each name, which ends with the unit, and for each part of a mapping."""
    rows = []
    for name, value in summary.items():
        end = next((end for end in _UNITS if name.endswith(f"_{end}")), "")
        label, unit = name.removesuffix(f"_{end}").replace("_", " "), _UNITS.get(end, "")
        if isinstance(value, Mapping):
            rows += [(f"{label}, {part}", cell(each), unit) for part, each in value.items()]
        elif isinstance(value, list) and any(isinstance(each, list | Mapping) for each in value):
            rows += [(label, cell(each), unit) for each in value]
        else:
            rows.append((label, cell(value), unit))
    return table_of(rows)


def cell(value: object) -> str:
    """Write a result; a dash stands for one that does not exist."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {cell(each)}" for name, each in value.items())
    if isinstance(value, list):
        return ", ".join(map(cell, value))
    if value is None or isinstance(value, bool):
        return {None: "-", True: "yes", False: "no"}[value]
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def as_json(values: Mapping[str, object]) -> str:
    """Write values as a JSON object; infinity and NaN, which JSON does not have, become null."""
    plain = json.loads(json.dumps(values), parse_constant=lambda _: None)
    return json.dumps(plain, indent=2, allow_nan=False)
