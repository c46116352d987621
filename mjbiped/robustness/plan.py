"""The reader of a robustness study's file; docs/robustness.md describes the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from mjbiped.control.loading import is_reference, located
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Disturbance
from mjbiped.robustness.walks import BASIN, AnyTried, Limits, Margins, Plan
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import Cell, Scalar, check_keys
from mjbiped.sweeps.plan import check_cells, check_count
from mjbiped.sweeps.sections import SCUFFING, read_choice, read_section, read_table
from mjbiped.terrain.files import parse_toml
from mjbiped.utils import domains
from mjbiped.utils.draws import Draw
from mjbiped.utils.files import read_text

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing", "robot")
BASIN_RATES = 20
"""Number of first rates of either leg, unless a study says otherwise."""


def read_plan(path: Path) -> Plan:
    """Read a robustness study's file, and check all that can be checked without walking.

    Raises:
        InputError: It cannot be read, or says anything that no study can have; the message names the place.
    """
    with prefixed(f"robustness study {shortened(str(path))}: "):
        return plan(path, parse_toml(read_text(path)))


def plan(path: Path, content: Mapping[str, Any]) -> Plan:
    """Read the plan of a file's content.

    Raises:
        InputError: As `read_plan`.
    """
    check_keys("key", content, KEYS)
    controllers = _controllers(content.get("controller", [{}]), content.get("robot", {}), path.parent)
    if "scuffing" in content and all(each.kind.collides_from_lift_off for each in controllers.values()):
        raise InputError("scuffing is for straight legs: with knees the swing foot collides from lift-off on")
    limits, grounds = read_table(content, "limits"), content.get("grounds", ["treads:deviation=0.03"])
    wanted = Plan(
        declared=dict(content),
        folder=path.parent,
        controllers=controllers,
        engines=tuple(map(str, read_choice("engine", content.get("engine") or "hybrid"))),
        grounds=tuple(map(str, read_choice("grounds", grounds))) if grounds != [] else (),
        seeds=content.get("seeds", 20),
        steps=content.get("steps", 1000),
        limits=_tried(Limits, content, "limits", DISTURBANCES, basin=_basin(limits)),
        margins=_tried(Margins, content, "margins", MARGINS if "margins" in content else {}),
        scuffing=ScuffingRule(**read_table(content, "scuffing", SCUFFING)),
    )
    check_count(wanted.count)
    check_cells(wanted.study.cells, wanted.study.varied)
    return wanted


def _tried(
    kind: type[AnyTried], content: Mapping[str, object], name: str, disturbances: Mapping[str, Disturbance], **more: int
) -> AnyTried:
    """Read a table of disturbances: their magnitudes, and how they are tried.

    Unless the table names some, all disturbances are tried.

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
