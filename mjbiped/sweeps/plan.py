"""A study file and the walks that it describes."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import count, product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from mjbiped.control.loading import is_reference, located
from mjbiped.control.unpowered import Unpowered
from mjbiped.control.validation import try_out
from mjbiped.engines.checks import check_controller
from mjbiped.engines.names import ENGINES
from mjbiped.engines.plan import INITIAL_STATES, Terms, make_plan
from mjbiped.errors import GaitError, InputError, prefixed, shortened, shown
from mjbiped.gaits.described import usual_gait
from mjbiped.gaits.gait import Gait
from mjbiped.robots.robot import Robot
from mjbiped.sweeps.cell import KNEES_MEASURES, LIMIT, MEASURES, OPTIONS, Cell, state_of
from mjbiped.sweeps.sections import OF_WALK, SECTIONS, Settings, parts_of
from mjbiped.sweeps.values import Scalar, check_keys, generator
from mjbiped.terrain.files import FILE_SUFFIXES, parse_toml
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import Draw
from mjbiped.utils.reading import read_text

KEYS = ("seed", "samples", *OF_WALK, *SECTIONS, "plot")

MOST_CELLS = domains.WALKS.high

FINISHED = "finished"
"""Measure beside `MEASURES` in a study's figures: the share of walks that finished."""

_STAND_IN_SLOPE = math.radians(2.0)  # of a gait that settings are checked with

Combination: TypeAlias = dict[str, Scalar | Draw]
"""A value for each name; a distribution stands for the values that are drawn from it."""


