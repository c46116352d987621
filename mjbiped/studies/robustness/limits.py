"""Kinds of disturbances, how they are tried, and the greatest magnitude of each that is survived.

A disturbance meets the robot in many cases: at many phases of its step, or on many rough grounds. A magnitude is
survived where nearly all cases are. The greatest one survived is the last before the first that is not: a robot that
survives 60 mm and 80 mm, but not 70 mm, survives 60 mm.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from typing import Annotated, Any, TypeAlias

from mjbiped.robots.robot import Robot
from mjbiped.studies.cell import Row
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, check_fields
from mjbiped.utils.draws import Scalar, read_choice

Values: TypeAlias = Mapping[str, Scalar]
"""Values of a study's cell, by their dotted names."""

_SHARE = Domain(0.5, 1.0)


@dataclass(frozen=True)
class Disturbance:
    """A kind of disturbance: a single one of level ground, or one that lasts for a whole walk over rough ground.

    Attributes:
        unit: Unit of its magnitudes; empty for plain numbers.
        magnitudes: Those that are tried unless a study says otherwise, the gentlest first.
        sets: Value of a study's cell that is the magnitude, times the sign.
        sign: 1 or -1.
        values: Other values of the cell.
        place: Value that says where a single disturbance is, m; empty for one that lasts.
        wrong: Endings of the robot's parameters that the controller believes to be wrong by a magnitude in percent.
        asked: Column of what a walk asks for, of a disturbance that the hybrid engine does not know: a walk survives
            those magnitudes there that are no less.
    """

    unit: str
    magnitudes: tuple[float, ...]
    sets: str = ""
    sign: float = 1.0
    values: Values = field(default_factory=dict)
    place: str = ""
    wrong: Sequence[str] = ()
    asked: str | None = None

    @property
    def falls(self) -> bool:
        """Whether lower magnitudes are harder."""
        return self.magnitudes[0] > self.magnitudes[-1]

    def described(self, magnitude: float, engine: str, robot: Robot, place: float = 0.0) -> Values:
        """Values of a study's cell for a robot's walk in an engine."""
        if self.asked is not None and engine == "hybrid":
            return {}
        if self.wrong:
            factor = 1.0 + self.sign * magnitude / 100.0
            names = [name for name in robot.parameters() if name.endswith(tuple(self.wrong)) and name != "hip_mass"]
            return {f"model.{name}": round(getattr(robot, name) * factor, 12) for name in names}
        where = {self.place: place} if self.place else {}
        return {**self.values, self.sets: self.sign * magnitude, **where}

    def borne(self, row: Row) -> bool:
        """Whether a walk in an engine without this disturbance stays within the magnitude."""
        if self.asked is None or row["engine"] != "hybrid":
            return True
        asked = row[self.asked]
        return asked is not None and bool(asked <= row["magnitude"])


def _kinds(group: str) -> dict[str, Disturbance]:
    """Disturbances of `limits.toml` by name."""
    text = resources.files("mjbiped.studies.robustness").joinpath("limits.toml").read_text(encoding="utf-8")
    tables: dict[str, dict[str, Any]] = tomllib.loads(text)[group]
    return {
        name: Disturbance(**{**table, "magnitudes": read_choice(name, table["magnitudes"])})
        for name, table in tables.items()
    }


DISTURBANCES: Mapping[str, Disturbance] = _kinds("single")
"""Single disturbances of level ground, by name."""

MARGINS: Mapping[str, Disturbance] = _kinds("lasting")
"""Disturbances of walks over rough ground, by name; the last six are of what the controller believes of its robot."""

ALL: Mapping[str, Disturbance] = {**DISTURBANCES, **MARGINS}


class Checked:
    """Numbers that are checked by their domains."""

    def __post_init__(self) -> None:
        """Refuse numbers outside their domains."""
        check_fields(self)


@dataclass(frozen=True)
class Limits(Checked):
    """Single disturbances of level ground.

    Attributes:
        magnitudes: The magnitudes that are tried, by the disturbance's name.
        basin: Number of first rates of either leg from which walks on level ground begin; 0: none do.
        share: Share of the phases that must be survived.
        phases: Number of phases of the step at which each disturbance comes.
        steps_after: Number of steps that must be made after it.
        torque: Greatest torque of any joint with which a walk counts as survived, N m; None: any.
    """

    magnitudes: Mapping[str, tuple[float, ...]]
    basin: int
    share: Annotated[float, _SHARE] = 0.99
    phases: Annotated[int, domains.WALKS] = 24
    steps_after: Annotated[int, domains.STEPS] = 20
    torque: Annotated[float | None, domains.TORQUE_LIMIT] = None


@dataclass(frozen=True)
class Margins(Checked):
    """Disturbances of whole walks over rough ground.

    Attributes:
        magnitudes: The magnitudes that are tried, by the disturbance's name.
        share: Share of the seeds that must be survived.
        ground: The rough ground, as the command line writes it; all controllers last on the usual one.
        steps: Number of steps that must be made.
    """

    magnitudes: Mapping[str, tuple[float, ...]]
    share: Annotated[float, _SHARE] = 0.95
    ground: str = "treads:deviation=0.01"
    steps: Annotated[int, domains.STEPS] = 200
    torque = None


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
