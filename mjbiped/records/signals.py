"""Signals of a walk over time, in one table for figures, reports, charts in videos and the viewer.

A new signal is a row of `SIGNALS`; walks of all robots that have its column then show it everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.records import loads, measures
from mjbiped.records.columns import flat_samples, tables_of, units_of
from mjbiped.records.loads import centre_of_pressure
from mjbiped.robots.robot import Robot
from mjbiped.utils.domains import known_name
from mjbiped.utils.palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

Values = NDArray[np.float64]

SOLID, DASHED, DOTTED, DASH_DOTTED = "-", (0, (4.0, 1.2)), (0, (1.5, 1.2)), (0, (5.0, 1.2, 1.2, 1.2))
"""Line styles in Matplotlib's notation."""

_FARTHEST_PRESSURE = 0.5  # leg lengths that are shown on either side of the ankle


class Panel(NamedTuple):
    """Signals of one quantity and magnitude, which are drawn over each other.

    Attributes:
        title: Title in full.
        quantity: Name of the quantity on the axis.
        unit: Unit of the values.
        scale: Value of the unit in SI units.
        least: Least span of the axis, in the unit; smaller differences are rounding.
        by_legs: Whether the values jump where the legs change roles, so that no line joins two steps.
        in_figure: Whether the figure of a walk has the panel unless its panels are named; reports have all panels.
        in_words: Whether the report states the values at the current moment in words.
        events: Name of the events that are marked on the zero line, and a function for their times, s.
    """

    title: str
    quantity: str
    unit: str
    scale: float = 1.0
    least: float = 0.0
    by_legs: bool = False
    in_figure: bool = True
    in_words: bool = False
    events: tuple[str, Callable[[Walk], Values]] | None = None


class Signal(NamedTuple):
    """A quantity of a walk at each sample.

    Attributes:
        panel: Name of its panel in `PANELS`.
        name: Name in legends.
        symbol: Symbol in the paper and in docs/glossary.md; empty if it has none.
        colour: Colour, with one meaning in all figures, reports and videos; safe for colour-blind readers.
        line: Line style, which also tells lines apart.
        made: Function that computes the values of a walk in SI units; None for a column of the flat samples.
        column: Column of the flat samples that a walk must have; the signal's own name unless given.
        optional: Whether nothing is said where it has no value.
    """

    panel: str
    name: str
    symbol: str
    colour: str
    line: Any
    made: Callable[[Walk], Values] | None = None
    column: str = ""
    optional: bool = False

    @property
    def label(self) -> str:
        """Name and symbol."""
        return f"{self.name} {self.symbol}".strip()


def knee_strikes(walk: Walk) -> Values:
    """Times at which a swing knee struck its stop in the finished steps, s; none without knees."""
    if "knee_strike" not in walk.touchdowns:
        return np.empty(0)
    strikes = np.append(0.0, walk.touchdowns["time"])[:-1] + walk.touchdowns["knee_strike"]
    return np.asarray(strikes[np.isfinite(strikes)])


PANELS: Mapping[str, Panel] = {
    "slope": Panel(
        "Slope of the ground under the stance foot", "slope", "°", math.radians(1.0), least=1.0, in_words=True
    ),
    "torque": Panel("Joint torque", "torque", "N m", in_words=True),
    "lateral": Panel(
        "Slope of the ground across the heading, positive where it falls to the left",
        "slope",
        "°",
        math.radians(1.0),
        1.0,
    ),
    "pressure": Panel(
        "Centre of pressure that the ankle's torque requires, positive forward", "from the ankle", "cm", 0.01
    ),
    "knee_torque": Panel("Torque of the swing knee", "torque", "N m", in_words=True),  # a hundredth of the others
    "flexion": Panel(
        "Flexion of the swing knee", "flexion", "°", math.radians(1.0), events=("knee strike", knee_strikes)
    ),
    "angle": Panel("Angle from the ground's normal", "angle", "rad", by_legs=True, in_figure=False),
    "rate": Panel("Rate", "rate", "rad/s", by_legs=True, in_figure=False),
    "power": Panel("Mechanical power of the joints", "power", "W", in_figure=False),
}
"""All panels, in the order in which they are drawn."""

