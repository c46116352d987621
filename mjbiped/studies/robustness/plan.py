"""A robustness study's file and the walks that it asks for; docs/studies.md describes the file."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar

from mjbiped.control.loading import is_reference, located
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.gaits.gait import Gait
from mjbiped.limit_cycles.basin import rates_around
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.studies.cell import LIMIT, Cell, check_keys
from mjbiped.studies.plan import SCUFFING, Study, check_cells, check_count, read_section, read_table
from mjbiped.studies.robustness.limits import DISTURBANCES, MARGINS, Checked, Disturbance, Limits, Margins, Values
from mjbiped.terrain.files import FILE_KEY, parse_parameters, parse_toml
from mjbiped.terrain.presets import GROWN, RANDOM, START
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import Draw, Scalar, read_choice
from mjbiped.utils.files import read_text

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing", "robot")

LEVEL, SURVIVAL, BASIN = "level", "survival", "basin"
"""Tests beside `DISTURBANCES` and `MARGINS`: steady walking on level ground, random ground until the robot falls, and
level ground from other first rates than the gait's."""

LEVEL_STEPS = 40
BASIN_RATES = 20  # of either leg, unless a study says otherwise
BASIN_WIDTH = 3.0
"""Width of the basin's grid in multiples of the usual one, from all of which controllers return to their cycle."""

VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""

_BEFORE = 3  # steps before a disturbance comes
_LONGEST_STEP = 0.6  # length of random ground that is laid for each step of a walk, m
_FALLBACK = 0.38  # step length of a controller that imitates no gait, in leg lengths


AnyTried = TypeVar("AnyTried", Limits, Margins)

Ground: TypeAlias = tuple[Values, Terrain | None]
"""Ground as a cell takes it: values, and the elevation record that they take a stretch of."""


@dataclass(frozen=True)
class Plan(Checked):
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


def read_plan(path: Path) -> Plan:
    """Read a robustness study's file, and check all that can be checked without walking.

    Raises:
        InputError: It cannot be read, or says anything that no study can have; the message names the place.
    """
    with prefixed(f"robustness study {shortened(str(path))}: "):
        return plan(path, parse_toml(read_text(path)))


def plan(path: Path, content: Mapping[str, Any]) -> Plan:
    """Read the plan of a file's content; single disturbances are tried if it names them, or no random grounds.

    Raises:
        InputError: As `read_plan`.
    """
    check_keys("key", content, KEYS)
    controllers = _controllers(content.get("controller", [{}]), content.get("robot", {}), path.parent)
    if "scuffing" in content and all(each.kind.collides_from_lift_off for each in controllers.values()):
        raise InputError("scuffing is for straight legs: with knees the swing foot collides from lift-off on")
    grounds = content.get("grounds", ["treads:deviation=0.03"])
    single = DISTURBANCES if "limits" in content or "grounds" not in content else {}
    wanted = Plan(
        declared=dict(content),
        folder=path.parent,
        controllers=controllers,
        engines=tuple(map(str, read_choice("engine", content.get("engine") or "hybrid"))),
        grounds=tuple(map(str, read_choice("grounds", grounds))) if grounds != [] else (),
        seeds=content.get("seeds", 20),
        steps=content.get("steps", 1000),
        limits=_tried(Limits, content, "limits", single, basin=_basin(read_table(content, "limits")) if single else 0),
        margins=_tried(Margins, content, "margins", MARGINS if "margins" in content else {}),
        scuffing=ScuffingRule(**read_table(content, "scuffing", SCUFFING)),
    )
    check_count(wanted.count)
    check_cells(wanted.study.cells, wanted.study.varied)
    return wanted


