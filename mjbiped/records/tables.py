"""Tables on a terminal, all in one style, and the summary of a walk as such a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from mjbiped.control.registry import SLOPE_FIELD
from mjbiped.records import measures
from mjbiped.records.measure_table import in_words, measures_of
from mjbiped.rules.termination import Outcome

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

_WIDTH = 100  # characters of a table as text


def bare_table(*headings: str, numbers: bool = False) -> Table:
    """Make an empty table with words to the left and numbers to the right; `numbers` tells that all are numbers."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in headings:
        words = heading in (headings[0], "unit") and not numbers
        table.add_column(heading, justify="left" if words else "right", overflow="fold")
    return table


def table_of(rows: Iterable[tuple[str, str, str]]) -> Table:
    """Make a table of rows of label, value and unit, without interpreting markup."""
    table = Table(box=box.SIMPLE, show_header=False, pad_edge=False)
    for _ in range(3):
        table.add_column(overflow="fold")
    for cells in rows:
        table.add_row(*map(Text, cells))
    return table


def html_table(rows: Iterable[tuple[str, str, str]]) -> str:
    """Write rows of label, value and unit as HTML."""
    left = "style='text-align:left'"
    lines = (
        f"<tr><th {left}>{escape(label)}</th><td {left}>{escape(value)} {escape(unit)}</td></tr>"
        for label, value, unit in rows
    )
    return f"<table>{''.join(lines)}</table>"


_FAILURES = [outcome.words for outcome in (Outcome.FELL, Outcome.STALLED, Outcome.SLIPPED, Outcome.DIVERGED)]
_AT_ONCE = 2  # steps
_FAR_OFF = math.radians(1.0)  # from the slope at the start


class WalkSummary(dict[str, Any]):
    """Measures of a walk, printed as a table, and by name as in `mjbiped.records.measures.summary`.

    Attributes:
        rows: Label, formatted value, and unit of each line of the table.
    """

    def __init__(self, walk: Walk) -> None:
        """Measure a walk."""
        super().__init__(measures.summary(walk))
        settings, warnings = walk.settings, self["warnings"]
        rows = [
            ("outcome", walk.outcome, ""),
            ("ended at", f"{self['ended_at_time_s']:.3f} s, hip at x = {self['ended_at_x_m']:.3f} m", ""),
            ("terrain", walk.terrain.caption, ""),
            ("controller", f"{settings['controller']['name']}, engine {settings['engine']}", ""),
        ]
        if cause := _cause(walk):
            rows.append(("probable cause", cause, ""))
        if settings.get("disturbances"):
            rows.append(("disturbances", _in_words(settings["disturbances"]), ""))
        if warnings:
            texts = (f"{text} ({n} times)" if n > 1 else text for text, n in warnings.items())
            rows.append(("warning", "; ".join(texts), ""))
        rows += [
            (label, in_words(self[key], factor, form), "" if self[key] is None else unit)
            for label, key, factor, form, unit, *_ in measures_of(type(walk.robot))
        ]
        self.rows = tuple(rows)

    def __rich__(self) -> Table:
        """Return the table for Rich."""
        return table_of(self.rows)

    def __str__(self) -> str:
        """Return the table as text."""
        text = StringIO()
        Console(file=text, width=_WIDTH, color_system=None, highlight=False, force_jupyter=False).print(self)
        return "\n".join(line.rstrip() for line in text.getvalue().strip("\n").splitlines())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the table for a notebook."""
        return html_table(self.rows)


def _cause(walk: Walk) -> str:
    """Say what was wrong at the start of a walk that fell at once: the slope estimate that its controller was given."""
    estimate = walk.settings["controller"].get(SLOPE_FIELD)
    if estimate is None or walk.outcome not in _FAILURES or walk.steps > _AT_ONCE:
        return ""
    slope = walk.terrain.slope_at(0.0)
    if abs(slope - estimate) < _FAR_OFF:
        return ""
    degrees = math.degrees(slope)
    return (
        f"it starts on {degrees:.1f}° with a slope estimate of {math.degrees(estimate):.1f}°; give "
        f"--initial-slope-estimate-deg {degrees:.3g}, in Python {SLOPE_FIELD}={slope:.4g}"
    )


def _in_words(disturbances: Mapping[str, object]) -> str:
    """Describe the disturbances in one line."""
    forms: dict[str, Callable[[Any], object]] = {"pushes": len, "seed": str}
    values = ((name, forms.get(name, "{:g}".format)(value)) for name, value in disturbances.items())
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values)
