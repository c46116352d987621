"""The controllers of Table II, each in all its variants."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.control.registry import make_controller
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.reproduction.grounds import IMITATED_SLOPE
from mjbiped.robots.compass import Compass
from mjbiped.terrain.terrain import Terrain

DELAYS = (None, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Values of the adaptive controller's zeta that are tried; the paper gives none for Table II."""

SLOPE_SOURCES = ("two_point", "local", "none")
"""Sources of the slope for the comparison controllers; the paper does not name it for all of them."""

METHODS = ("adaptive", "PBC", "ECC", "KETC", "LCTC")
"""The paper's names of the controllers; LCTC, limit cycle tracking [20], is not in its Table II."""

_NAMES = ("adaptive", "passivity", "energy-constraint", "kinetic-energy", "limit-cycle")  # of `METHODS`
_GAINS = ("ratio", "gain", "hip_weight", "rate_gain", "position_gain")


@dataclass(frozen=True)
class Variant:
    """A method with the parameters that the paper leaves open.

    Attributes:
        method: One of `METHODS`.
        delay: zeta of the adaptive controller.
        slope_source: Slope source of a comparison controller; empty for the adaptive one, which estimates.
        gains: Gains of a comparison controller, by the names of its class's fields.
        start_error: Error of the slope that a comparison controller is given at the start, degrees.
    """

    method: str
    delay: float | None = None
    slope_source: str = ""
    gains: tuple[tuple[str, float], ...] = ()
    start_error: float = 0.0

    def controller(self, terrain: Terrain, robot: Compass | None = None) -> Controller:
        """Make the controller for a ground; comparison controllers are given its slope at the start."""
        model = robot or Compass()
        if self.method == "adaptive":
            return _law("adaptive", model, replanning_delay=self.delay)
        law: Any = _law(_NAMES[METHODS.index(self.method)], model, slope_source=self.slope_source, **dict(self.gains))
        start = terrain.slope_at(0.0) + math.radians(self.start_error)
        controller: Controller = replace(law, initial_slope_estimate=start)
        return controller


def _variants(*settings: tuple[str, str, dict[str, float]]) -> Mapping[str, Variant]:
    """Make variants of method, slope source and gains each, by method."""
    return {m: Variant(m, slope_source=source, gains=tuple(gains.items())) for m, source, gains in settings}


SETTLED = _variants(
    ("PBC", "two_point", {"gain": 5.0}),
    ("ECC", "local", {"ratio": -2.3, "gain": 5.0}),
    ("KETC", "local", {"gain": 6.0, "hip_weight": 1.0}),
    ("LCTC", "local", {"rate_gain": 10.0, "position_gain": 25.0}),
)
"""Gains with which steps on level ground converge, found as docs/comparison.md says and without a look at Table II, and
the slope source with which they were found; LCTC's gains are those of its source."""

BLIND_SOURCE = "two_point"
"""The only slope source that the paper names for an energy-based method, in its introduction for PBC."""

BLIND = _variants(
    ("PBC", BLIND_SOURCE, {"gain": 5.0}),
    ("ECC", BLIND_SOURCE, {"ratio": -2.3, "gain": 5.0}),
    ("KETC", BLIND_SOURCE, {"gain": 4.0, "hip_weight": 1.0}),
)
"""Settings of the energy-based methods without a look at Table II: `BLIND_SOURCE` for all of them, and the gains that
the rule of docs/comparison.md finds with it."""


FITTED = _variants(
    ("PBC", "none", {"gain": 25.0}),
    ("ECC", "none", {"ratio": -3.0, "gain": 80.0}),
    ("KETC", "none", {"gain": 40.0, "hip_weight": 0.0}),
)
"""Settings of the energy-based methods nearest to Table II, of all that `scripts/paper/fits.py` tries."""


def settled(method: str, source: str) -> Variant:
    """Combine a comparison method's gains that settle with a slope source."""
    return replace(SETTLED[method], slope_source=source)


def variants(method: str) -> Iterator[Variant]:
    """List the adaptive controller with every zeta, or a comparison method with every slope source."""
    if method == "adaptive":
        yield from (Variant(method, delay) for delay in DELAYS)
    else:
        yield from (settled(method, source) for source in SLOPE_SOURCES)


def gains_told(law: Mapping[str, Any]) -> str:
    """Write a comparison controller's gains in words, from its description or any mapping of gains."""
    return ", ".join(f"{name} {law[name]:g}" for name in _GAINS if name in law)


def adaptive(delay: float | None, **settings: Any) -> Controller:
    """Make the paper's controller with its gains and Table I's robot, apart from some settings."""
    return _law("adaptive", Compass(), replanning_delay=delay, **settings)


def _law(name: str, model: Compass, **settings: Any) -> Controller:
    return make_controller(name, model, settings, find_passive_gait(model, IMITATED_SLOPE))
