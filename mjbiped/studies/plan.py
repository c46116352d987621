"""A study file: the choices for each quantity by its dotted name, and the walks that they describe.

Each cell refuses inputs that its walk cannot have.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.control.controller import Unpowered
from mjbiped.control.functions import try_out
from mjbiped.control.loading import is_reference, located
from mjbiped.control.registry import DEFAULT_CONTROLLER
from mjbiped.disturbances.disturbances import SETTINGS
from mjbiped.engines.base import DEFAULT_ENGINE
from mjbiped.engines.checks import check_controller, check_ground
from mjbiped.engines.plan import INITIAL_STATES, Terms, make_plan
from mjbiped.errors import GaitError, InputError, prefixed, shortened, shown
from mjbiped.gaits.described import usual_gait
from mjbiped.gaits.gait import Gait
from mjbiped.robots.robot import Robot
from mjbiped.studies.cell import KNEES_MEASURES, LIMIT, LIMITS, MEASURES, OPTIONS, Cell, check_keys
from mjbiped.terrain.files import FILE_KEY, parse_toml
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import known_name
from mjbiped.utils.draws import Choice, Draw, Scalar, generator, read_choice
from mjbiped.utils.files import read_text

OF_WALK = ("engine", *LIMITS, *OPTIONS)
SECTIONS = ("initial", "controller", "robot", "model", "disturbances", "scuffing", "terrain")
SCUFFING = ("reach", "delay")
KEYS = ("seed", "samples", *OF_WALK, *SECTIONS, "plot")

_NAMES = ("kind", "name")  # keys of a section that decide what else can stand in it, and come first
_VALID = {"disturbances": SETTINGS, "scuffing": SCUFFING}
_USUAL = {"controller": {"name": DEFAULT_CONTROLLER}, "terrain": {"name": "mixed"}}
_ENDS, _PLUS_MINUS = {"low", "high"}, {"plus_minus"}

MOST_CELLS = domains.WALKS.high

FINISHED = "finished"
"""Measure beside `MEASURES` in a study's figures: the share of walks that finished."""

_STAND_IN_SLOPE = math.radians(2.0)  # of a gait that settings are checked with


@dataclass(frozen=True)
class Study:
    """A study as its file describes it.

    Attributes:
        cells: The walks, in the order of the table.
        varied: Names of the values that differ between cells.
        declared: Content of the file without the figures, in plain JSON types.
        drawn: Names of the values that are drawn from distributions; where there are any, cells have a sample.
        plot_parameters: Up to three of `varied` for the figures; empty: use the defaults.
        plot_measures: Names out of `MEASURES` and `FINISHED` for the figures; empty: use the defaults.
    """

    cells: tuple[Cell, ...]
    varied: tuple[str, ...]
    declared: Mapping[str, object]
    drawn: frozenset[str] = frozenset()
    plot_parameters: tuple[str, ...] = ()
    plot_measures: tuple[str, ...] = ()

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the columns of measures."""
        return KNEES_MEASURES if any("knee" in cell.kind.joints for cell in self.cells) else MEASURES

    @property
    def laws(self) -> dict[str, str]:
        """Places of the user's own controllers, with whole paths, by their names in the file."""
        return {str(cell.values["controller.name"]): cell.law for cell in self.cells if cell.law is not None}

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


def plan(path: Path, content: Mapping[str, object]) -> Study:
    """Read the study of a file's content; files that it names are looked for in the file's folder.

    The whole grid is walked for each sample, with the same drawn values everywhere in it.

    Raises:
        InputError: As `read_study`.
    """
    check_keys("key", content, KEYS)
    seed = domains.SEED.check("seed", content.get("seed", 0))
    read = list(parts_of(content))
    choices = [choice for part in read for one in part for choice in one.items()]
    draws = {name for name, values in choices if any(isinstance(value, Draw) for value in values)}
    if bool(draws) != ("samples" in content):
        words = "missing, but values are drawn" if draws else "given, but nothing is drawn"
        raise InputError(f"samples is {words} from distributions, such as {{uniform = [low, high]}}")
    samples = domains.WALKS.check("samples", content["samples"]) if draws else 1
    check_count(samples * math.prod(sum(math.prod(map(len, one.values())) for one in part) for part in read))
    parts = [[dict(zip(one, each, strict=True)) for one in part for each in product(*one.values())] for part in read]
    varied = tuple(name for part in parts for name in _varied(part))
    files = dict.fromkeys(one["terrain.file"] for one in parts[-1] if "terrain.file" in one)
    grounds: dict[object, Terrain] = {file: Terrain.from_file(path.parent / str(file)) for file in files}
    cells: list[Cell] = []
    for sample, combination in product(range(samples), product(*parts)):
        values = {
            name: value.value(generator(seed, sample, name)) if isinstance(value, Draw) else value
            for part in combination
            for name, value in part.items()
        }
        name, ground = str(values["controller.name"]), grounds.get(values.get("terrain.file"))
        law = located(name, path.parent) if is_reference(name) else None
        cells.append(Cell(len(cells), sample if draws else None, values, ground, law))
    check_cells(cells, varied)
    return Study(
        tuple(cells),
        varied,
        {key: value for key, value in content.items() if key != "plot"},
        frozenset(draws),
        *_plot(read_table(content, "plot", ("parameters", "measures")), varied),
    )