FIGURE = ("lapse", "above", *PANELS, "phase")
"""Names of all panels of a walk's figure: its time lapse, the paths of a robot in space seen from above, its signals,
and its phase portraits."""


def check_panels(names: Iterable[str]) -> tuple[str, ...]:
    """Check names of panels of a walk's figure, and return them.

    Raises:
        InputError: There is no such panel.
    """
    return tuple(known_name("panel", name.strip(), FIGURE) for name in names)


def _pressure(walk: Walk) -> Values:
    """Centre of pressure, m; NaN where it would dwarf the rest, as where a fall takes the load off the foot."""
    pressure = centre_of_pressure(walk)
    near = np.abs(pressure) <= _FARTHEST_PRESSURE * walk.robot.leg_length
    return np.where(near, pressure, np.nan)


def _asked(walk: Walk) -> Values:
    """Ankle torque that the law asks for, N m, where the sole transmits less; NaN elsewhere."""
    asked = walk.samples["ankle_asked"]
    bound = (asked != walk.samples["torque"][:, 0]) & (walk.robot.sole is not None)
    return np.where(bound, asked, np.nan)


def _end_of_sole(end: int, sign: float) -> Callable[[Walk], Values]:
    """Return a function that tells where an end of the sole is at each sample, m; NaN without a sole."""
    return lambda walk: np.full(
        len(walk.samples["time"]), math.nan if walk.robot.sole is None else sign * walk.robot.sole[end]
    )


def _flexion(walk: Walk) -> Values:
    """Flexion of the swing knee, rad."""
    swing, shank = (walk.robot.angles.index(name) for name in ("swing", "shank"))
    return np.asarray(walk.samples["q"][:, shank] - walk.samples["q"][:, swing])


def _power(joint: str) -> Callable[[Walk], Values]:
    """Return a function that computes the mechanical power of a joint, W."""
    return lambda walk: measures.powers(walk)[:, walk.robot.joints.index(joint)]


SIGNALS: Mapping[str, Signal] = {
    "slope_estimate": Signal("slope", "estimate", "φ̂", GREEN, SOLID),
    "slope": Signal("slope", "true slope", "φ", BLACK, DOTTED),
    "torque_ankle": Signal("torque", "ankle", "τ₁", PURPLE, SOLID),
    "torque_asked": Signal("torque", "ankle, asked for", "", BLACK, DOTTED, _asked, "torque_ankle", optional=True),
    "torque_hip": Signal("torque", "hip", "τ₂", VERMILLION, DASHED),
    "torque_abduction": Signal("torque", "abduction", "", BLUE, DASHED),
    "torque_ankle_roll": Signal("torque", "ankle roll", "", ORANGE, DASH_DOTTED),
    "torque_stance_knee": Signal("torque", "stance knee", "", BLUE, DOTTED, loads.knee_torque, "stance_knee_torque"),
    "torque_knee": Signal("knee_torque", "swing knee", "τ₃", SKY, SOLID),
    "lateral_estimate": Signal("lateral", "estimate", "", GREEN, SOLID),
    "lateral_slope": Signal("lateral", "true slope", "", BLACK, DOTTED),
    "pressure": Signal("pressure", "ankle", "", PURPLE, SOLID, _pressure, "torque_ankle"),
    "toe": Signal("pressure", "toe", "", BLACK, DASHED, _end_of_sole(1, 1.0), "torque_ankle", optional=True),
    "heel": Signal("pressure", "heel", "", BLUE, DOTTED, _end_of_sole(0, -1.0), "torque_ankle", optional=True),
    "flexion": Signal("flexion", "swing knee", "q₃ − q₂", SKY, SOLID, _flexion, "q_shank"),
    "q_stance": Signal("angle", "stance leg", "q₁", BLUE, SOLID),
    "q_swing": Signal("angle", "swing leg", "q₂", ORANGE, DASHED),
    "q_shank": Signal("angle", "swing shank", "q₃", SKY, DOTTED),
    "q_abduction": Signal("angle", "abduction", "a", SKY, DOTTED),
    "q_roll": Signal("angle", "roll", "s", GREEN, DASH_DOTTED),
    "dq_stance": Signal("rate", "stance leg", "q̇₁", BLUE, SOLID),
    "dq_swing": Signal("rate", "swing leg", "q̇₂", ORANGE, DASHED),
    "dq_shank": Signal("rate", "swing shank", "q̇₃", SKY, DOTTED),
    "dq_abduction": Signal("rate", "abduction", "ȧ", SKY, DOTTED),
    "dq_roll": Signal("rate", "roll", "ṡ", GREEN, DASH_DOTTED),
    "power_ankle": Signal("power", "ankle", "", PURPLE, SOLID, _power("ankle"), "torque_ankle"),
    "power_hip": Signal("power", "hip", "", VERMILLION, DASHED, _power("hip"), "torque_hip"),
    "power_knee": Signal("power", "swing knee", "", SKY, SOLID, _power("knee"), "torque_knee"),
    "power_abduction": Signal("power", "abduction", "", BLUE, DASHED, _power("abduction"), "torque_abduction"),
    "power_ankle_roll": Signal(
        "power", "ankle roll", "", ORANGE, DASH_DOTTED, _power("ankle_roll"), "torque_ankle_roll"
    ),
}
"""All signals by name, those of a panel in the order in which they are drawn."""


