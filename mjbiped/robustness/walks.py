"""The plan of a robustness study, and its walks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, TypeVar

from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.limit_cycles.basin import rates_around
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Values
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import LIMIT, Cell, Scalar
from mjbiped.sweeps.plan import Study
from mjbiped.terrain.files import FILE_KEY, parse_parameters
from mjbiped.terrain.presets import GROWN, RANDOM, START
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, check_fields, known_name

LEVEL, SURVIVAL, BASIN = "level", "survival", "basin"
"""Tests beside `DISTURBANCES` and `MARGINS`: steady walking on level ground, random ground until the robot falls, and
level ground from other first rates than the gait's."""

LEVEL_STEPS = 40
BASIN_WIDTH = 3.0
"""Width of the basin's grid in multiples of the usual one, from all of which controllers return to their cycle."""

_BEFORE = 3  # steps before a disturbance comes

LONGEST_STEP = 0.6
"""Length of random ground that is laid for each step of a walk, m."""

_FALLBACK = 0.38  # step length of a controller that imitates no gait, in leg lengths
_SHARE = Domain(0.5, 1.0)


VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""


class _Checked:
    """Numbers that are checked by their domains."""

    def __post_init__(self) -> None:
        """Refuse numbers outside their domains."""
        check_fields(self)


@dataclass(frozen=True)
class Limits(_Checked):
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
class Margins(_Checked):
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


AnyTried = TypeVar("AnyTried", Limits, Margins)


@dataclass(frozen=True)
class Plan(_Checked):
    """The tests of a robustness study.

    Attributes:
        declared: Content of the study's file.
        folder: Folder in which elevation files are looked for.
        controllers: Controllers with their robots by label, as cells that know nothing else.
        engines: Names of the engines.
        grounds: Random grounds, as the command line writes them.
        seeds: Number of grounds of each kind.
        steps: Greatest number of steps on them.
        limits: Single disturbances of level ground.
        margins: Disturbances of whole walks over rough ground.
        scuffing: The rule of all walks.
    """

    declared: Mapping[str, Any]
    folder: Path
    controllers: Mapping[str, Cell]
    engines: tuple[str, ...]
    grounds: tuple[str, ...]
    seeds: Annotated[int, domains.WALKS]
    steps: Annotated[int, domains.STEPS]
    limits: Limits
    margins: Margins
    scuffing: ScuffingRule

    @cached_property
    def study(self) -> Study:
        """Its walks.

        Raises:
            InputError: The words of a random ground are not valid.
        """
        return Study(tuple(_walks_of(self)), VARIED, self.declared)

    @property
    def count(self) -> int:
        """Number of walks."""
        single, lasting = (sum(map(len, tried.magnitudes.values())) for tried in (self.limits, self.margins))
        each = 1 + self.limits.phases * single + self.limits.basin**2 + self.seeds * (len(self.grounds) + lasting)
        return len(self.engines) * len(self.controllers) * each


