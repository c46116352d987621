"""Controllers by the names that they have on the command line and in study files.

Nothing here knows a control law. A package registers its controllers as entry points of the group `GROUP`, as this
project does in its own pyproject.toml, and they are found when somebody asks for them:

```toml
[project.entry-points."mjbiped.controllers"]
spread = "my_package.spread:HipSpread"
```

A registered class is a frozen dataclass, and its fields are the settings of the controller. Three names are special: a
field `robot` gets the robot's model, `gait` the passive gait that is imitated, and one of `SLOPE_FIELDS` the slope
estimate at the start.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.errors import InputError, shown
from mjbiped.gaits.passive import Gait, find_passive_gait
from mjbiped.robots.compass import Compass
from mjbiped.utils.domains import SLOPE_DEG, known_name

GROUP = "mjbiped.controllers"
"""The group of entry points."""

DEFAULT_CONTROLLER = "adaptive"

SHARED: Mapping[str, float] = MappingProxyType({"imitate_slope_deg": 2.0, "initial_slope_estimate_deg": 0.0})
"""Settings of all controllers that imitate a gait, with their defaults: the slope of that passive gait, and the slope
estimate at the start, degrees."""

SLOPE_FIELDS = ("initial_slope_estimate", "initial_slope")
"""Names of a field that takes the slope estimate at the start, rad."""


@cache
def registered() -> Mapping[str, EntryPoint]:
    """The registered controllers by name, the default first; none is imported yet.

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
    """Names of all registered controllers, the default first."""
    return tuple(registered())


def controller_class(name: str) -> type[Controller]:
    """The class of a name.

    Raises:
        InputError: The name is unknown, or the registered class cannot be imported.
    """
    entry = registered()[known_name("controller", name, registered())]
    try:
        kind: type[Controller] = entry.load()
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"the controller {name} is registered as {entry.value}, which fails: {shown(error)}"
        ) from error
    return kind


def settings_of(name: str) -> dict[str, Any]:
    """Names of a controller's settings, with their defaults.

    Raises:
        InputError: As `controller_class`.
    """
    own = _fields(controller_class(name))
    shared = SHARED if "gait" in own else {}
    return {**shared, **{key: _default(own[key]) for key in own if key not in ("robot", "gait", *SLOPE_FIELDS)}}


def make_controller(name: str, robot: Compass, settings: Mapping[str, Any], gait: Gait | None = None) -> Controller:
    """The controller of a name.

    Args:
        name: One of `controller_names`.
        robot: The robot model of the law.
        settings: Values by the names of `settings_of`; what is left out has its default.
        gait: What is imitated; unless given, it is found by `imitate_slope_deg`.

    Returns:
        An object of `controller_class(name)`.

    Raises:
        InputError: A name is unknown, or a value is outside its domain.
        GaitError: The slope to be imitated has no passive gait.
    """
    valid = settings_of(name)
    for key in settings:
        known_name(f"setting of the controller {name}", key, valid)
    kind = controller_class(name)
    own, values = _fields(kind), {**valid, **settings}
    if "robot" in own:
        values["robot"] = robot
    if "gait" in own:
        slope, estimate = (math.radians(SLOPE_DEG.check(key, values.pop(key))) for key in SHARED)
        values["gait"] = gait or find_passive_gait(robot, slope)
        values |= {key: estimate for key in SLOPE_FIELDS if key in own}
    return kind(**values)


def controller_from(description: Mapping[str, Any]) -> Controller:
    """The registered controller that a record describes, built anew; see `Controller.describe`.

    Raises:
        InputError: No registered class has the description's name, or it has other parameters.
        GaitError: The gait that it imitated is not found.
    """
    described = dict(description)
    wanted = described.pop("name", None)
    classes = {entry.value.rpartition(":")[2]: name for name, entry in registered().items()}
    if wanted not in classes:
        raise InputError(
            f"the record's controller is a {shown(wanted)}, and only registered ones are built anew: "
            f"{', '.join(sorted(classes))}; give the controller itself where it can be given"
        )
    kind = controller_class(classes[wanted])
    odd = described.keys() ^ _fields(kind).keys()
    if odd:
        raise InputError(
            f"the record's {wanted} has not the parameters of this version's: {', '.join(sorted(odd))} differ"
        )
    try:
        if "gait" in described:
            gait = described["gait"]
            described["gait"] = find_passive_gait(Compass(**gait["robot"]), gait["slope"])
        if "robot" in described:
            described["robot"] = Compass(**described["robot"])
        return kind(**described)
    except (KeyError, TypeError) as error:
        raise InputError(f"the record does not tell its controller's robot and gait: {shown(error)}") from error


def _fields(kind: type[Controller]) -> dict[str, Field[Any]]:
    return {each.name: each for each in fields(kind)} if is_dataclass(kind) else {}


def _default(field: Field[Any]) -> Any:
    if field.default_factory is not MISSING:
        return field.default_factory()
    if field.default is MISSING:
        raise InputError(f"the controller's field {field.name} has no default: a registered one needs it")
    return field.default
