"""The reader of a robustness study's file; docs/robustness.md describes the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mjbiped.control.loading import is_reference, located
from mjbiped.errors import InputError, prefixed, shortened, shown
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Disturbance
from mjbiped.robustness.walks import BASIN, Plan, Trial, walks_of
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import Cell
from mjbiped.sweeps.plan import Study, check_cells, check_count
from mjbiped.sweeps.sections import SCUFFING, kinds_of, read_controller, read_robot
from mjbiped.sweeps.values import Scalar, check_keys
from mjbiped.terrain.files import parse_toml
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain
from mjbiped.utils.reading import read_text

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing", "robot")
VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""

_SHARE = Domain(0.5, 1.0)
BASIN_RATES = 20
"""Number of first rates of either leg, unless a study says otherwise."""

MARGIN_GROUND = "treads:deviation=0.01"
"""Rough ground on which all controllers last, for disturbances of whole walks."""


class _Table:
    """A table of the file, all of whose keys are valid."""

    def __init__(self, name: str, content: Mapping[str, Any], valid: Sequence[str]) -> None:
        """Take the table with a name; an empty name stands for the whole content.

        Raises:
            InputError: The content has no such table, or the table has an unknown key.
        """
        table = content.get(name, {}) if name else content
        if not isinstance(table, Mapping):
            raise InputError(f"{name} must be a table [{name}], got {shown(table)}")
        check_keys(f"key of {name}" if name else "key", table, valid)
        self.values: Mapping[str, Any] = table
        self._where = f"{name}." if name else ""

    def number(self, key: str, domain: Domain | Count, usual: float) -> Any:
        """Read a number of the table, and check its domain."""
        return domain.check(f"{self._where}{key}", self.values.get(key, usual))

    def magnitudes(self, kinds: Mapping[str, Disturbance]) -> dict[str, tuple[float, ...]]:
        """Read the magnitudes of each disturbance that is tried; all disturbances, unless the file names some."""
        named = {name: self.values[name] for name in kinds if name in self.values}
        if not named:
            return {name: kind.magnitudes for name, kind in kinds.items()}
        found = {}
        for name, given in named.items():
            where, kind = f"{self._where}{name}", kinds[name]
            if given is True:
                found[name] = kind.magnitudes
            elif given is not False:
                if not isinstance(given, list) or not given:
                    raise InputError(f"{where} must be a list of magnitudes ({kind.unit}), true or false")
                found[name] = tuple(
                    domains.STUDY_POSITIVE.check(f"{where}, value {k}", each) for k, each in enumerate(given, start=1)
                )
                if list(found[name]) != sorted(set(found[name]), reverse=kind.falls):
                    order = "descend" if kind.falls else "ascend"
                    raise InputError(f"{where}: magnitudes must {order}, the gentlest first; got {shown(given)}")
        return found


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
    whole = _Table("", content, KEYS)
    limits = _Table("limits", content, ("share", "phases", "steps_after", "torque", BASIN, *DISTURBANCES))
    margins = _Table("margins", content, ("share", "ground", "steps", *MARGINS))
    engines = _texts("engine", content.get("engine", "hybrid"))
    given = content.get("grounds", ["treads:deviation=0.03"])
    rule = ScuffingRule(**_Table("scuffing", content, SCUFFING).values)
    controllers, laws = _controllers(content.get("controller", [{}]), content.get("robot", {}), path.parent)
    kinds = [Cell(0, None, settings).kind for settings in controllers.values()]
    if "scuffing" in content and all(kind.collides_from_lift_off for kind in kinds):
        raise InputError("scuffing is for straight legs: with knees the swing foot collides from lift-off on")
    wanted = Plan(
        study=Study(path, (), VARIED, frozenset(), frozenset(), dict(content), laws=laws),
        controllers=controllers,
        engines=engines,
        grounds=() if given == [] else _texts("grounds", given),
        seeds=whole.number("seeds", domains.WALKS, 20),
        steps=whole.number("steps", domains.STEPS, 1000),
        limits=Trial(
            limits.magnitudes(DISTURBANCES),
            limits.number("steps_after", domains.STEPS, 20),
            limits.number("share", _SHARE, 0.99),
            limits.number("torque", domains.TORQUE_LIMIT, 0.0) if limits.values.get("torque") is not None else None,
        ),
        phases=limits.number("phases", domains.WALKS, 24),
        basin=_basin(limits),
        margins=Trial(
            margins.magnitudes(MARGINS) if "margins" in content else {},
            margins.number("steps", domains.STEPS, 200),
            margins.number("share", _SHARE, 0.95),
        ),
        margin_ground=margins.values.get("ground", MARGIN_GROUND),
        scuffing=rule,
    )
    check_count(wanted.count)
    cells = tuple(walks_of(wanted))
    check_cells(cells, VARIED)
    return replace(wanted, study=replace(wanted.study, cells=cells))


def _texts(key: str, value: object) -> tuple[str, ...]:
    parts = value if isinstance(value, list) else [value]
    if not parts or not all(isinstance(part, str) for part in parts) or len({*map(str, parts)}) != len(parts):
        raise InputError(f"{key} must be a text or a list of different texts, got {shown(value)}")
    return tuple(map(str, parts))


def _basin(limits: _Table) -> int:
    """Read the number of first rates of either leg; `BASIN_RATES`, unless the file names disturbances but no basin."""
    given = limits.values.get(BASIN, not any(name in limits.values for name in DISTURBANCES))
    if isinstance(given, bool):
        return BASIN_RATES if given else 0
    return domains.GRID.check(f"limits.{BASIN}", given)


def _controllers(tables: object, usual: object, folder: Path) -> tuple[dict[str, dict[str, Scalar]], dict[str, str]]:
    """Read settings of controllers and their robots by label, and the places of the user's own controllers."""
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"controller must be tables [[controller]], got {shown(tables)}")
    labelled: dict[str, dict[str, Scalar]] = {}
    laws: dict[str, str] = {}
    for number, table in enumerate(tables, start=1):
        given = table.get("robot", usual)
        if not isinstance(given, Mapping):
            raise InputError(f'robot must be a table, as {{ kind = "kneed" }}, got {shown(given)}')
        robot = read_robot(given)
        law = {key: value for key, value in table.items() if key not in ("label", "robot", "torque_limit")}
        settings: dict[str, Scalar] = {}
        for name, choice in {**robot, **read_controller(law, folder, kinds_of([robot]))}.items():
            if not isinstance(choice, tuple) or len(choice) != 1:
                raise InputError(f"controller {number}: {name} must be one value; give each variant a [[controller]]")
            settings[name] = choice[0]
        if "torque_limit" in table:
            greatest = domains.TORQUE_LIMIT.check(f"controller {number}: torque_limit", table["torque_limit"])
            settings["disturbances.torque_limit"] = greatest
        name = str(settings["controller.name"])
        label = table.get("label", name)
        if not isinstance(label, str) or label in labelled:
            raise InputError(f"controller {number}: label = {shown(label)}: must be a text of its own")
        if is_reference(name):
            laws[name] = located(name, folder)
        labelled[label] = settings
    return labelled, laws
