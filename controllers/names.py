"""Controllers by the names that they have on the command line and in study files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from controllers import (
    AdaptiveController,
    Controller,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassiveController,
    PassivityController,
)
from controllers.given_slope import GivenSlopeController
from mjbiped.gaits.passive import Gait, find_passive_gait
from mjbiped.robots.compass import Compass
from mjbiped.utils.domains import SLOPE_DEG, known_name

GIVEN_SLOPE: Mapping[str, type[GivenSlopeController]] = MappingProxyType(
    {
        "passivity": PassivityController,
        "energy-constraint": EnergyConstraintController,
        "kinetic-energy": KineticEnergyController,
        "limit-cycle": LimitCycleController,
    }
)
"""The comparison controllers."""

CONTROLLERS = ("adaptive", "passive", *GIVEN_SLOPE)

SHARED: Mapping[str, float] = MappingProxyType({"imitate_slope_deg": 2.0, "initial_slope_estimate_deg": 0.0})
"""Settings that all but passive have, with their defaults: slope of the passive gait that is imitated, and slope
estimate at the start, for the comparison controllers the slope that they are given; degrees."""


def gains(kind: type[GivenSlopeController]) -> dict[str, Any]:
    """Names of a comparison controller's gains, with their defaults."""
    return {each.name: each.default for each in fields(kind) if not each.kw_only and each.name not in ("robot", "gait")}


def settings_of(name: str) -> dict[str, Any]:
    """Names of a controller's settings, with their defaults.

    Raises:
        InputError: The controller's name is unknown.
    """
    known_name("controller", name, CONTROLLERS)
    if name == "passive":
        return {}
    if name == "adaptive":
        own = {each.name: each.default for each in fields(AdaptiveController)}
        for taken in ("robot", "gait", "initial_slope_estimate"):
            del own[taken]
        return {**SHARED, **own}
    kind = GIVEN_SLOPE[name]
    return {**SHARED, **gains(kind), "slope_source": next(f.default for f in fields(kind) if f.name == "slope_source")}


def make_controller(name: str, robot: Compass, settings: Mapping[str, Any], gait: Gait | None = None) -> Controller:
    """The controller of a name.

    Args:
        name: One of `CONTROLLERS`.
        robot: The robot model of the law.
        settings: Values by the names of `settings_of`; what is left out has its default.
        gait: What is imitated; unless given, it is found by `imitate_slope_deg`.

    Raises:
        InputError: A name is unknown, or a value is outside its domain.
        GaitError: The slope to be imitated has no passive gait.
    """
    valid = settings_of(name)
    for key in settings:
        known_name(f"setting of the controller {name}", key, valid)
    if name == "passive":
        return PassiveController()
    given = {**SHARED, **settings}
    slope, estimate = (math.radians(SLOPE_DEG.check(key, given.pop(key))) for key in SHARED)
    gait = gait or find_passive_gait(robot, slope)
    if name == "adaptive":
        return AdaptiveController(robot, gait, initial_slope_estimate=estimate, **given)
    return GIVEN_SLOPE[name](robot, gait, initial_slope=estimate, **given)
