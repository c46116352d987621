"""Controllers by their names on the command line and in study files: registered ones, and a user's own.

This module knows no control law. A package registers its controllers as entry points of the group `GROUP`, as this
project does in its own pyproject.toml. A controller is imported when a caller asks for its name:

```toml
[project.entry-points."mjbiped.controllers"]
spread = "my_package.spread:HipSpread"
```

A class that is not registered is named by its place, as `mjbiped.control.loading` says. Such a class is a frozen
dataclass, and its fields are the settings of the controller. Three names are special: a field `robot` gets the robot's
model, `gait` the passive gait that is imitated, and `SLOPE_FIELD` the slope estimate at the start.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any

from mjbiped.control import loading
from mjbiped.control.controller import Controller
from mjbiped.control.tracking import check_tracking
from mjbiped.errors import InputError, MjbipedError, explained, place_of, prefixed, shown
from mjbiped.gaits.described import gait_from, passive_gait_of, reference_of, usual_gait
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.optimised import only_kept
from mjbiped.gaits.steps import Goal
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.robot import Robot
from mjbiped.utils.domains import SLOPE_DEG, known_name, nearest

GROUP = "mjbiped.controllers"
"""The group of entry points."""

DEFAULT_CONTROLLER = "adaptive"

SHARED: Mapping[str, Any] = MappingProxyType(
    {"imitate_slope_deg": 2.0, "initial_slope_estimate_deg": 0.0, "reference": None}
)
"""Settings of all controllers that imitate a gait, with their defaults: the slope of that passive gait, and the slope
estimate at the start, degrees; and an optimised reference in the passive gait's stead, as "clearance=0.06" (see
`parse_reference`)."""

SLOPE_FIELD = "initial_slope_estimate"
"""Name of a field that takes the slope estimate at the start, rad."""

_FILLED_IN = ("robot", "gait", "climbing_gait", SLOPE_FIELD)
"""Fields that are no settings: others say what stands in them."""


@cache
def registered() -> Mapping[str, EntryPoint]:
    """Return the registered controllers by name, the default first; none is imported yet.

    Raises:
        InputError: Two packages register different controllers by one name.
    """
    found: dict[str, EntryPoint] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name != DEFAULT_CONTROLLER, entry.name)):
        if found.setdefault(entry.name, entry).value != entry.value:
            raise InputError(
                f"two installed packages register the controller {entry.name}: {found[entry.name].value} and "
                f"{entry.value}; give one of them another name"
            )
    return MappingProxyType(found)


def controller_names() -> tuple[str, ...]:
    """Return the names of all registered controllers, the default first."""
    return tuple(registered())


def controller_class(name: str, robot: Robot | None = None) -> type[Controller]:
    """Return the class of a controller's name.

    Args:
        name: Name of a registered controller, or reference to a user's class; see `mjbiped.control.loading`.
        robot: The robot to be driven; a law may have classes of its own for robots with other joints.

    Raises:
        InputError: The name is unknown, or the class cannot be imported.
    """
    name, file = loading.file_of(name)
    if loading.is_reference(name):
        return loading.own_class(name)
    try:
        entry = registered()[known_name("controller", name, registered())]
    except InputError as error:
        raise InputError(f"{error}; a class of your own is named {loading.FORMS}") from None
    try:
        kind: type[Controller] = entry.load()
        if file and kind.with_file is None:
            raise InputError(f"no file describes the controller {name}: give its name alone, or policy:{file}")
        if file and kind.with_file:
            kind = resolve_name(kind.with_file)
        elif robot is not None and (variant := _variant(kind, robot)):
            kind = resolve_name(variant)
    except (ImportError, AttributeError) as error:
        raise InputError(f"the controller {name}, registered as {entry.value}, fails: {shown(error)}") from error
    return kind


def _variant(kind: type[Controller], robot: Robot) -> str | None:
    """Place of a law's class for a robot with other joints than a compass biped; None if the law has none."""
    return next((place for joint, place in kind.for_joints.items() if joint in robot.joints), None)