@dataclass(frozen=True)
class Study:
    """A study as its file describes it.

    Attributes:
        path: Path of the file.
        cells: The walks, in the order of the table.
        varied: Names of the values that differ between cells.
        drawn: Names of the values that are drawn from distributions; where there are any, cells have a sample.
        logarithmic: Names of the values whose logarithm is drawn.
        declared: Content of the file without the figures, in plain JSON types.
        plot_parameters: Up to three of `varied` for the figures; empty: use the defaults.
        plot_measures: Names out of `MEASURES` and `FINISHED` for the figures; empty: use the defaults.
        laws: Places of the user's own controllers, with whole paths, by their names in the file.
    """

    path: Path
    cells: tuple[Cell, ...]
    varied: tuple[str, ...]
    drawn: frozenset[str]
    logarithmic: frozenset[str]
    declared: Mapping[str, Any]
    plot_parameters: tuple[str, ...] = ()
    plot_measures: tuple[str, ...] = ()
    laws: Mapping[str, str] = field(default_factory=dict)

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the columns of measures."""
        return KNEES_MEASURES if any("knee" in cell.kind.joints for cell in self.cells) else MEASURES

    @property
    def digest(self) -> str:
        """Digest of all values of the cells and of the content of terrain files."""
        digest = hashlib.sha256()
        grounds = {cell.ground for cell in self.cells}
        texts = {ground: "" if ground is None else json.dumps(ground.to_dict()) for ground in grounds}
        for cell in self.cells:
            digest.update(json.dumps([cell.index, cell.sample, dict(cell.values), texts[cell.ground]]).encode())
        return digest.hexdigest()


def read_study(path: Path) -> Study:
    """Read a study file, and check all that can be checked without walking.

    Raises:
        InputError: It cannot be read, or says anything that no walk can have; the message names the place.
    """
    with prefixed(f"study {shortened(str(path))}: "):
        return plan(path, parse_toml(read_text(path)))


def plan(path: Path, content: Mapping[str, Any]) -> Study:
    """Read the study of a file's content; terrain files are looked for in the file's folder.

    Raises:
        InputError: As `read_study`.
    """
    check_keys("key", content, KEYS)
    seed = domains.SEED.check("seed", content.get("seed", 0))
    read = list(parts_of(content, path.parent))
    draws = {name: each for part in read for one in part for name, each in one.items() if isinstance(each, Draw)}
    drawn = bool(draws)
    if drawn != ("samples" in content):
        raise InputError(
            "values are drawn from distributions, but samples is missing; add for instance samples = 100"
            if drawn
            else "samples is given, but nothing is drawn: no value has a distribution, as {uniform = [low, high]}"
        )
    samples = domains.WALKS.check("samples", content["samples"]) if drawn else 1
    check_count(samples * math.prod(sum(math.prod(map(len, _grid(one))) for one in part) for part in read))
    parts = [[dict(zip(one, each, strict=True)) for one in part for each in product(*_grid(one))] for part in read]
    varied = tuple(name for combinations in parts for name in _varied(combinations))
    grounds = _read_grounds(path, parts[-1])
    named = {str(one["controller.name"]) for each in parts for one in each if "controller.name" in one}
    laws = {name: located(name, path.parent) for name in sorted(named) if is_reference(name)}
    cells = tuple(_cells(parts, seed, samples, drawn, grounds, laws))
    check_cells(cells, varied)
    logarithmic = frozenset(name for name, value in draws.items() if value.kind == "log_uniform")
    declared = {key: value for key, value in content.items() if key != "plot"}
    plot = _plot(content.get("plot", {}), varied)
    return Study(path, cells, varied, frozenset(draws), logarithmic, declared, *plot, laws)


def _grid(settings: Settings) -> list[tuple[Scalar | Draw, ...]]:
    """Values of each choice; a distribution counts as one value."""
    return [(choice,) if isinstance(choice, Draw) else choice for choice in settings.values()]


def check_count(count: int) -> None:
    """Refuse more walks than one study can have.

    Raises:
        InputError: There are more than `MOST_CELLS`.
    """
    if count > MOST_CELLS:
        raise InputError(
            f"these are {shown(count)} walks; at most {MOST_CELLS} are one study: take fewer values or samples"
        )


def _cells(
    parts: Sequence[Sequence[Combination]],
    seed: int,
    samples: int,
    drawn: bool,
    grounds: Mapping[str, Terrain],
    laws: Mapping[str, str],
) -> Iterator[Cell]:
    """Make all cells: the whole grid for each sample, which has the same drawn values everywhere in its grid."""
    index = count()
    for sample in range(samples):
        for combination in product(*parts):
            values = {
                name: value.value(generator(seed, sample, name)) if isinstance(value, Draw) else value
                for part in combination
                for name, value in part.items()
            }
            ground = grounds.get(str(values.get("terrain.file")))
            law = laws.get(str(values["controller.name"]))
            yield Cell(next(index), sample if drawn else None, values, ground, law)


def _varied(combinations: Sequence[Combination]) -> list[str]:
    """Names whose values differ between combinations."""
    names, first = dict.fromkeys(name for each in combinations for name in each), combinations[0]
    differ = {name for each in combinations for name in names if each.get(name) != first.get(name)}
    return [name for name in names if name in differ or isinstance(first.get(name), Draw)]


def _read_grounds(path: Path, combinations: Sequence[Combination]) -> dict[str, Terrain]:
    """Read the terrain files, by their names in the study.

    Raises:
        InputError: A file is no terrain file.
    """
    named = dict.fromkeys(each["terrain.file"] for each in combinations if "terrain.file" in each)
    for name in named:
        if not isinstance(name, str):
            raise InputError(f"terrain.file must be the path of a file ({', '.join(FILE_SUFFIXES)}), got {shown(name)}")
    return {str(name): Terrain.from_file(path.parent / str(name)) for name in named}


def check_cells(cells: Sequence[Cell], varied: Sequence[str]) -> None:
    """Refuse values that no walk can have; values shared by many cells are checked once.

    Raises:
        InputError: A cell has such a value.
    """
    seen: set[tuple[object, ...]] = set()
    for cell in cells:
        for sections, check in (
            (("engine", LIMIT, *OPTIONS, "initial", "robot", "disturbances", "scuffing"), _check_walk),
            (("robot", "model", "controller"), _check_controller),
            (("terrain",), Cell.terrain),
        ):
            mine = {name: value for name, value in cell.values.items() if name.split(".")[0] in sections}
            # any seed is as good as another: thousands of terrains are not made for a check
            key = tuple((name, type(value), value) for name, value in mine.items() if not _is_fine_seed(name, value))
            if key in seen:
                continue
            seen.add(key)
            try:
                check(cell)
            except (InputError, TypeError) as error:
                named = ", ".join(f"{name} = {shown(value)}" for name, value in mine.items() if name in varied)
                place = f"cell {cell.index} ({shortened(named)}): " if named else ""
                raise InputError(f"{place}{error}") from error


def _is_fine_seed(name: str, value: Scalar) -> bool:
    return name in ("terrain.seed", "disturbances.seed") and type(value) is int and 0 <= value < 2**64


@cache
def _stand_in(kind: type[Robot]) -> Gait | None:
    """A gait with which settings are checked; None where there is none, and no law that imitates one."""
    try:
        return usual_gait(kind(), _STAND_IN_SLOPE)
    except GaitError:
        return None


def _check_controller(cell: Cell) -> None:
    """Refuse settings of the robot and of the controller that are not valid; a user's own law is tried out."""
    gait = _stand_in(type(cell.robot()))
    controller = cell.controller(gait)
    if cell.law is not None:
        q, dq = np.split(np.zeros(2 * len(cell.kind.angles)) if gait is None else gait.start, 2)
        check_controller(controller)
        try_out(controller, tuple(q.tolist()), tuple(dq.tolist()))


