"""A walk's summary: labels, formats and displayed units of its measures, and the summary as a table.

Tables on a terminal all have one style, which begins here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any, NamedTuple

from mjbiped.records import measures
from mjbiped.records.ending import unfinished_step, why_it_failed
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.utils.domains import annotated

if TYPE_CHECKING:
    from rich.table import Table

    from mjbiped.records.record import Walk

Row = tuple[str, str, str]
"""Label, formatted value, and unit."""

OF_STANCE_KNEE = ("peak_stance_knee_torque_Nm", "cost_of_transport_stance_knee")
"""Keys of the measures of the stance knee of a robot with knees. The torque of a lock is known from samples alone."""

_WIDTH = 100  # characters of a table as text


class Measure(NamedTuple):
    """How a measure of `mjbiped.records.measures.summary` is displayed.

    Attributes:
        label: Name in words.
        key: Name in the summary.
        factor: Factor to the displayed unit.
        form: Format of the number.
        unit: The displayed unit; empty for a pure number.
        joint: Joint that a robot with the measure has; empty for a measure of all robots.
    """

    label: str
    key: str
    factor: float
    form: str
    unit: str
    joint: str = ""


_MEASURES = (
    Measure("steps", "steps", 1, "d", ""),
    Measure("distance", "distance_m", 1, ".3f", "m"),
    Measure("last touchdown at", "time_s", 1, ".3f", "s"),
    Measure("speed", "speed_m_per_s", 1, ".4f", "m/s"),
    Measure("step length, mean", "mean_step_length_m", 1, ".4f", "m"),
    Measure("step period, mean", "mean_step_period_s", 1, ".4f", "s"),
    Measure("cost of transport, absolute", "cost_of_transport", 1, ".4f", ""),
    Measure("cost of transport, net", "cost_of_transport_net", 1, ".4f", ""),
    Measure("cost of transport, positive", "cost_of_transport_positive", 1, ".4f", ""),
    Measure("peak torque, ankle", "peak_ankle_torque_Nm", 1, ".2f", "N m", "ankle"),
    Measure("peak torque, hip", "peak_hip_torque_Nm", 1, ".2f", "N m", "hip"),
    Measure("peak torque, swing knee", "peak_knee_torque_Nm", 1, ".2f", "N m", "knee"),
    Measure("peak torque, stance knee", OF_STANCE_KNEE[0], 1, ".2f", "N m", "knee"),
    Measure("cost of transport, stance knee's part", OF_STANCE_KNEE[1], 1, ".4f", "", "knee"),
    Measure("peak torque, abduction", "peak_abduction_torque_Nm", 1, ".2f", "N m", "abduction"),
    Measure("peak torque, ankle roll", "peak_ankle_roll_torque_Nm", 1, ".2f", "N m", "ankle_roll"),
    Measure("cost of transport, ankle roll's part", "cost_of_transport_roll", 1, ".4f", "", "ankle_roll"),
    Measure("estimate error at touchdown, largest", "estimate_error_at_touchdown_deg", 1, ".4f", "deg"),
    Measure("estimate error at step end, largest", "estimate_error_at_step_end_deg", 1, ".4f", "deg"),
    Measure("final estimate error", "final_estimate_error_deg", 1, ".4f", "deg"),
    Measure("impact against the impact map, worst", "largest_impact_error", 1e2, ".3f", "%"),
    Measure("slip, largest", "largest_slip_m", 1e3, ".4f", "mm"),
    Measure("penetration, largest", "largest_penetration_m", 1e3, ".4f", "mm"),
    Measure("stance friction used, largest", "largest_stance_friction", 1, ".3f", ""),
    Measure("normal force on the stance foot, least", "least_normal_force_weights", 1, ".3f", "weights"),
    Measure("steps in which the ground would have to pull", "steps_that_pull", 1, "d", ""),
    Measure("steps that violate the contact (pull, or friction over 0.8)", "steps_violating_contact", 1, "d", ""),
    Measure("centre of pressure, ahead of the ankle at most", "pressure_ahead_m", 1e2, ".2f", "cm"),
    Measure("centre of pressure, behind it at most", "pressure_behind_m", 1e2, ".2f", "cm"),
    Measure("foot that holds it 99 % of the time, length", "foot_length_99_percent_m", 1e2, ".1f", "cm"),
    Measure("time in which the sole transmits less than asked", "share_of_time_at_sole_bound", 1e2, ".1f", "%"),
    Measure("impacts on vertical faces", "strikes", 1, "d", ""),
)


def measures_of(robot: type[Robot]) -> tuple[Measure, ...]:
    """Measures in the summary of a kind of robot, in the order in which they are shown."""
    return tuple(measure for measure in _MEASURES if measure.joint in ("", *robot.joints))


MEASURES = measures_of(Compass)
"""Measures in the summary of the compass biped."""


def in_words(value: float | None, factor: float, form: str) -> str:
    """Format a measure for display; a dash stands for one that does not exist."""
    if value is None or value == math.inf:
        return "-" if value is None else "unbounded"
    text = format(value * factor, form)
    return text if text.strip("-0.") else text.lstrip("-")  # a small negative number is no "-0.00"


def quantile_rows(finished: Mapping[str, Any]) -> list[list[str]]:
    """Return label, formatted quantiles and unit of each measure of a study's finished walks."""
    return [
        [label, *(in_words(value, factor, form) for value in finished[key]), unit]
        for label, key, factor, form, unit, _ in MEASURES
        if finished.get(key) is not None
    ]


