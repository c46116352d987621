"""Numbers that others have published about walkers which this laboratory can simulate, digit by digit as printed.

They stand in `published.toml`, each with its source, and with its fault where it has one. `python -m
scripts.validation.page` computes them again and writes docs/tables/validation/; `tests/scripts/test_published.py`
holds them. The tables of the paper that this project implements stand in `mjbiped.studies.reproduction.section_5`.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TypeAlias

from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.round import RoundCompass, RoundKneed


@dataclass(frozen=True)
class Published:
    """A number as it was printed.

    Attributes:
        quantity: What it is, with its unit.
        printed: Its digits; of a pair of conjugate numbers the one above the real axis, as "0.1 + 0.2i".
        place: Where it stands in its source.
        claimed: How exact its source calls it; None: no word about it.
        fault: What is wrong with it; empty where it is right.
    """

    quantity: str
    printed: str
    place: str
    claimed: float | None = None
    fault: str = ""

    @property
    def value(self) -> complex:
        """The number."""
        return complex(self.printed.replace(" ", "").replace("i", "j"))

    @property
    def decimals(self) -> int:
        """Digits printed after the point."""
        return len(self.printed.rstrip("i").rpartition(".")[2])

    @property
    def tolerance(self) -> float:
        """How far the true number may lie from it: what its source claims, or half a unit of each last digit."""
        half = 0.5 * 10.0**-self.decimals
        return (abs(complex(half, half)) if self.value.imag else half) if self.claimed is None else self.claimed


GARCIA_SLOPE = 0.009
"""Of the gaits of the simplest walker, rad."""

GARCIA_ROBOT = Compass(leg_mass=1e-9, hip_mass=1e3, lower_length=1e-9, upper_length=1e3, leg_inertia=0.0, gravity=1e3)
"""The simplest walker: massless legs with their mass at the feet, but for 1e-12 of the hip's mass and of the length.

Its unit of time, sqrt(l/g), is 1 s.
"""


GOSWAMI_SLOPE = math.radians(3.0)
GOSWAMI_ROBOT = Compass(leg_mass=5.0, hip_mass=10.0, lower_length=0.5, upper_length=0.5, leg_inertia=0.0)
"""Point masses on the legs. The report has no number for gravity."""


GOSWAMI_CHAOS = math.radians(5.2)
"""Slope whose gait the report calls chaotic, section 4.2.5."""

HSU_CHEN_SLOPE = math.asin(7.25 / 144)
HSU_CHEN_ROBOT = KneedBiped(0.5, 0.05, 0.5, 0.5, 0.5, 0.325, 0.125, 0.0, 0.0, gravity=9.8)
HSU_CHEN_SECOND = KneedBiped(0.5, 0.125, 0.5, 0.5, 0.5, 0.325, 0.125, 0.0, 0.0, gravity=9.8)
"""The same with heavier shanks."""


DRAKE_SLOPE = 0.0525
DRAKE_ROBOT = Compass(leg_mass=5.0, hip_mass=10.0, lower_length=0.5, upper_length=0.5, leg_inertia=0.0, gravity=9.81)
"""Drake's default `CompassGait`."""

DRAKE: Mapping[str, float] = {"statics": 1e-15, "guard": 1e-16, "angular momentum": 5e-15}
"""Tolerances of `compass_gait_test.cc` in Drake, for those of its invariants that need no symbolic algebra.

Acceleration of the posture that a hip torque holds at rest, rad/s^2; height of the foot at touchdown, m; angular
momentum about the struck point, kg m^2/s.
"""

MCGEER_ROBOT = RoundCompass(
    *(0.5, 0.0), lower_length=0.63, upper_length=0.37, foot_radius=0.3, leg_inertia=0.5 * 0.32**2, gravity=1.0
)
MCGEER_SLOPE = 0.0278547
"""In units of the leg's length, the robot's mass, and gravity; the slope, in rad, is that of half angles of 0.3."""

MCGEER_KNEED_ROBOT = RoundKneed(
    *(0.1, 0.062, 0.676),
    *(0.46, 0.54),
    *(0.20, 0.24),
    shank_offset=-0.01,
    stop_angle=0.2,
    foot_radius=0.2,
    thigh_inertia=0.1 * 0.135**2,
    shank_inertia=0.062 * 0.186**2,
    gravity=1.0,
)
MCGEER_KNEED_SLOPE = 0.0456

ROUND_FEET_ROBOT = RoundCompass(
    *(0.5, 1.0), lower_length=0.7, upper_length=0.5, foot_radius=0.2, leg_inertia=0.02, gravity=1.0
)
ROUND_FEET_SLOPE = 0.01

_SOURCES: Mapping[str, Mapping[str, Published]] = {
    source: {name: Published(**number) for name, number in numbers.items()}
    for source, numbers in tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")).items()
}
GARCIA, BHOUNSULE, GOSWAMI, HSU_CHEN, MCGEER, MCGEER_KNEED, ROUND_FEET = _SOURCES.values()
"""Published numbers by source, see `published.toml`."""


class Computed(NamedTuple):
    """A number of ours beside a published one.

    Attributes:
        value: In the unit and with the sign of the published number.
        error: How far it may be from the model's exact number: measured by a second way, or by a finer calculation.
        as_published: Where the published number has a fault: what comes of the calculation that explains it; None where
            none is known.
    """

    value: complex
    error: float
    as_published: complex | None = None


Computations: TypeAlias = Mapping[str, Callable[[], Computed]]
"""By the names of the published numbers."""