def _walks_of(wanted: Plan) -> Iterator[Cell]:
    """Make all walks of a plan; the short walks come first."""
    limits, margins, number = wanted.limits, wanted.margins, itertools.count()
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    records: dict[Scalar | None, Terrain] = {}
    grounds = {words: _ground(words, wanted.steps, wanted.folder, records) for words in wanted.grounds}
    level, rough = {"terrain.name": "level"}, _ground(margins.ground, margins.steps, wanted.folder, records)

    def cell(engine: str, test: str, label: str, steps: int, described: Values, **columns: Scalar) -> Cell:
        known = wanted.controllers[label]
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
        return Cell(next(number), None, values, records.get(described.get("terrain.file")), known.law)

    for engine in wanted.engines:
        for label in wanted.controllers:
            yield cell(engine, LEVEL, label, LEVEL_STEPS, level)
        for label, known in wanted.controllers.items():
            robot, gait = known.robot(), known.controller().gait
            length = float(gait.step_length) if gait is not None else _FALLBACK * robot.leg_length
            for test, magnitude, phase in _cases(limits.magnitudes, limits.phases):
                place = (_BEFORE + (phase + 0.5) / limits.phases) * length
                once = DISTURBANCES[test].described(magnitude, engine, robot, place)
                yield cell(engine, test, label, _BEFORE + 1 + limits.steps_after, once, magnitude=magnitude, case=phase)
            for case, rates in enumerate(_first_rates(gait, limits.basin)):
                yield cell(engine, BASIN, label, limits.steps_after, {**level, **rates}, case=case)
        for label, (test, magnitude, seed) in itertools.product(
            wanted.controllers, _cases(margins.magnitudes, wanted.seeds)
        ):
            lasting = MARGINS[test].described(magnitude, engine, wanted.controllers[label].robot())
            chance = {"disturbances.seed": seed} if any(name.startswith("disturbances.") for name in lasting) else {}
            described = {**rough, "terrain.seed": seed, **lasting, **chance}
            columns: dict[str, Scalar] = {"ground": margins.ground, "magnitude": magnitude, "case": seed}
            yield cell(engine, test, label, margins.steps, described, **columns)
        for words, seed, label in itertools.product(grounds, range(wanted.seeds), wanted.controllers):
            described = {**grounds[words], "terrain.seed": seed}
            yield cell(engine, SURVIVAL, label, wanted.steps, described, ground=words, case=seed)


def _cases(tried: Mapping[str, tuple[float, ...]], count: int) -> Iterator[tuple[str, float, int]]:
    """List name, magnitude and case of all that is tried, with a number of cases of each magnitude."""
    for test, magnitudes in tried.items():
        for magnitude, case in itertools.product(magnitudes, range(count)):
            yield test, magnitude, case


def _ground(words: object, steps: int, folder: Path, records: dict[Scalar | None, Terrain]) -> dict[str, Scalar]:
    """Read a random ground as a cell takes it; the file that it names is added to the records.

    Args:
        words: The ground as the command line writes it.
        steps: Number of steps of the walks on it.
        folder: Folder in which files are looked for.
        records: Terrains of files that have been read, by their names.

    Raises:
        InputError: The words describe no random ground.
    """
    if not isinstance(words, str):
        raise InputError(f"a random ground is a text, as 'treads:deviation=0.03', got {shown(words)}")
    name, parameters = _parsed(words)
    known_name("random ground", name, RANDOM)
    for key, reason in (("seed", "the study draws the seeds itself"), ("length", "it follows from the steps")):
        if key in parameters:
            raise InputError(f"ground {shown(words)}: leave {key} out, {reason}")
    file = parameters.get(FILE_KEY)
    if file is not None and file not in records:
        records[file] = Terrain.from_file(folder / file)
    values = {"name": name, **parameters, "length": START + steps * LONGEST_STEP}
    return {
        f"terrain.{key}": "..".join(map(str, value)) if isinstance(value, tuple) else value
        for key, value in values.items()
    }


def rough_from(words: str) -> float:
    """Distance after which a random ground, as the command line writes it, has its full roughness, m."""
    name, parameters = _parsed(words)
    longest = signature(Terrain.waves).parameters["longest"].default
    return START + GROWN * float(parameters.get("longest", longest)) if name == "waves" else START


def _parsed(words: str) -> tuple[str, dict[str, Any]]:
    """Read the name and the parameters of a ground as the command line writes it."""
    name, _, rest = words.partition(":")
    return name, parse_parameters(rest) if rest else {}


def _first_rates(gait: Gait | None, count: int) -> Iterator[dict[str, Scalar]]:
    """Initial states of the basin's slice, as a cell takes them; none for a controller without a gait."""
    if gait is None or not count:
        return
    half = len(gait.start) // 2
    stance, swing = gait.start[half : half + 2].tolist()
    around = rates_around(gait.start, count, BASIN_WIDTH)
    for rate1, rate2 in itertools.product(*(rates.tolist() for rates in around)):
        described = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        # with knees the swing leg's is straight after a touchdown
        yield described if half == 2 else {**described, "initial.dq3": rate2 - swing}