def table_of(rows: Iterable[Sequence[str]], *headings: str) -> Table:
    """Make a table without interpreting markup, of words to the left and numbers to the right.

    Args:
        rows: Its cells, row by row.
        *headings: Names of its columns; without them it has three columns of words: label, value and unit.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE, pad_edge=False, show_header=bool(headings))
    for heading in headings or ("", "", ""):
        words = not headings or heading in (headings[0], "unit")
        table.add_column(heading, justify="left" if words else "right", overflow="fold")
    for cells in rows:
        table.add_row(*map(Text, cells))
    return table


def html_table(rows: Iterable[Row]) -> str:
    """Write rows of label, value and unit as HTML."""
    left = "style='text-align:left'"
    lines = (
        f"<tr><th {left}>{escape(label)}</th><td {left}>{escape(value)} {escape(unit)}</td></tr>"
        for label, value, unit in rows
    )
    return f"<table>{''.join(lines)}</table>"


class WalkSummary(dict[str, Any]):
    """Measures of a walk, printed as a table, and by name as in `mjbiped.records.measures.summary`.

    A walk that failed has the reason in words as `probable_cause` and how its foot stood as `last_step_unfinished`;
    both are None for other walks.

    Attributes:
        rows: Label, formatted value, and unit of each line of the table.
    """

    def __init__(self, walk: Walk) -> None:
        """Measure a walk."""
        told = {"probable_cause": why_it_failed(walk), "last_step_unfinished": unfinished_step(walk)}
        super().__init__({**measures.summary(walk), **{key: text or None for key, text in told.items()}})
        settings, warnings = walk.settings, self["warnings"]
        rows = [
            ("outcome", walk.outcome, ""),
            ("ended at", f"{self['ended_at_time_s']:.3f} s, hip at x = {self['ended_at_x_m']:.3f} m", ""),
            ("terrain", walk.terrain.caption, ""),
            ("controller", f"{settings['controller']['name']}, engine {settings['engine']}", ""),
        ]
        if robot := _robot_in_words(walk.robot):
            rows.append(("robot", robot, ""))
        labels = {"probable_cause": "probable cause", "last_step_unfinished": "last step, unfinished"}
        rows += [(label, told[key], "") for key, label in labels.items() if told[key]]
        if settings.get("disturbances"):
            rows.append(("disturbances", _disturbances_in_words(settings["disturbances"]), ""))
        if warnings:
            texts = (f"{text} ({n} times)" if n > 1 else text for text, n in warnings.items())
            rows.append(("warning", "; ".join(texts), ""))
        rows += [
            (label, in_words(self[key], factor, form), "" if self[key] is None else unit)
            for label, key, factor, form, unit, _ in measures_of(type(walk.robot))
        ]
        self.rows = tuple(rows)

    def __rich__(self) -> Table:
        """Return the table for Rich."""
        return table_of(self.rows)

    def __str__(self) -> str:
        """Return the table as text."""
        from rich.console import Console

        text = StringIO()
        Console(file=text, width=_WIDTH, color_system=None, highlight=False, force_jupyter=False).print(self)
        return "\n".join(line.rstrip() for line in text.getvalue().strip("\n").splitlines())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the table for a notebook."""
        return html_table(self.rows)


def _in_short(value: float | Sequence[float]) -> str:
    """Write a number, or several with commas between them."""
    return ",".join(f"{each:g}" for each in (value if isinstance(value, Sequence) else [value]))


def _robot_in_words(robot: Robot) -> str:
    """Describe a robot by its numbers and their units; empty for one with the usual parameters of its kind."""
    if robot.kind in KINDS and robot == KINDS[robot.kind]():
        return ""
    told = []
    for name, (domain, _) in annotated(type(robot)).items():
        if name in robot.parameters() and isinstance(value := getattr(robot, name), int | float | tuple):
            unit = getattr(getattr(domain, "distance", domain), "unit", "")
            told.append(f"{name.replace('_', ' ')} {_in_short(value)} {unit}".rstrip())
    return f"{robot.kind}: {', '.join(told)}"


def _disturbances_in_words(disturbances: Mapping[str, object]) -> str:
    """Describe the disturbances in one line."""
    forms: dict[str, Callable[[Any], object]] = {"pushes": len, "seed": str}
    values = ((name, forms.get(name, _in_short)(value)) for name, value in disturbances.items())
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values)
