"""A robustness study's file, and the walks that it asks for; docs/robustness.md describes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mjbiped.control.loading import is_reference, located
from mjbiped.errors import InputError, shortened, shown
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Disturbance, Margin
from mjbiped.robustness.walks import BASIN, Plan, walks_of
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import Cell
from mjbiped.sweeps.plan import Study, check_cells, check_count
from mjbiped.sweeps.sections import SCUFFING, kinds_of, read_controller, read_robot
from mjbiped.sweeps.values import Scalar, check_keys
from mjbiped.terrain.files import parse_toml
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain
from mjbiped.utils.reading import read_text

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing", "robot")
LIMIT_KEYS = ("share", "phases", "steps_after", "torque", BASIN, *DISTURBANCES)
MARGIN_KEYS = ("share", "ground", "steps", *MARGINS)
VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""

_SHARE = Domain(0.5, 1.0)
BASIN_RATES = 20
"""Rates of either leg, unless a study says otherwise."""

MARGIN_GROUND = "treads:deviation=0.01"
"""Rough ground on which all controllers last, for disturbances of whole walks."""


def read_plan(path: Path) -> Plan:
    """Read a robustness study's file, and check all that can be checked without walking.

    Raises:
        InputError: It cannot be read, or says anything that no study can have; the message names the place.
    """
    try:
        return plan(path, parse_toml(read_text(path)))
    except InputError as error:
        raise InputError(f"robustness study {shortened(str(path))}: {error}") from error


def plan(path: Path, content: Mapping[str, Any]) -> Plan:
    """The plan of a file's content.

    Raises:
        InputError: As `read_plan`.
    """
    check_keys("key", content, KEYS)
    limits = _table("limits", content, LIMIT_KEYS)
    margins = _table("margins", content, MARGIN_KEYS)
    engines = _texts("engine", content.get("engine", "hybrid"))
    given = content.get("grounds", ["treads:deviation=0.03"])
    grounds = () if given == [] else _texts("grounds", given)
    chosen = _magnitudes("limits", limits, DISTURBANCES)
    lasting = _magnitudes("margins", margins, MARGINS) if "margins" in content else {}
    rule = ScuffingRule(**_table("scuffing", content, SCUFFING))
    labelled, laws = _controllers(content.get("controller", [{}]), content.get("robot", {}), path.parent)
    if "scuffing" in content and all(Cell(0, None, settings).knees for settings in labelled.values()):
        raise InputError("scuffing is for straight legs: with knees the swing foot collides from lift-off on")
    torque = limits.get("torque")
    wanted = Plan(
        Study(path, (), VARIED, False, frozenset(), dict(content), laws=laws),
        tuple(labelled),
        engines,
        grounds,
        domains.WALKS.check("seeds", content.get("seeds", 20)),
        domains.STEPS.check("steps", content.get("steps", 1000)),
        tuple(chosen),
        _SHARE.check("limits.share", limits.get("share", 0.99)),
        domains.WALKS.check("limits.phases", limits.get("phases", 24)),
        domains.STEPS.check("limits.steps_after", limits.get("steps_after", 20)),
        None if torque is None else domains.TORQUE_LIMIT.check("limits.torque", torque),
        _basin(limits, named=bool({*limits} & {*DISTURBANCES})),
        tuple(lasting),
        margins.get("ground", MARGIN_GROUND),
        domains.STEPS.check("margins.steps", margins.get("steps", 200)),
        _SHARE.check("margins.share", margins.get("share", 0.95)),
        rule,
    )
    each = 1 + wanted.phases * sum(map(len, chosen.values())) + wanted.basin**2
    each += wanted.seeds * (len(grounds) + sum(map(len, lasting.values())))
    check_count(len(engines) * len(labelled) * each)
    cells = list(walks_of(wanted, labelled, chosen, lasting, laws))
    check_cells(cells, VARIED)
    return replace(wanted, study=replace(wanted.study, cells=tuple(cells)))


def _texts(key: str, value: object) -> tuple[str, ...]:
    parts = value if isinstance(value, list) else [value]
    if not parts or not all(isinstance(part, str) for part in parts) or len({*map(str, parts)}) != len(parts):
        raise InputError(f"{key} must be a text or a list of different texts, got {shown(value)}")
    return tuple(map(str, parts))


def _table(key: str, content: Mapping[str, Any], valid: Sequence[str]) -> Mapping[str, Any]:
    table = content.get(key, {})
    if not isinstance(table, Mapping):
        raise InputError(f"{key} must be a table [{key}], got {shown(table)}")
    check_keys(f"key of {key}", table, valid)
    return table


def _magnitudes(
    key: str, table: Mapping[str, Any], kinds: Mapping[str, Disturbance] | Mapping[str, Margin]
) -> dict[str, tuple[float, ...]]:
    """Those of each disturbance that is tried; all kinds, unless the file names some."""
    named = {name: table[name] for name in kinds if name in table}
    found = {}
    for name, given in named.items():
        where = f"{key}.{name}"
        if given is False:
            continue
        if given is True:
            found[name] = kinds[name].magnitudes
            continue
        if not isinstance(given, list) or not given:
            raise InputError(f"{where} must be a list of magnitudes ({kinds[name].unit}), true or false")
        found[name] = tuple(
            domains.STUDY_POSITIVE.check(f"{where}, value {k}", each) for k, each in enumerate(given, start=1)
        )
        falling = kinds[name].magnitudes[0] > kinds[name].magnitudes[-1]
        if list(found[name]) != sorted(set(found[name]), reverse=falling):
            order = "descend" if falling else "ascend"
            raise InputError(f"{where}: magnitudes must {order}, the gentlest first; got {shown(given)}")
    return found if named else {name: each.magnitudes for name, each in kinds.items()}


def _basin(limits: Mapping[str, Any], named: bool) -> int:
    """Number of first rates of either leg; the usual one, unless the file names other disturbances alone."""
    given = limits.get(BASIN, not named)
    if isinstance(given, bool):
        return BASIN_RATES if given else 0
    return domains.GRID.check(f"limits.{BASIN}", given)


def _controllers(tables: object, usual: object, folder: Path) -> tuple[dict[str, dict[str, Scalar]], dict[str, str]]:
    """Settings of controllers and their robots by label, and where the user's own controllers are."""
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"controller must be tables [[controller]], got {shown(tables)}")
    labelled: dict[str, dict[str, Scalar]] = {}
    laws: dict[str, str] = {}
    for number, table in enumerate(tables, start=1):
        given = table.get("robot", usual)
        if not isinstance(given, Mapping):
            raise InputError(f'robot must be a table, as {{ kind = "kneed" }}, got {shown(given)}')
        robot = read_robot(given)
        law = {key: value for key, value in table.items() if key not in ("label", "robot", "motor")}
        settings: dict[str, Scalar] = {}
        for name, choice in {**robot, **read_controller(law, folder, kinds_of([robot]))}.items():
            if not isinstance(choice, tuple) or len(choice) != 1:
                raise InputError(f"controller {number}: {name} must be one value; give each variant a [[controller]]")
            settings[name] = choice[0]
        if "motor" in table:
            greatest = domains.TORQUE_LIMIT.check(f"controller {number}: motor", table["motor"])
            settings["disturbances.torque_limit"] = greatest
        name = str(settings["controller.name"])
        label = table.get("label", name)
        if not isinstance(label, str) or label in labelled:
            raise InputError(f"controller {number}: label = {shown(label)}: must be a text of its own")
        if is_reference(name):
            laws[name] = located(name, folder)
        labelled[label] = settings
    return labelled, laws
