"""The controllers of Table II, each in all its variants."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from mjbiped.reproduction.grounds import SECTION_5
from mjbiped.terrain.terrain import Terrain

DELAYS = (None, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Values of the adaptive controller's zeta that are tried; the paper gives none for Table II."""

SLOPE_SOURCES = ("two_point", "local", "none")
"""Sources of the slope for the comparison controllers; the paper does not name it for all of them."""

NAMES: Mapping[str, str] = SECTION_5["methods"]
"""Registered controllers by the paper's names; LCTC, limit cycle tracking [20], is not in its Table II."""

METHODS = tuple(NAMES)

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

    def law(self, terrain: Terrain) -> dict[str, Any]:
        """Values of the law in a cell on a ground; comparison controllers are given its slope at the start."""
        if self.method == "adaptive":
            return adaptive(self.delay)
        start = math.degrees(terrain.slope_at(0.0)) + self.start_error
        settings = {"slope_source": self.slope_source, **dict(self.gains), "initial_slope_estimate_deg": start}
        return _law(NAMES[self.method], settings)


SETTLED, BLIND, FITTED = (
    {method: Variant(method, None, source, tuple(gains.items())) for method, (source, gains) in SECTION_5[name].items()}
    for name in ("settled", "blind", "fitted")
)
"""Settings of the comparison methods, as `section_5.toml` describes them."""

BLIND_SOURCE = BLIND["PBC"].slope_source


def settled(method: str, source: str) -> Variant:
    """Combine a comparison method's gains that settle with a slope source."""
    return replace(SETTLED[method], slope_source=source)


def variants() -> Iterator[Variant]:
    """List the adaptive controller with every zeta, and the comparison methods with every slope source."""
    yield from (Variant("adaptive", delay) for delay in DELAYS)
    yield from (settled(method, source) for method in SETTLED for source in SLOPE_SOURCES)


def gains_told(law: Mapping[str, object]) -> str:
    """Write a comparison controller's gains in words, from its description or any mapping of gains."""
    return ", ".join(f"{name} {law[name]:g}" for name in _GAINS if name in law)


def adaptive(delay: float | None, **settings: object) -> dict[str, Any]:
    """Values of the paper's controller in a cell, with its gains apart from some settings."""
    return _law("adaptive", {"replanning_delay": delay, **settings})


def _law(name: str, settings: Mapping[str, object]) -> dict[str, object]:
    return {f"controller.{key}": value for key, value in {"name": name, **settings}.items()}