def driver_of(controller: Controller, robot: Robot) -> Controller:
    """Return the controller that drives a robot on behalf of a given one; see `Controller.driving`.

    Raises:
        InputError: It does not drive such a robot.
    """
    driver = controller.driving(robot)
    if driver.joints != robot.joints:
        raise _mismatch(type(controller), robot)
    return driver


def _mismatch(kind: type[Controller], robot: Robot) -> InputError:
    """Say that a law does not drive a robot, and which registered controllers do."""
    kinds = {name: controller_class(name, robot) for name in registered()}
    drivers = ", ".join(f"{name} ({each.__name__})" for name, each in kinds.items() if each.drives(robot))
    own = kind not in {*kinds.values(), *map(controller_class, registered())}
    line = f"if its torques are those of that robot's joints, write joints = {robot.joints!r} into the class; or "
    return InputError(
        f"{kind.__name__} drives {', '.join(kind.joints)}; {type(robot).__name__} has {', '.join(robot.joints)}: "
        f"{line if own else ''}choose a controller for that robot: {drivers}"
    )


def settings_of(name: str, robot: Robot | None = None) -> dict[str, Any]:
    """Return a controller's settings with their defaults; `REQUIRED` for those that have none.

    Raises:
        InputError: As `controller_class`.
    """
    own = loading.fields_of(controller_class(name, robot))
    shared = SHARED if "gait" in own else {}
    described = {"file": file} if (file := loading.file_of(name)[1]) else {}
    return {**shared, **{key: own[key] for key in own if key not in _FILLED_IN}, **described}


def make_controller(name: str, robot: Robot, settings: Mapping[str, object], gait: Gait | None = None) -> Controller:
    """Make a controller by its name.

    Args:
        name: Name or reference, as for `controller_class`.
        robot: The robot model of the law.
        settings: Values by the names of `settings_of`; what is left out has its default.
        gait: What is imitated; unless given, it is found by `imitate_slope_deg`, or by `reference`. Where
            neither is given, it is the `usual_gait`.

    Returns:
        An object of `controller_class(name)`.

    Raises:
        InputError: A name is unknown, or a value is missing or outside its domain.
        GaitError: The slope to be imitated has no passive gait.
    """
    valid = settings_of(name, robot)
    kind = controller_class(name, robot)
    own, known = loading.fields_of(kind), loading.shown_defaults(valid) or "none"
    if not is_dataclass(kind):
        known += (
            f"; {kind.__name__} is no dataclass: write @dataclass(frozen=True) above the class, and its parameters as "
            "fields, stiffness: float = 20.0 for instance (robot: mjbiped.Compass and gait: mjbiped.Gait are filled in)"
        )
    for key in settings.keys() - valid.keys():
        raise InputError(
            f"unknown setting of the controller {name} {shown(key)}: valid are {known}{nearest(key, valid)}"
        )
    given = {key: loading.checked(kind, key, value) if key in own else value for key, value in settings.items()}
    values = valid | given
    if "robot" in own:
        values["robot"] = robot
    if "gait" in own:
        if not kind.drives(robot):
            raise _mismatch(kind, robot)
        slope, estimate = (
            math.radians(SLOPE_DEG.check(key, values.pop(key)))
            for key in ("imitate_slope_deg", "initial_slope_estimate_deg")
        )
        reference = values.pop("reference")
        if reference is not None:
            check_tracking(kind)  # before the search for it
        values["gait"] = gait or _imitated(robot, slope, reference, passive="imitate_slope_deg" in settings)
        if SLOPE_FIELD in own:
            values[SLOPE_FIELD] = estimate
    try:
        return kind(**{key: value for key, value in values.items() if value is not loading.REQUIRED})
    except MjbipedError:
        raise
    except Exception as error:  # a value is missing, or a class of the user's does something with them
        raise InputError(
            f"{kind.__name__} cannot be made of these settings: {explained(error)}{place_of(error, kind)}; they are "
            f"{known} (on the command line --gain NAME=VALUE, in a study keys of its [controller])"
        ) from error


