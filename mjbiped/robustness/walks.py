"""The plan of a robustness study, and its walks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import NamedTuple

from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Periodic
from mjbiped.limit_cycles.basin import rates_around
from mjbiped.robustness.limits import DISTURBANCES, MARGINS
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import LIMIT, Cell
from mjbiped.sweeps.plan import Study
from mjbiped.sweeps.values import Scalar
from mjbiped.terrain.files import FILE_KEY, parse_parameters
from mjbiped.terrain.presets import GROWN, RANDOM, START
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import known_name

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


@dataclass(frozen=True)
class Trial:
    """Disturbances that are tried in the same way.

    Attributes:
        magnitudes: The magnitudes that are tried, by the disturbance's name.
        steps: Number of steps that must be made after a single disturbance, or under a lasting one.
        share: Share of the cases that must be survived.
        torque: Greatest torque of either joint with which a case counts as survived, N m; None: any.
    """

    magnitudes: Mapping[str, tuple[float, ...]]
    steps: int
    share: float
    torque: float | None = None


@dataclass(frozen=True)
class Plan:
    """What a robustness study tries.

    Attributes:
        study: Its walks.
        controllers: Settings of the controllers and of their robots, by label.
        engines: Names of the engines.
        grounds: Random grounds, as the command line writes them.
        seeds: Number of grounds of each kind.
        steps: Greatest number of steps on them.
        limits: Single disturbances of level ground.
        phases: Number of phases of the step at which each of them comes.
        basin: Number of first rates of either leg from which walks on level ground begin; 0: none do.
        margins: Disturbances of whole walks over rough ground.
        margin_ground: The rough ground under them.
        scuffing: The rule of all walks.
    """

    study: Study
    controllers: Mapping[str, Mapping[str, Scalar]]
    engines: tuple[str, ...]
    grounds: tuple[str, ...]
    seeds: int
    steps: int
    limits: Trial
    phases: int
    basin: int
    margins: Trial
    margin_ground: str
    scuffing: ScuffingRule

    @property
    def count(self) -> int:
        """Number of walks."""
        single, lasting = (sum(map(len, trial.magnitudes.values())) for trial in (self.limits, self.margins))
        each = 1 + self.phases * single + self.basin**2 + self.seeds * (len(self.grounds) + lasting)
        return len(self.engines) * len(self.controllers) * each


class _Asked(NamedTuple):
    """A walk before it is a cell: its columns in the table, and values of the cell that are its own."""

    engine: str
    test: str
    controller: str
    steps: int
    told: Mapping[str, Scalar]
    columns: Mapping[str, Scalar]


def walks_of(wanted: Plan) -> Iterator[Cell]:
    """Make all walks of a plan, whose study has no cells yet; the short walks come first.

    Raises:
        InputError: The words of a random ground are not valid.
    """
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    records: dict[Scalar | None, Terrain] = {}
    plain = {label: _plain_cell(wanted, label) for label in wanted.controllers}
    for index, walk in enumerate(_asked(wanted, plain, records)):
        values = {
            "engine": walk.engine,
            "test": walk.test,
            "controller": walk.controller,
            **walk.columns,
            f"{LIMIT}.steps": walk.steps,
            **({} if walk.test == BASIN else {"initial": "gait"}),
            **({} if plain[walk.controller].kind.collides_from_lift_off else rule),
            **wanted.controllers[walk.controller],
            **walk.told,
        }
        record = records.get(walk.told.get("terrain.file"))
        yield Cell(index, None, values, record, plain[walk.controller].law)


def _plain_cell(wanted: Plan, label: str) -> Cell:
    """Make a cell with nothing but a controller and its robot."""
    settings = wanted.controllers[label]
    return Cell(0, None, settings, None, wanted.study.laws.get(str(settings["controller.name"])))


def _asked(wanted: Plan, plain: Mapping[str, Cell], records: dict[Scalar | None, Terrain]) -> Iterator[_Asked]:
    """List all walks, and read the files of their grounds into the records."""
    folder, level = wanted.study.path.parent, {"terrain.name": "level"}
    grounds = {words: _ground(words, wanted.steps, folder, records) for words in wanted.grounds}
    after, whole = wanted.limits.steps, wanted.margins.steps
    rough = _ground(wanted.margin_ground, whole, folder, records)
    for engine in wanted.engines:
        for label in plain:
            yield _Asked(engine, LEVEL, label, LEVEL_STEPS, level, {})
        for label, cell in plain.items():
            robot, gait = cell.robot(), cell.controller().gait
            length = float(gait.step_length) if gait is not None else _FALLBACK * robot.leg_length
            for test, magnitude, phase in _cases(wanted.limits, wanted.phases):
                place = (_BEFORE + (phase + 0.5) / wanted.phases) * length
                told = DISTURBANCES[test].told(magnitude, engine, robot, place)
                columns: dict[str, Scalar] = {"magnitude": magnitude, "case": phase}
                yield _Asked(engine, test, label, _BEFORE + 1 + after, told, columns)
            for case, rates in enumerate(_first_rates(gait, wanted.basin)):
                yield _Asked(engine, BASIN, label, after, {**level, **rates}, {"case": case})
        for label, (test, magnitude, seed) in itertools.product(plain, _cases(wanted.margins, wanted.seeds)):
            told = {**rough, "terrain.seed": seed, **MARGINS[test].told(magnitude, engine, plain[label].robot())}
            if any(name.startswith("disturbances.") for name in told):
                told["disturbances.seed"] = seed
            columns = {"ground": wanted.margin_ground, "magnitude": magnitude, "case": seed}
            yield _Asked(engine, test, label, whole, told, columns)
        for words, seed, label in itertools.product(grounds, range(wanted.seeds), plain):
            told = {**grounds[words], "terrain.seed": seed}
            yield _Asked(engine, SURVIVAL, label, wanted.steps, told, {"ground": words, "case": seed})


def _cases(trial: Trial, count: int) -> Iterator[tuple[str, float, int]]:
    """List name, magnitude and case of all that is tried, with a number of cases of each magnitude."""
    for test, magnitudes in trial.magnitudes.items():
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
    name, _, rest = words.partition(":")
    parameters = parse_parameters(rest) if rest else {}
    known_name("random ground", name, RANDOM)
    for key, reason in (("seed", "the study draws the seeds itself"), ("length", "it follows from the steps")):
        if key in parameters:
            raise InputError(f"ground {shown(words)}: leave {key} out, {reason}")
    parameters["length"] = START + steps * LONGEST_STEP
    file = parameters.get(FILE_KEY)
    if file is not None and file not in records:
        records[file] = Terrain.from_file(folder / file)
    Terrain.preset(name, **{**parameters, "seed": 0, **({} if file is None else {FILE_KEY: records[file]})})
    return {
        "terrain.name": name,
        **{
            f"terrain.{key}": "..".join(map(str, value)) if isinstance(value, tuple) else value
            for key, value in parameters.items()
        },
    }


def rough_from(words: str) -> float:
    """Distance after which a random ground, as the command line writes it, has its full roughness, m."""
    name, _, rest = words.partition(":")
    if name != "waves":
        return START
    usual = signature(Terrain.waves).parameters["longest"].default
    return START + GROWN * float((parse_parameters(rest) if rest else {}).get("longest", usual))


def _first_rates(gait: Periodic | None, count: int) -> Iterator[dict[str, Scalar]]:
    """Initial states of the basin's slice, as a cell takes them; none for a controller without a gait."""
    if gait is None or not count:
        return
    half = len(gait.start) // 2
    stance, swing = gait.start[half : half + 2].tolist()
    around = rates_around(gait.start, count, BASIN_WIDTH)
    for rate1, rate2 in itertools.product(*(rates.tolist() for rates in around)):
        told = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        yield told if half == 2 else {**told, "initial.dq3": rate2 - swing}  # the knee is straight after a touchdown
