"""The walks of a robustness study, and the disturbances that it tries.

A disturbance meets the robot in many cases: at many phases of its step, or on many rough grounds.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from inspect import signature
from itertools import count, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.limit_cycles.basin import rates_around
from mjbiped.robots.robot import Robot
from mjbiped.studies.cell import LIMIT, Cell, Row
from mjbiped.terrain.drawn import GROWN, START
from mjbiped.terrain.files import FILE_KEY, parse_parameters
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import Scalar, read_choice

if TYPE_CHECKING:
    from mjbiped.studies.robustness import Plan

Values: TypeAlias = Mapping[str, Scalar]
"""Values of a study's cell, by their dotted names."""

Ground: TypeAlias = tuple[Values, Terrain | None]
"""Ground as a cell takes it: values, and the elevation record that they take a stretch of."""

LEVEL, SURVIVAL, BASIN = "level", "survival", "basin"
"""Tests beside `DISTURBANCES` and `MARGINS`: steady walking on level ground, random ground until the robot falls, and
level ground from other first rates than the gait's."""

LEVEL_STEPS = 40
BASIN_RATES = 20  # of either leg, unless a study says otherwise
BASIN_WIDTH = 3.0
"""Width of the basin's grid in multiples of the usual one, from all of which controllers return to their cycle."""

_BEFORE = 3  # steps before a disturbance comes
_LONGEST_STEP = 0.6  # length of random ground that is laid for each step of a walk, m
_FALLBACK = 0.38  # step length of a controller that imitates no gait, in leg lengths


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
    magnitudes: Sequence[float]
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
    """Disturbances of `robustness.toml` by name."""
    tables = tomllib.loads(resources.files("mjbiped.studies").joinpath("robustness.toml").read_text(encoding="utf-8"))
    return {
        name: Disturbance(**{**table, "magnitudes": read_choice(name, table["magnitudes"])})
        for name, table in tables[group].items()
    }


DISTURBANCES = _kinds("single")
"""Single disturbances of level ground, by name."""

MARGINS = _kinds("lasting")
"""Disturbances of walks over rough ground, by name; the last six are of what the controller believes of its robot."""

ALL = {**DISTURBANCES, **MARGINS}


def walks_of(wanted: Plan) -> Iterator[Cell]:
    """Make all walks of a plan, engine by engine.

    Raises:
        InputError: The words of a random ground are not valid.
    """
    limits, margins, number = wanted.limits, wanted.margins, count()
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    grounds = {words: _ground(words, wanted.steps, wanted.folder) for words in wanted.grounds}
    level, rough = ({"terrain.name": "level"}, None), _ground(margins.ground, margins.steps, wanted.folder)

    def cell(engine: str, test: str, label: str, steps: int, there: Ground, **columns: Scalar) -> Cell:
        known, (described, record) = wanted.controllers[label], there
        values = {
            "engine": engine,
            "test": test,
            "controller": label,
            **columns,
            f"{LIMIT}.steps": steps,
            **({} if test == BASIN else {"initial": "gait"}),
            **({} if known.kind.collides_from_lift_off else rule),
            **known.values,
            **described,
        }
        return Cell(next(number), None, values, record, known.law)

    for engine in wanted.engines:
        for label in wanted.controllers:
            yield cell(engine, LEVEL, label, LEVEL_STEPS, level)
        for label, known in wanted.controllers.items():
            robot, gait = known.robot(), known.controller().gait
            length = float(gait.step_length) if gait is not None else _FALLBACK * robot.leg_length
            for test, magnitude, phase in _cases(limits.magnitudes, limits.phases):
                place = (_BEFORE + (phase + 0.5) / limits.phases) * length
                once = DISTURBANCES[test].described(magnitude, engine, robot, place), None
                yield cell(engine, test, label, _BEFORE + 1 + limits.steps_after, once, magnitude=magnitude, case=phase)
            for case, rates in enumerate(_first_rates(gait, limits.basin)):
                yield cell(engine, BASIN, label, limits.steps_after, ({**level[0], **rates}, None), case=case)
        for label, known in wanted.controllers.items():
            for test, magnitude, seed in _cases(margins.magnitudes, wanted.seeds):
                lasting = MARGINS[test].described(magnitude, engine, known.robot())
                drawn = any(name.startswith("disturbances.") for name in lasting)
                chance = {"disturbances.seed": seed} if drawn else {}
                there = {**rough[0], "terrain.seed": seed, **lasting, **chance}, rough[1]
                columns: dict[str, Scalar] = {"ground": margins.ground, "magnitude": magnitude, "case": seed}
                yield cell(engine, test, label, margins.steps, there, **columns)
        for words, seed, label in product(grounds, range(wanted.seeds), wanted.controllers):
            described, record = grounds[words]
            there = {**described, "terrain.seed": seed}, record
            yield cell(engine, SURVIVAL, label, wanted.steps, there, ground=words, case=seed)


def _cases(tried: Mapping[str, Sequence[float]], count: int) -> Iterator[tuple[str, float, int]]:
    """List name, magnitude and case of all that is tried, with a number of cases of each magnitude."""
    for test, magnitudes in tried.items():
        for magnitude, case in product(magnitudes, range(count)):
            yield test, magnitude, case


def _ground(words: object, steps: int, folder: Path) -> Ground:
    """Read a random ground, as the command line writes it, for walks of some steps; its file is in the folder.

    Raises:
        InputError: The words describe no random ground.
    """
    name, parameters = _parsed(words)
    known_name("random ground", name, RANDOM)
    for key, reason in (("seed", "the study draws the seeds itself"), ("length", "it follows from the steps")):
        if key in parameters:
            raise InputError(f"ground {shown(words)}: leave {key} out, {reason}")
    values = {"name": name, **parameters, "length": START + steps * _LONGEST_STEP}
    described = {
        f"terrain.{key}": "..".join(map(str, value)) if isinstance(value, tuple) else value
        for key, value in values.items()
    }
    return described, Terrain.from_file(folder / parameters[FILE_KEY]) if FILE_KEY in parameters else None


def rough_from(words: str) -> float:
    """Distance after which a random ground, as the command line writes it, has its full roughness, m."""
    name, parameters = _parsed(words)
    longest = signature(Terrain.waves).parameters["longest"].default
    return START + GROWN * float(parameters.get("longest", longest)) if name == "waves" else START


def _parsed(words: object) -> tuple[str, dict[str, Any]]:
    """Read the name and the parameters of a ground as the command line writes it."""
    if not isinstance(words, str):
        raise InputError(f"a random ground is a text, as 'treads:deviation=0.03', got {shown(words)}")
    name, _, rest = words.partition(":")
    return name, parse_parameters(rest) if rest else {}


def _first_rates(gait: Gait | None, count: int) -> Iterator[Values]:
    """Initial states of the basin's slice, as a cell takes them; none for a controller without a gait."""
    if gait is None or not count:
        return
    half = len(gait.start) // 2
    stance, swing = gait.start[half : half + 2].tolist()
    around = rates_around(gait.start, count, BASIN_WIDTH)
    for rate1, rate2 in product(*(rates.tolist() for rates in around)):
        described = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        # with knees the swing leg's is straight after a touchdown
        yield described if half == 2 else {**described, "initial.dq3": rate2 - swing}