def _check_walk(cell: Cell) -> None:
    """Refuse engine, limits, initial state, scuffing rule or disturbances that no walk of the robot can have."""
    engine = known_name("engine", cell.values["engine"], ENGINES)
    for key in OPTIONS:
        if key in cell.values and engine != "mujoco":
            raise InputError(f"{key} is for the engine mujoco; the engine {engine} has none")
    if "initial" in cell.values:
        known_name("initial state", cell.values["initial"], INITIAL_STATES)
    else:
        _check_initial(cell)
    limits = cell.section(LIMIT)
    terms = Terms(cell.engine(), limits.get("steps"), limits.get("distance"), cell.robot(), None, cell.scuffing())
    make_plan(terms, Unpowered(), Terrain.level(), "rest", disturbances=cell.disturbances())


def _check_initial(cell: Cell) -> None:
    """Refuse an initial state that does not fit the robot."""
    given, valid = cell.section("initial"), state_of(type(cell.robot()))
    for name, value in given.items():
        if known_name("key of initial", name, ("around", *valid)) == "around":
            known_name("initial.around", value, INITIAL_STATES)
        else:
            valid[name].check(f"initial.{name}", value)
    missing = [name for name in valid if name not in given]
    if missing and "around" not in given:
        raise InputError(
            f"initial needs {', '.join(missing)} as well: all of {', '.join(valid)} (rad, rad/s), or around = one of "
            f"{', '.join(INITIAL_STATES)} and the deviations from it"
        )


def _plot(table: object, varied: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read the parameters and measures of the figures.

    Raises:
        InputError: The table holds anything else.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"plot must be a table [plot], got {shown(table)}")
    check_keys("key of plot", table, ("parameters", "measures"))
    found = []
    for key, valid, most in (("parameters", varied, 3), ("measures", (*KNEES_MEASURES, FINISHED), 6)):
        names = table.get(key, [])
        if not isinstance(names, list) or len(names) > most:
            raise InputError(f"plot.{key} must be a list of up to {most} names, got {shown(names)}")
        found.append(tuple(known_name(f"name in plot.{key}", name, valid) for name in names))
    return found[0], found[1]
