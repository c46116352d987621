"""The controllers of Table II, each in all its variants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

from controllers import (
    AdaptiveController,
    Controller,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassivityController,
)
from mjbiped.compass import Compass
from mjbiped.gait import Gait, find_passive_gait
from mjbiped.reproduction.published import IMITATED_SLOPE
from mjbiped.terrain import Terrain

_Compared = PassivityController | EnergyConstraintController | KineticEnergyController | LimitCycleController

DELAYS = (None, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""zeta of the adaptive controller: the paper gives none for Table II."""

SLOPE_SOURCES = ("two_point", "local", "none")
"""What the comparison controllers take for the slope: the paper does not say for all of them."""

METHODS = ("adaptive", "PBC", "ECC", "KETC", "LCTC")
"""The paper's names; LCTC, limit cycle tracking [20], is not in its Table II."""

_COMPARED: Mapping[str, type[_Compared]] = {
    "PBC": PassivityController,
    "ECC": EnergyConstraintController,
    "KETC": KineticEnergyController,
    "LCTC": LimitCycleController,
}


@dataclass(frozen=True)
class Variant:
    """A method with the one parameter that the paper leaves open.

    Attributes:
        method: One of `METHODS`.
        delay: zeta of the adaptive controller.
        slope_source: Of the comparison controllers; empty for the adaptive one, which estimates.
    """

    method: str
    delay: float | None = None
    slope_source: str = ""

    def controller(self, terrain: Terrain, robot: Compass | None = None) -> Controller:
        """The law, for a ground: comparison controllers are told its slope at the start."""
        model = robot or Compass()
        gait = _imitated(model)
        if self.method == "adaptive":
            return AdaptiveController(model, gait, replanning_delay=self.delay)
        source, slope = self.slope_source, terrain.slope_at(0.0)
        return _COMPARED[self.method](model, gait, slope_source=source, initial_slope=slope)


def variants(method: str) -> Iterator[Variant]:
    """All variants of a method."""
    if method == "adaptive":
        yield from (Variant(method, delay) for delay in DELAYS)
    else:
        yield from (Variant(method, slope_source=source) for source in SLOPE_SOURCES)


def default_source(method: str) -> str:
    """The slope source that a comparison controller has unless told otherwise."""
    return str(_COMPARED[method].slope_source)


def adaptive(
    delay: float | None, *, adaptation_gain: float = AdaptiveController.adaptation_gain, estimate_update: bool = True
) -> AdaptiveController:
    """The paper's controller with its gains and Table I's robot."""
    robot = Compass()
    return AdaptiveController(
        robot,
        _imitated(robot),
        replanning_delay=delay,
        adaptation_gain=adaptation_gain,
        estimate_update=estimate_update,
    )


@cache
def _imitated(robot: Compass) -> Gait:
    return find_passive_gait(robot, IMITATED_SLOPE)