def _tried(
    kind: type[AnyTried], content: Mapping[str, object], name: str, disturbances: Mapping[str, Disturbance], **more: int
) -> AnyTried:
    """Read a table of disturbances, all unless it names some: their magnitudes, and how they are tried.

    Raises:
        InputError: A key is unknown, or a value is not valid.
    """
    settings: list[str] = [field.name for field in fields(kind) if field.name != "magnitudes"]
    table = read_table(content, name, (*settings, *disturbances))
    magnitudes = {}
    with prefixed(f"{name}."):
        for test in [test for test in disturbances if test in table] or disturbances:
            given, falls = table.get(test, True), disturbances[test].falls
            if given is not False:
                numbers = disturbances[test].magnitudes if given is True else given
                magnitudes[test] = tuple(domains.STUDY_POSITIVE.array(test, numbers, (None,)).tolist())
                if not magnitudes[test] or list(magnitudes[test]) != sorted(set(magnitudes[test]), reverse=falls):
                    order = "descend" if falls else "ascend"
                    raise InputError(f"{test}: magnitudes must {order}, the gentlest first; got {shown(given)}")
        return kind(magnitudes, **{**{key: table[key] for key in settings if key in table}, **more})


def _basin(limits: Mapping[str, object]) -> int:
    """Read the number of first rates of either leg; `BASIN_RATES`, unless the file names disturbances but no basin."""
    given = limits.get(BASIN, not any(name in limits for name in DISTURBANCES))
    return given * BASIN_RATES if isinstance(given, bool) else domains.GRID.check(f"limits.{BASIN}", given)


def _controllers(tables: object, usual: object, folder: Path) -> dict[str, Cell]:
    """Read controllers and their robots by label: cells that know nothing else.

    Args:
        tables: Tables of the controllers.
        usual: Table of the robot of those that do not name their own.
        folder: The file's folder, where the controllers' files are looked for.

    Raises:
        InputError: Something in them is not valid.
    """
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"controller must be tables [[controller]], got {shown(tables)}")
    labelled: dict[str, Cell] = {}
    for number, table in enumerate(tables, start=1):
        robot = read_table({"robot": usual, **table}, "robot")
        law = {key: value for key, value in table.items() if key not in ("label", "robot", "torque_limit")}
        settings: dict[str, Scalar] = {}
        for name, choice in {**read_section("robot", robot), **read_section("controller", law)}.items():
            if len(choice) != 1 or isinstance(choice[0], Draw):
                raise InputError(f"controller {number}: {name} must be one value; give each variant a [[controller]]")
            settings[name] = choice[0]
        if "torque_limit" in table:
            greatest = domains.TORQUE_LIMIT.check(f"controller {number}: torque_limit", table["torque_limit"])
            settings["disturbances.torque_limit"] = greatest
        name = str(settings["controller.name"])
        label = table.get("label", name)
        if not isinstance(label, str) or label in labelled:
            raise InputError(f"controller {number}: label = {shown(label)}: must be a text of its own")
        labelled[label] = Cell(0, None, settings, law=located(name, folder) if is_reference(name) else None)
    return labelled


def _walks_of(wanted: Plan) -> Iterator[Cell]:
    """Make all walks of a plan, engine by engine."""
    limits, margins, number = wanted.limits, wanted.margins, itertools.count()
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
        for words, seed, label in itertools.product(grounds, range(wanted.seeds), wanted.controllers):
            described, record = grounds[words]
            there = {**described, "terrain.seed": seed}, record
            yield cell(engine, SURVIVAL, label, wanted.steps, there, ground=words, case=seed)


def _cases(tried: Mapping[str, tuple[float, ...]], count: int) -> Iterator[tuple[str, float, int]]:
    """List name, magnitude and case of all that is tried, with a number of cases of each magnitude."""
    for test, magnitudes in tried.items():
        for magnitude, case in itertools.product(magnitudes, range(count)):
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
    for rate1, rate2 in itertools.product(*(rates.tolist() for rates in around)):
        described = {"initial.around": "gait", "initial.dq1": rate1 - stance, "initial.dq2": rate2 - swing}
        # with knees the swing leg's is straight after a touchdown
        yield described if half == 2 else {**described, "initial.dq3": rate2 - swing}
