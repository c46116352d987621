"""A robustness study's file; docs/studies.md describes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, TypeVar

from mjbiped.control.loading import is_reference, located
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.studies.cell import Cell, check_keys
from mjbiped.studies.plan import SCUFFING, Study, check_cells, check_count, read_section, read_table
from mjbiped.studies.robustness_walks import BASIN, BASIN_RATES, DISTURBANCES, MARGINS, Disturbance, walks_of
from mjbiped.terrain.files import parse_toml
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, check_fields
from mjbiped.utils.draws import Draw, Scalar, read_choice
from mjbiped.utils.files import read_text

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing", "robot")

VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""

_SHARE = Domain(0.5, 1.0)


class _Checked:
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

    magnitudes: Mapping[str, Sequence[float]]
    basin: int = 0
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

    magnitudes: Mapping[str, Sequence[float]]
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

    declared: Mapping[str, object]
    folder: Path
    controllers: Mapping[str, Cell]
    engines: Sequence[str]
    grounds: Sequence[str]
    seeds: Annotated[int, domains.WALKS]
    steps: Annotated[int, domains.STEPS]
    limits: Limits
    margins: Margins
    scuffing: ScuffingRule

    @cached_property
    def study(self) -> Study:
        """Its walks; an `InputError` says that the words of a random ground are not valid."""
        return Study(tuple(walks_of(self)), VARIED, self.declared)


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
    single_count, lasting = (sum(map(len, tried.magnitudes.values())) for tried in (wanted.limits, wanted.margins))
    each = 1 + wanted.limits.phases * single_count + wanted.limits.basin**2
    each += wanted.seeds * (len(wanted.grounds) + lasting)
    check_count(len(wanted.engines) * len(controllers) * each)
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
        tables: Tables of the controllers, whose files are looked for in the folder.
        usual: Table of the robot of those that do not name their own.
        folder: The file's folder.

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
