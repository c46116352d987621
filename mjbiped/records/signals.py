"""The signals of a walk over time, in one table: figures, reports, charts in videos and the viewer's words read it.

A new signal is a row of `SIGNALS`; walks of robots that have its column show it in all of these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.records import measures, stance_knee
from mjbiped.records.columns import tables_of
from mjbiped.records.frames import flat_samples, units_of
from mjbiped.records.pressure import centre_of_pressure
from mjbiped.robots.robot import Robot
from mjbiped.utils.palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

Values = NDArray[np.float64]

SOLID, DASHED, DOTTED = "-", (0, (4.0, 1.2)), (0, (1.5, 1.2))
"""Styles of lines, as Matplotlib takes them."""

_FARTHEST_PRESSURE = 0.5  # leg lengths that are shown on either side of the ankle


class Panel(NamedTuple):
    """Signals of one kind and size, which are drawn over each other.

    Attributes:
        title: In full.
        quantity: For an axis.
        unit: Of the values.
        scale: The unit's number in SI units.
        least: Least span of the axis, in the unit: what is less is rounding.
        by_legs: Whether the values jump where the legs change roles, so that no line joins two steps.
    """

    title: str
    quantity: str
    unit: str
    scale: float = 1.0
    least: float = 0.0
    by_legs: bool = False


PANELS: Mapping[str, Panel] = {
    "slope": Panel("Slope of the ground under the stance foot", "slope", "°", math.radians(1.0), least=1.0),
    "torque": Panel("Joint torque", "torque", "N m"),
    "pressure": Panel(
        "Centre of pressure that the ankle's torque asks for, positive forward", "from the ankle", "cm", 0.01
    ),
    "knee torque": Panel("Torque of the swing knee", "torque", "N m"),  # a hundredth of the others
    "flexion": Panel("Flexion of the swing knee", "flexion", "°", math.radians(1.0)),
    "angle": Panel("Angle from the ground's normal", "angle", "rad", by_legs=True),
    "rate": Panel("Rate", "rate", "rad/s", by_legs=True),
    "power": Panel("Mechanical power of the joints", "power", "W"),
}
"""All panels, in the order in which they are drawn."""


class Signal(NamedTuple):
    """A quantity of a walk at each sample.

    Attributes:
        panel: Where it is drawn, of `PANELS`.
        name: In legends.
        symbol: As the paper and docs/glossary.md write it; empty where they have none.
        colour: One meaning for each, in all figures, reports and videos; told apart by colour-blind eyes.
        line: Its style, which tells lines apart as well.
        made: Computes it from a walk, in SI units; None where it is a column of the flat samples.
        column: What walks must have in their flat samples for it; its own name unless given.
    """

    panel: str
    name: str
    symbol: str
    colour: str
    line: Any
    made: Callable[[Walk], Values] | None = None
    column: str = ""


def _pressure(walk: Walk) -> Values:
    """Centre of pressure, m, cut off where it would dwarf the rest."""
    most = _FARTHEST_PRESSURE * walk.robot.leg_length
    return np.clip(centre_of_pressure(walk), -most, most)


def _flexion(walk: Walk) -> Values:
    """Flexion of the swing knee, rad."""
    swing, shank = (walk.robot.angles.index(name) for name in ("swing", "shank"))
    return np.asarray(walk.samples["q"][:, shank] - walk.samples["q"][:, swing])


def _power(joint: str) -> Callable[[Walk], Values]:
    """Computes the mechanical power of a joint, W."""
    return lambda walk: measures.powers(walk)[:, walk.robot.joints.index(joint)]


SIGNALS: Mapping[str, Signal] = {
    "slope_estimate": Signal("slope", "estimate", "φ̂", GREEN, SOLID),
    "slope": Signal("slope", "true slope", "φ", BLACK, DOTTED),
    "torque_ankle": Signal("torque", "ankle", "τ₁", PURPLE, SOLID),
    "torque_hip": Signal("torque", "hip", "τ₂", VERMILLION, DASHED),
    "torque_stance_knee": Signal("torque", "stance knee", "", BLUE, DOTTED, stance_knee.torque, "stance_knee_torque"),
    "torque_knee": Signal("knee torque", "swing knee", "τ₃", SKY, SOLID),
    "pressure": Signal("pressure", "ankle", "", PURPLE, SOLID, _pressure, "torque_ankle"),
    "flexion": Signal("flexion", "swing knee", "q₃ − q₂", SKY, SOLID, _flexion, "q_shank"),
    "q_stance": Signal("angle", "stance leg", "q₁", BLUE, SOLID),
    "q_swing": Signal("angle", "swing leg", "q₂", ORANGE, DASHED),
    "q_shank": Signal("angle", "swing shank", "q₃", SKY, DOTTED),
    "dq_stance": Signal("rate", "stance leg", "q̇₁", BLUE, SOLID),
    "dq_swing": Signal("rate", "swing leg", "q̇₂", ORANGE, DASHED),
    "dq_shank": Signal("rate", "swing shank", "q̇₃", SKY, DOTTED),
    "power_ankle": Signal("power", "ankle", "", PURPLE, SOLID, _power("ankle"), "torque_ankle"),
    "power_hip": Signal("power", "hip", "", VERMILLION, DASHED, _power("hip"), "torque_hip"),
    "power_knee": Signal("power", "swing knee", "", SKY, SOLID, _power("knee"), "torque_knee"),
}
"""All signals by name, those of a panel in the order in which they are drawn."""


def signals_of(robot: type[Robot]) -> dict[str, Signal]:
    """The signals that walks of a kind of robot have, by name."""
    columns = units_of(tables_of(robot).samples)
    signals = {name: signal for name, signal in SIGNALS.items() if (signal.column or name) in columns}
    if "q_shank" in columns:  # then the swing leg's angle is that of its thigh
        for name in ("q_swing", "dq_swing"):
            signals[name] = signals[name]._replace(name="swing thigh")
    return signals


def torques_of(robot: type[Robot]) -> list[Signal]:
    """The torques of a kind of robot, in the order of its joints."""
    return [SIGNALS[f"torque_{joint}"] for joint in robot.joints]


def panels_of(robot: type[Robot]) -> Iterator[tuple[str, dict[str, Signal]]]:
    """The panels that have signals of a kind of robot, in their order, each with its signals by name."""
    signals = signals_of(robot)
    for panel in PANELS:
        found = {name: signal for name, signal in signals.items() if signal.panel == panel}
        if found:
            yield panel, found


def values_of(walk: Walk, name: str) -> Values:
    """A signal at each sample, in its panel's unit; NaN where it does not exist.

    Args:
        walk: A record whose robot has the signal.
        name: Of `SIGNALS`.
    """
    signal = SIGNALS[name]
    values = flat_samples(walk)[name] if signal.made is None else signal.made(walk)
    return np.asarray(values / PANELS[signal.panel].scale, dtype=np.float64)


def knee_strikes(walk: Walk) -> Values:
    """When a swing knee struck its stop in the steps that ended, since the walk's start, s; none without knees."""
    if "knee_strike" not in walk.touchdowns:
        return np.empty(0)
    strikes = np.append(0.0, walk.touchdowns["time"])[:-1] + walk.touchdowns["knee_strike"]
    return np.asarray(strikes[np.isfinite(strikes)])