def signals_of(robot: type[Robot]) -> dict[str, Signal]:
    """Signals by name that the walks of a kind of robot have."""
    columns = units_of(tables_of(robot).samples)
    signals = {name: signal for name, signal in SIGNALS.items() if (signal.column or name) in columns}
    if "shank" in robot.angles:  # then the swing leg's angle is that of its thigh
        for name in ("q_swing", "dq_swing"):
            signals[name] = signals[name]._replace(name="swing thigh")
    return signals


def torques_of(robot: type[Robot]) -> list[Signal]:
    """Torques of a kind of robot, in the order of its joints."""
    return [SIGNALS[f"torque_{joint}"] for joint in robot.joints]


class Lines(NamedTuple):
    """Contents of a panel for a walk.

    Attributes:
        panel: The panel.
        signals: Signals by name that have a finite value.
        values: Values of each of these signals at each sample, in the panel's unit.
        missing: Names of the signals without a finite value, such as an estimate that nobody makes.
        events: Times of the panel's events, s.
    """

    panel: Panel
    signals: Mapping[str, Signal]
    values: Mapping[str, Values]
    missing: Sequence[str]
    events: Values


def lines_of(walk: Walk) -> Iterator[Lines]:
    """Lines of a walk over time, panel by panel; panels without signals of its robot are left out."""
    signals = signals_of(type(walk.robot))
    for name, panel in PANELS.items():
        every = {key: values_of(walk, key) for key, signal in signals.items() if signal.panel == name}
        values = {key: line for key, line in every.items() if np.isfinite(line).any()}
        missing = [signals[key].name for key in every if key not in values and not signals[key].optional]
        events = panel.events[1](walk) if panel.events else np.empty(0)
        if every:
            yield Lines(panel, {key: signals[key] for key in values}, values, missing, events)


def without_zeros(every: Iterable[Lines]) -> list[Lines]:
    """Leave out the panels that are zero throughout, such as the torques of a passive walk, but not all panels."""
    panels = list(every)
    return [lines for lines in panels if any(np.nan_to_num(line).any() for line in lines.values.values())] or panels[:1]


def values_of(walk: Walk, name: str) -> Values:
    """Values of a signal at each sample, in its panel's unit; NaN where the signal does not exist.

    Args:
        walk: A record whose robot has the signal.
        name: Name in `SIGNALS`.
    """
    signal = SIGNALS[name]
    values = flat_samples(walk)[name] if signal.made is None else signal.made(walk)
    return np.asarray(values / PANELS[signal.panel].scale, dtype=np.float64)
