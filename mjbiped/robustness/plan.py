"""A robustness study's file, and the walks that it asks for; docs/robustness.md describes it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mjbiped.control.own import is_reference, located
from mjbiped.errors import InputError, shortened, shown
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Disturbance, Margin
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.cell import Cell
from mjbiped.sweeps.plan import Study, check_cells, check_count
from mjbiped.sweeps.sections import read_controller
from mjbiped.sweeps.values import Scalar, check_keys
from mjbiped.terrain.families import START
from mjbiped.terrain.files import parse_parameters, parse_toml, read_text
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, known_name

KEYS = ("engine", "steps", "seeds", "grounds", "controller", "limits", "margins", "scuffing")
LIMIT_KEYS = ("share", "phases", "steps_after", "torque", *DISTURBANCES)
MARGIN_KEYS = ("share", "ground", "steps", *MARGINS)
VARIED = ("engine", "test", "controller", "ground", "magnitude", "case")
"""Columns that say what a row is of."""

LEVEL, SURVIVAL = "level", "survival"
"""Tests beside `DISTURBANCES`: steady walking on level ground, and random ground until the robot falls."""

LEVEL_STEPS = 40
_BEFORE = 3  # steps before a disturbance comes
_SHARE = Domain(0.5, 1.0)
MARGIN_GROUND = "treads:deviation=0.01"
"""Rough ground on which all controllers last, for disturbances of whole walks."""

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
        torque: Greatest torque of either joint with which it counts as survived, N m; None: any.
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
    torque: float | None
    margins: tuple[str, ...]
    margin_ground: str
    margin_steps: int
    margin_share: float
    scuffing: ScuffingRule


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
    grounds = _texts("grounds", content.get("grounds", ["treads:deviation=0.03"]))
    chosen = _magnitudes("limits", limits, DISTURBANCES)
    lasting = _magnitudes("margins", margins, MARGINS) if "margins" in content else {}
    rule = ScuffingRule(**_table("scuffing", content, ("reach", "delay")))
    labelled, laws = _controllers(content.get("controller", [{}]), path.parent)
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
        None if torque is None else domains.TORQUE_LIMIT.check("limits.torque", torque),
        tuple(lasting),
        margins.get("ground", MARGIN_GROUND),
        domains.STEPS.check("margins.steps", margins.get("steps", 200)),
        _SHARE.check("margins.share", margins.get("share", 0.95)),
        rule,
    )
    each = 1 + wanted.phases * sum(map(len, chosen.values()))
    each += wanted.seeds * (len(grounds) + sum(map(len, lasting.values())))
    check_count(len(engines) * len(labelled) * each)
    after = domains.STEPS.check("limits.steps_after", limits.get("steps_after", 20))
    cells = list(_cells(wanted, labelled, chosen, lasting, after, laws))
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


def _controllers(tables: object, folder: Path) -> tuple[dict[str, dict[str, Scalar]], dict[str, str]]:
    """Settings by label, and where the user's own controllers are."""
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"controller must be tables [[controller]], got {shown(tables)}")
    labelled: dict[str, dict[str, Scalar]] = {}
    laws: dict[str, str] = {}
    for number, table in enumerate(tables, start=1):
        settings: dict[str, Scalar] = {}
        for name, choice in read_controller({k: v for k, v in table.items() if k != "label"}, folder).items():
            if not isinstance(choice, tuple) or len(choice) != 1:
                raise InputError(f"controller {number}: {name} must be one value; give each variant a [[controller]]")
            settings[name] = choice[0]
        name = str(settings["controller.name"])
        label = table.get("label", name)
        if not isinstance(label, str) or label in labelled:
            raise InputError(f"controller {number}: label = {shown(label)}: must be a text of its own")
        if is_reference(name):
            laws[name] = located(name, folder)
        labelled[label] = settings
    return labelled, laws


def _cells(
    wanted: Plan,
    labelled: Mapping[str, Mapping[str, Scalar]],
    chosen: Mapping[str, Sequence[float]],
    lasting: Mapping[str, Sequence[float]],
    after: int,
    laws: Mapping[str, str],
) -> Iterator[Cell]:
    """All walks, the short ones first."""
    count = itertools.count()
    rule = {"scuffing.reach": wanted.scuffing.reach, "scuffing.delay": wanted.scuffing.delay}
    grounds = {words: _ground(words, wanted.steps) for words in wanted.grounds}

    def cell(engine: str, test: str, label: str, steps: int, told: Mapping[str, Scalar], **columns: Scalar) -> Cell:
        settings = labelled[label]
        values = {
            "engine": engine,
            "test": test,
            "controller": label,
            **columns,
            "steps": steps,
            "initial": "gait",
            **rule,
            **settings,
            **told,
        }
        return Cell(next(count), None, values, None, laws.get(str(settings["controller.name"])))

    for engine in wanted.engines:
        for label in wanted.controllers:
            yield cell(engine, LEVEL, label, LEVEL_STEPS, {"terrain.name": "level"})
        for label in wanted.controllers:
            length = _step_length(labelled[label], laws)
            for test, magnitudes in chosen.items():
                for magnitude, phase in itertools.product(magnitudes, range(wanted.phases)):
                    place = (_BEFORE + (phase + 0.5) / wanted.phases) * length
                    told = DISTURBANCES[test].values(magnitude, place)
                    yield cell(engine, test, label, _BEFORE + 1 + after, told, magnitude=magnitude, case=phase)
        rough = _ground(wanted.margin_ground, wanted.margin_steps)
        for label, (test, magnitudes) in itertools.product(wanted.controllers, lasting.items()):
            for magnitude, seed in itertools.product(magnitudes, range(wanted.seeds)):
                told = {**rough, "terrain.seed": seed, **MARGINS[test].values(magnitude)}
                if any(name.startswith("disturbances.") for name in told):
                    told["disturbances.seed"] = seed
                steps = wanted.margin_steps
                yield cell(
                    engine, test, label, steps, told, ground=wanted.margin_ground, magnitude=magnitude, case=seed
                )
        for words, seed, label in itertools.product(wanted.grounds, range(wanted.seeds), wanted.controllers):
            told = {**grounds[words], "terrain.seed": seed}
            yield cell(engine, SURVIVAL, label, wanted.steps, told, ground=words, case=seed)


def _ground(words: object, steps: int) -> dict[str, Scalar]:
    """A random ground of the command line's words, as a cell takes it."""
    if not isinstance(words, str):
        raise InputError(f"a random ground is a text, as 'treads:deviation=0.03', got {shown(words)}")
    name, _, rest = words.partition(":")
    parameters = parse_parameters(rest) if rest else {}
    known_name("random ground", name, RANDOM)
    for key, reason in (("seed", "the study draws the seeds itself"), ("length", "it follows from the steps")):
        if key in parameters:
            raise InputError(f"ground {shown(words)}: leave {key} out, {reason}")
    parameters["length"] = START + steps * LONGEST_STEP
    Terrain.preset(name, **{**parameters, "seed": 0})
    return {
        "terrain.name": name,
        **{
            f"terrain.{key}": "..".join(map(str, value)) if isinstance(value, tuple) else value
            for key, value in parameters.items()
        },
    }


def _step_length(settings: Mapping[str, Scalar], laws: Mapping[str, str]) -> float:
    """Of a controller on level ground, m: that of the gait that it imitates."""
    cell = Cell(0, None, settings, None, laws.get(str(settings["controller.name"])))
    gait = cell.controller().gait
    return float(gait.step_length) if gait is not None else _FALLBACK * cell.robot().leg_length
