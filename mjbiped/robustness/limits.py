"""Kinds of disturbances, and the greatest magnitude of each that is survived.

A disturbance meets the robot in many cases: at many phases of its step, or on many rough grounds. A magnitude is
survived where nearly all cases are. The greatest one survived is the last before the first that is not: a robot that
survives 60 mm and 80 mm, but not 70 mm, survives 60 mm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from mjbiped.robots.robot import Robot
from mjbiped.sweeps.cell import Row, Scalar

Values: TypeAlias = Mapping[str, Scalar]
"""Values of a study's cell, by their dotted names."""

Described: TypeAlias = Callable[[float, Robot, float], Values]
"""Values for a magnitude, the robot that walks, and the place of a single disturbance, m."""

FAR = 1e4  # of ground that goes on behind the disturbance, m


@dataclass(frozen=True)
class Disturbance:
    """A kind of disturbance: a single one of level ground, or one that lasts for a whole walk over rough ground.

    Attributes:
        unit: Unit of its magnitudes; empty for plain numbers.
        magnitudes: Those that are tried unless a study says otherwise, the gentlest first.
        values: Values of a study's cell.
        asked: Column of what a walk asks for, of a disturbance that the hybrid engine does not know: a walk survives
            those magnitudes there that are no less.
    """

    unit: str
    magnitudes: tuple[float, ...]
    values: Described
    asked: str | None = None

    @property
    def falls(self) -> bool:
        """Whether lower magnitudes are harder."""
        return self.magnitudes[0] > self.magnitudes[-1]

    def described(self, magnitude: float, engine: str, robot: Robot, place: float = 0.0) -> Values:
        """Values of a study's cell for a robot's walk in an engine."""
        return {} if self.asked is not None and engine == "hybrid" else self.values(magnitude, robot, place)

    def borne(self, row: Row) -> bool:
        """Whether a walk in an engine without this disturbance stays within the magnitude."""
        if self.asked is None or row["engine"] != "hybrid":
            return True
        asked = row[self.asked]
        return asked is not None and bool(asked <= row["magnitude"])


def _step(sign: float) -> Described:
    usual: Values = {"terrain.name": "stairs", "terrain.tread": FAR, "terrain.count": 1}
    return lambda height, _, place: {**usual, "terrain.rise": sign * height, "terrain.first": place}


def _bend(sign: float) -> Described:
    usual: Values = {"terrain.name": "slopes", "terrain.count": 1}
    return lambda change, _, place: {**usual, "terrain.length": place, "terrain.change_deg": sign * change}


def _evenly(step: float, last: float) -> tuple[float, ...]:
    return tuple(round(step * k, 9) for k in range(1, round(last / step) + 1))


DISTURBANCES: Mapping[str, Disturbance] = {
    "step up": Disturbance("m", _evenly(0.005, 0.15), _step(1.0)),
    "step down": Disturbance("m", _evenly(0.01, 0.3), _step(-1.0)),
    "slope down": Disturbance("deg", _evenly(1.0, 15.0), _bend(1.0)),
    "slope up": Disturbance("deg", _evenly(1.0, 15.0), _bend(-1.0)),
}
"""Single disturbances of level ground, by name."""


def _of(field: str, **others: Scalar) -> Described:
    values = {f"disturbances.{name}": value for name, value in others.items()}
    return lambda magnitude, *_: {f"disturbances.{field}": magnitude, **values}


def _believed(sign: float, *endings: str) -> Described:
    """Make the legs of the controller's model wrong by a number of percent."""

    def values(percent: float, robot: Robot, _: float) -> Values:
        factor = 1.0 + sign * percent / 100.0
        wrong = [name for name in robot.parameters() if name.endswith(endings) and name != "hip_mass"]
        return {f"model.{name}": round(getattr(robot, name) * factor, 12) for name in wrong}

    return values


PUSH_INTERVAL = 4.0
"""Mean time between random pushes, s: five steps."""

_MORE = (5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 900.0, 1500.0, 2500.0)
_LESS = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 95.0)
_LENGTHS = ("_length", "_centre")

MARGINS: Mapping[str, Disturbance] = {
    "delay": Disturbance(
        "s", (0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.055, 0.06, 0.065, 0.07, 0.08), _of("delay")),
    "angle noise": Disturbance(
        "rad", (1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 4e-2, 6e-2, 8e-2, 0.1, 0.12, 0.15), _of("angle_noise")),
    "angle bias": Disturbance("rad", (5e-3, 1e-2, 2e-2, 3e-2, 4e-2, 5e-2, 6e-2, 8e-2, 0.1), _of("angle_bias")),
    "rate noise": Disturbance("rad/s", (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 2.0), _of("rate_noise")),
    "push": Disturbance(
        "N s", (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0),
        _of("push_impulse", push_interval=PUSH_INTERVAL)),
    "torque limit": Disturbance(
        "N m", (60.0, 50.0, 40.0, 30.0, 25.0, 20.0, 17.5, 15.0, 12.5, 10.0, 8.0, 6.0, 4.0), _of("torque_limit")),
    "friction": Disturbance(
        "", (0.8, 0.7, 0.6, 0.55, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.1), _of("friction"),
        "largest_stance_friction"),
    "mass too great": Disturbance("%", _MORE, _believed(1.0, "_mass")),
    "mass too small": Disturbance("%", _LESS, _believed(-1.0, "_mass")),
    "inertia too great": Disturbance("%", _MORE, _believed(1.0, "_inertia")),
    "inertia too small": Disturbance("%", (*_LESS, 100.0), _believed(-1.0, "_inertia")),
    "legs too long": Disturbance("%", _MORE, _believed(1.0, *_LENGTHS)),
    "legs too short": Disturbance("%", _LESS, _believed(-1.0, *_LENGTHS)),
}  # fmt: skip
"""Disturbances of walks over rough ground, by name; the last six are of what the controller believes of its robot."""


def greatest_survived(kind: Disturbance, survived: Mapping[float, Sequence[bool]], wanted: float) -> float | None:
    """Find the hardest magnitude up to which all are survived; None where not even the gentlest is.

    Args:
        kind: The disturbance, which says in what order magnitudes become harder.
        survived: Whether each case was survived, by magnitude.
        wanted: Share of the cases that counts as survived.
    """
    greatest = None
    for magnitude in sorted(survived, reverse=kind.falls):
        if sum(survived[magnitude]) / len(survived[magnitude]) < wanted:
            break
        greatest = magnitude
    return greatest
