"""The plan of a robustness study, and its walks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import Any

from mjbiped.errors import InputError, shown
from mjbiped.gaits.gait import Gait
from mjbiped.limit_cycles.basin import rates_around
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Told
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
    """Disturbances that share one way of testing.

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
    """The tests of a robustness study.

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


def walks_of(wanted: Plan) -> Iterator[Cell]:
    """Make all walks of a plan, whose study has no cells yet; the short walks come first.

    Raises:
        InputError: The words of a random ground are not valid.
    """
    folder, laws, number = wanted.study.path.parent, wanted.study.laws, itertools.count()
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    plain = {  # with nothing but a controller and its robot
        label: Cell(0, None, settings, None, laws.get(str(settings["controller.name"])))
        for label, settings in wanted.controllers.items()
    }
    records: dict[Scalar | None, Terrain] = {}
    grounds = {words: _ground(words, wanted.steps, folder, records) for words in wanted.grounds}
    level, after, whole = {"terrain.name": "level"}, wanted.limits.steps, wanted.margins.steps
    rough = _ground(wanted.margin_ground, whole, folder, records)

    def cell(engine: str, test: str, label: str, steps: int, told: Told, **columns: Scalar) -> Cell:
        values = {
            "engine": engine,
            "test": test,
            "controller": label,
            **columns,
            f"{LIMIT}.steps": steps,
            **({} if test == BASIN else {"initial": "gait"}),
            **({} if plain[label].kind.collides_from_lift_off else rule),
            **wanted.controllers[label],
            **told,
        }
        return Cell(next(number), None, values, records.get(told.get("terrain.file")), plain[label].law)

    for engine in wanted.engines:
        for label in plain:
            yield cell(engine, LEVEL, label, LEVEL_STEPS, level)
        for label, known in plain.items():
            robot, gait = known.robot(), known.controller().gait
            length = float(gait.step_length) if gait is not None else _FALLBACK * robot.leg_length
            for test, magnitude, phase in _cases(wanted.limits, wanted.phases):
                place = (_BEFORE + (phase + 0.5) / wanted.phases) * length
                told = DISTURBANCES[test].told(magnitude, engine, robot, place)
                yield cell(engine, test, label, _BEFORE + 1 + after, told, magnitude=magnitude, case=phase)
            for case, rates in enumerate(_first_rates(gait, wanted.basin)):
                yield cell(engine, BASIN, label, after, {**level, **rates}, case=case)
        for label, (test, magnitude, seed) in itertools.product(plain, _cases(wanted.margins, wanted.seeds)):
            told = {**rough, "terrain.seed": seed, **MARGINS[test].told(magnitude, engine, plain[label].robot())}
            if any(name.startswith("disturbances.") for name in told):
                told["disturbances.seed"] = seed
            ground = wanted.margin_ground
            yield cell(engine, test, label, whole, told, ground=ground, magnitude=magnitude, case=seed)
        for words, seed, label in itertools.product(grounds, range(wanted.seeds), plain):
            told = {**grounds[words], "terrain.seed": seed}
            yield cell(engine, SURVIVAL, label, wanted.steps, told, ground=words, case=seed)


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
    name, parameters = _parsed(words)
    known_name("random ground", name, RANDOM)
    for key, reason in (("seed", "the study draws the seeds itself"), ("length", "it follows from the steps")):
        if key in parameters:
            raise InputError(f"ground {shown(words)}: leave {key} out, {reason}")
    parameters["length"] = START + steps * LONGEST_STEP
    file = parameters.get(FILE_KEY)
    if file is not None and file not in records:
        records[file] = Terrain.from_file(folder / file)
    Terrain.preset(name, **{**parameters, "seed": 0, **({} if file is None else {FILE_KEY: records[file]})})
    ranges = {key: "..".join(map(str, value)) for key, value in parameters.items() if isinstance(value, tuple)}
    return {f"terrain.{key}": value for key, value in {"name": name, **parameters, **ranges}.items()}


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
        told = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        yield told if half == 2 else {**told, "initial.dq3": rate2 - swing}  # the knee is straight after a touchdown