def parts_of(content: Mapping[str, Any]) -> Iterator[list[dict[str, Choice]]]:
    """Read the parts of a file that are combined with one another, each a list of alternatives; the terrain is last.

    Raises:
        InputError: A part holds no choice.
    """
    for key in OF_WALK:
        if key in content or key == "engine":
            name = f"{LIMIT}.{key}" if key in LIMITS else key
            yield [{name: read_choice(key, content.get(key, DEFAULT_ENGINE))}]
    for section in SECTIONS:
        value = content.get(section, INITIAL_STATES[0] if section == "initial" else {})
        tables = value if isinstance(value, list) else [value]
        if section == "initial" and any(isinstance(each, str) for each in tables):
            yield [{section: read_choice(section, value)}]
        elif not tables or not all(isinstance(table, Mapping) for table in tables):
            raise InputError(f"{section} must be a table [{section}], or several, [[{section}]]; got {shown(value)}")
        elif section in content or section in _USUAL:
            yield [read_section(section, table) for table in tables]


def read_section(section: str, table: Mapping[str, object]) -> dict[str, Choice]:
    """Read the choices of a table; the ends of a terrain's range are quantities of their own.

    Raises:
        InputError: Something in it is no choice.
    """
    if section in _VALID:
        check_keys(f"setting of {section}", table, _VALID[section])
    usual = {} if FILE_KEY in table and "name" not in table else _USUAL.get(section, {})
    names = {key: table[key] for key in _NAMES if key in table}
    settings: dict[str, Choice] = {}
    for key, value in {**usual, **names, **table}.items():
        place = f"{section}.{key}"
        where = shortened(place)
        if section == "terrain" and isinstance(value, Mapping) and {*value} & (_ENDS | _PLUS_MINUS):
            if {*value} not in (_ENDS, _PLUS_MINUS):
                raise InputError(f"{where}: expected {{low, high}} or {{plus_minus}}, got {shown([*value])}")
            settings |= {f"{place}.{end}": read_choice(f"{where}.{end}", each) for end, each in value.items()}
        else:
            settings[place] = read_choice(where, value)
    return settings


def read_table(content: Mapping[str, object], name: str, valid: Iterable[str] | None = None) -> Mapping[str, Any]:
    """Return a table of a file; an empty one where it is missing.

    Raises:
        InputError: It is no table, or has another key than the valid ones, where these are given.
    """
    table = content.get(name, {})
    if not isinstance(table, Mapping):
        raise InputError(f"{name} must be a table [{name}], got {shown(table)}")
    check_keys(f"key of {name}", table, table if valid is None else valid)
    return table


def check_count(count: int) -> None:
    """Refuse more walks than one study can have.

    Raises:
        InputError: There are more than `MOST_CELLS`.
    """
    if count > MOST_CELLS:
        raise InputError(
            f"these are {shown(count)} walks; a study has at most {MOST_CELLS}: take fewer values or samples"
        )


def _varied(combinations: Sequence[Mapping[str, Scalar | Draw]]) -> list[str]:
    """Names whose values differ between combinations."""
    names, first = dict.fromkeys(name for each in combinations for name in each), combinations[0]
    differ = {name for each in combinations for name in names if each.get(name) != first.get(name)}
    return [name for name in names if name in differ or isinstance(first.get(name), Draw)]


def check_cells(cells: Sequence[Cell], varied: Sequence[str]) -> None:
    """Refuse values that no walk can have; values shared by many cells are checked once.

    Raises:
        InputError: A cell has such a value.
    """
    checks: tuple[tuple[Callable[[Cell], object], set[str]], ...] = (
        (_check_walk, {"engine", LIMIT, *OPTIONS, "initial", "robot", "disturbances", "scuffing"}),
        (_check_controller, {"robot", "model", "controller"}),
        (_check_ground, {"terrain", "robot.kind"}),
    )
    seen: set[tuple[object, ...]] = set()
    for cell in cells:
        for check, sections in checks:
            mine = {name: value for name, value in cell.values.items() if {name, name.split(".")[0]} & sections}
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


def _check_ground(cell: Cell) -> None:
    """Refuse a terrain that there is not, or on which the robot cannot walk."""
    check_ground(cell.robot(), cell.terrain())


def _check_walk(cell: Cell) -> None:
    """Refuse engine, limits, initial state, scuffing rule or disturbances that no walk of the robot can have."""
    engine = cell.engine()
    cell.initial(lambda: [0.0] * 2 * len(cell.kind.angles))
    limits = cell.section(LIMIT)
    terms = Terms(engine, limits.get("steps"), limits.get("distance"), cell.robot(), None, cell.scuffing())
    make_plan(terms, Unpowered(), Terrain.level(), "rest", disturbances=cell.disturbances())


def _plot(table: Mapping[str, object], varied: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read the parameters and measures of the figures.

    Raises:
        InputError: The table holds anything else.
    """
    found = []
    for key, valid, most in (("parameters", varied, 3), ("measures", (*KNEES_MEASURES, FINISHED), 6)):
        names = table.get(key, [])
        if not isinstance(names, list) or len(names) > most:
            raise InputError(f"plot.{key} must be a list of up to {most} names, got {shown(names)}")
        found.append(tuple(known_name(f"name in plot.{key}", name, valid) for name in names))
    return found[0], found[1]
