"""The walks that a robustness study asks for."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path

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
"""How many times as wide as usual the basin's grid is: from all of the usual one controllers find back."""

_BEFORE = 3  # steps before a disturbance comes

LONGEST_STEP = 0.6
"""Ground that each step of a walk on random ground is given, m."""

_FALLBACK = 0.38  # step length of a controller that imitates no gait, in leg lengths


@dataclass(frozen=True)
class Plan:
    """What a robustness study is.

    Attributes:
        study: Its walks.
        controllers: Their labels.
        engines: Their names.
        grounds: Random grounds, as the command line writes them.
        seeds: Number of each of them.
        steps: Most steps on them.
        disturbances: Names of those that are tried.
        share: Of the cases of a disturbance that must be survived.
        phases: Number of phases of the step at which it comes.
        steps_after: Steps that must be made after it.
        torque: Greatest torque of either joint with which it counts as survived, N m; None: any.
        basin: Number of first rates of either leg from which walks on level ground begin; 0: none do.
        margins: Names of the disturbances of whole walks that are tried.
        margin_ground: The rough ground under them.
        margin_steps: Steps that must be made there.
        margin_share: Of the seeds on which they must be.
        scuffing: The rule of all walks.
    """

    study: Study
    controllers: tuple[str, ...]
    engines: tuple[str, ...]
    grounds: tuple[str, ...]
    seeds: int
    steps: int
    disturbances: tuple[str, ...]
    share: float
    phases: int
    steps_after: int
    torque: float | None
    basin: int
    margins: tuple[str, ...]
    margin_ground: str
    margin_steps: int
    margin_share: float
    scuffing: ScuffingRule


def walks_of(
    wanted: Plan,
    labelled: Mapping[str, Mapping[str, Scalar]],
    chosen: Mapping[str, Sequence[float]],
    lasting: Mapping[str, Sequence[float]],
    laws: Mapping[str, str],
) -> Iterator[Cell]:
    """All walks, the short ones first.

    Args:
        wanted: The plan, whose study is not read.
        labelled: Settings of the controllers and of their robots by the controllers' labels.
        chosen: Magnitudes by disturbance.
        lasting: Magnitudes by disturbance of whole walks.
        laws: Where the user's own controllers are.

    Raises:
        InputError: A random ground is none.
    """
    count = itertools.count()
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    robots = {label: Cell(0, None, settings).robot() for label, settings in labelled.items()}
    records: dict[Scalar | None, Terrain] = {}
    folder = wanted.study.path.parent
    grounds = {words: _ground(words, wanted.steps, folder, records) for words in wanted.grounds}

    def cell(engine: str, test: str, label: str, steps: int, told: Mapping[str, Scalar], **columns: Scalar) -> Cell:
        settings, straight = labelled[label], not robots[label].knees
        values = {
            "engine": engine,
            "test": test,
            "controller": label,
            **columns,
            f"{LIMIT}.steps": steps,
            **({} if test == BASIN else {"initial": "gait"}),
            **(rule if straight else {}),
            **settings,
            **told,
        }
        record, law = records.get(told.get("terrain.file")), laws.get(str(settings["controller.name"]))
        return Cell(next(count), None, values, record, law)

    for engine in wanted.engines:
        for label in wanted.controllers:
            yield cell(engine, LEVEL, label, LEVEL_STEPS, {"terrain.name": "level"})
        for label in wanted.controllers:
            gait, leg_length = _imitated(labelled[label], laws)
            length = float(gait.step_length) if gait is not None else _FALLBACK * leg_length
            for test, magnitudes in chosen.items():
                for magnitude, phase in itertools.product(magnitudes, range(wanted.phases)):
                    place = (_BEFORE + (phase + 0.5) / wanted.phases) * length
                    told = DISTURBANCES[test].values(magnitude, place)
                    steps = _BEFORE + 1 + wanted.steps_after
                    yield cell(engine, test, label, steps, told, magnitude=magnitude, case=phase)
            for case, rates in enumerate(_first_rates(gait, wanted.basin)):
                yield cell(engine, BASIN, label, wanted.steps_after, {"terrain.name": "level", **rates}, case=case)
        rough = _ground(wanted.margin_ground, wanted.margin_steps, folder, records)
        for label, (test, magnitudes) in itertools.product(wanted.controllers, lasting.items()):
            for magnitude, seed in itertools.product(magnitudes, range(wanted.seeds)):
                told = {**rough, "terrain.seed": seed, **MARGINS[test].told(magnitude, engine, robots[label])}
                if any(name.startswith("disturbances.") for name in told):
                    told["disturbances.seed"] = seed
                steps = wanted.margin_steps
                yield cell(
                    engine, test, label, steps, told, ground=wanted.margin_ground, magnitude=magnitude, case=seed
                )
        for words, seed, label in itertools.product(wanted.grounds, range(wanted.seeds), wanted.controllers):
            told = {**grounds[words], "terrain.seed": seed}
            yield cell(engine, SURVIVAL, label, wanted.steps, told, ground=words, case=seed)


def _ground(words: object, steps: int, folder: Path, records: dict[Scalar | None, Terrain]) -> dict[str, Scalar]:
    """A random ground of the command line's words, as a cell takes it; the file that it names is added to the records.

    Args:
        words: As the study says them.
        steps: Of the walks on it.
        folder: Where files are looked for.
        records: Terrains of files that have been read, by their names.

    Raises:
        InputError: They mean none.
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
    """Where a random ground, as the command line writes it, has grown as rough as it goes on, m."""
    name, _, rest = words.partition(":")
    if name != "waves":
        return START
    usual = signature(Terrain.waves).parameters["longest"].default
    return START + GROWN * float((parse_parameters(rest) if rest else {}).get("longest", usual))


def _imitated(settings: Mapping[str, Scalar], laws: Mapping[str, str]) -> tuple[Periodic | None, float]:
    """The gait that a controller imitates on level ground, and the leg length of its robot, m."""
    cell = Cell(0, None, settings, None, laws.get(str(settings["controller.name"])))
    return cell.controller().gait, cell.robot().leg_length


def _first_rates(gait: Periodic | None, count: int) -> Iterator[dict[str, Scalar]]:
    """First states of the basin's slice, as a cell takes them; none where there is no gait to be found again."""
    if gait is None or not count:
        return
    half = len(gait.start) // 2
    stance, swing = gait.start[half : half + 2].tolist()
    around = rates_around(gait.start, count, BASIN_WIDTH)
    for rate1, rate2 in itertools.product(*(rates.tolist() for rates in around)):
        told = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        yield told if half == 2 else {**told, "initial.dq3": rate2 - swing}  # the knee is straight after a touchdown