def _imitated(robot: Any, slope: float, reference: object, *, passive: bool) -> Gait:
    """The gait that a controller imitates.

    Args:
        robot: Robot of the gait.
        slope: Slope of the passive gait, rad.
        reference: Text that describes an optimised gait; None if there is none.
        passive: Whether the passive gait was requested by its slope.

    Raises:
        InputError: The text describes no reference, or a passive gait was requested as well.
        GaitError: The slope has no passive gait.
    """
    if reference is None:
        return passive_gait_of(robot, slope) if passive else usual_gait(robot, slope)
    if passive:
        raise InputError("imitate_slope_deg is of a passive gait, and reference of an optimised one; give one of them")
    return reference_of(robot, **parse_reference(reference))


def parse_reference(text: object) -> dict[str, Any]:
    """Read the arguments of `find_reference` from a text such as "clearance=0.06,retraction=no".

    Raises:
        InputError: It is no text, a name is unknown or stands twice, or a value cannot be read.
    """
    found: dict[str, Any] = {}
    if not isinstance(text, str):
        raise InputError(f"reference = {shown(text)}: must be text, as 'clearance=0.06', or None")
    with prefixed(f"reference {shown(text)}: "):
        for part in text.split(","):
            name, _, value = (each.strip() for each in part.partition("="))
            known_name("part of a reference", name, loading.fields_of(Goal))
            if name in found:
                raise InputError(f"{name} stands twice")
            found[name] = loading.value_of(Goal, name, {"yes": "true", "no": "false"}.get(value, value))
    return found


def controller_from(
    description: Mapping[str, Any], source: Mapping[str, str] | None = None, named: str | None = None
) -> Controller:
    """Rebuild the controller that a record describes; see `Controller.describe`.

    A field that the class has got since then has its default, with which the class does what it did before. A record
    may come from anyone: it never decides which code is loaded, nor does it begin a search for a reference.

    Args:
        description: Description of the controller.
        source: Reference and digest of a user's own class in the record; see `mjbiped.control.loading.source_of`.
        named: Reference to that class, given by the caller; it is loaded if its digest is the one in the record.

    Raises:
        InputError: No registered class has the description's name, or the class has other parameters or has changed,
            or it is the user's own and not named.
        GaitError: The gait that it imitated is not found.
    """
    described = dict(description)
    wanted = described.pop("name", None)
    try:
        robot = robot_from(described["robot"]) if "robot" in described else None
        kind = _described_class(wanted, robot, source, named)
        # only a gait's description tells whose it is
        gaits = [key for key, value in described.items() if isinstance(value, Mapping) and "robot" in value]
        described |= {key: gait_from(described[key]) for key in gaits}
        if robot is not None:
            described["robot"] = robot
        with only_kept():
            return kind(**described)
    except MjbipedError:
        raise
    except Exception as error:  # of whatever kind, by what a class of the user's does with it
        raise InputError(f"the record's {shown(wanted)} cannot be built anew: {explained(error)}") from error


def _described_class(
    wanted: object, robot: Robot | None, source: Mapping[str, str] | None, named: str | None
) -> type[Controller]:
    """The class of a record's controller; see `controller_from`."""
    if source is not None:
        return loading.recorded_class(source, named)
    if named is not None:
        raise InputError(f"the record's controller is the registered {shown(wanted)}, and no class of yours is needed")
    classes = {entry.value.rpartition(":")[2]: name for name, entry in registered().items()}
    if robot is not None:
        own = {controller_class(name, robot).__name__: name for name in registered()}
        classes = own if wanted in own else classes
    if wanted in classes:
        return controller_class(classes[wanted], robot)
    for kind in map(controller_class, registered()):
        if kind.with_file and kind.with_file.endswith(f":{wanted}"):
            found: type[Controller] = resolve_name(kind.with_file)
            return found
    raise InputError(
        f"the record's controller is a {shown(wanted)}, and only registered ones are built anew: "
        f"{', '.join(sorted(classes))}, or those that were named as {loading.FORMS}; give the controller itself where "
        "it can be given"
    )
