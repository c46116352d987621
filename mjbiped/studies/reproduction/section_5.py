"""Section V of the paper: its tables as printed, its grounds as they can be read, and the controllers that it compares.

The numbers stand in `section_5.toml`. Of Table II's grounds the paper gives the treads' depth, the steps' height, the
slopes' length and change. It does not say whether each step goes the same way, nor where the first one lies: every
reading is walked.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from itertools import cycle, islice, product
from typing import Any, NamedTuple, TypeAlias

from mjbiped.terrain.terrain import Terrain

FILES = resources.files("mjbiped.studies.reproduction")
SECTION_5: Mapping[str, Any] = tomllib.loads((FILES / "section_5.toml").read_text(encoding="utf-8"))
"""The paper's tables, the readings of its grounds and the methods' settings."""

IMITATED_SLOPE = math.radians(2.0)
"""Slope of the imitated gait in every simulation of section V, rad."""

STAIRS, SLOPES = ("stair 1", "stair 2"), ("slope 1", "slope 2")
UNEVEN = (*STAIRS, *SLOPES)
GROUNDS = ("level", *UNEVEN)

TABLE_2: Mapping[str, Mapping[str, float]] = {
    method: dict(zip(GROUNDS, costs, strict=True)) for method, costs in SECTION_5["table_2"].items()
}
"""c_mt by method and ground; NaN where the paper has an X (instability)."""

ENERGY_BASED = tuple(method for method in TABLE_2 if method != "adaptive")
"""The methods that Table II compares the adaptive controller with."""

TABLE_3: Mapping[float | None, tuple[float, float]] = {
    None if zeta == "none" else zeta: (torque, cost) for zeta, torque, cost in SECTION_5["table_3"]["rows"]
}
"""Greatest torque (N m) and c_mt by zeta; None: no re-planning."""

_FIGURES = SECTION_5["figures"]

DRAWN_DELAYS: Sequence[float | None] = [None if zeta == "none" else zeta for zeta in _FIGURES["zetas"]]
"""Values of zeta in Fig. 6; Fig. 4 has the second."""

PAPER_GAIN, ADAPTATION_GAINS = _FIGURES["paper_gamma"], _FIGURES["gammas"]
"""Value of gamma in section V-B, and those in Fig. 5."""

START_ESTIMATES: Sequence[float] = _FIGURES["starts"]
"""Slope estimates at the start of Fig. 5, degrees, on ground that begins level; Fig. 4 has the first."""

START_ERROR = 0.05
"""Error of the start slope that the comparison methods are given, degrees, to test how well a fit bears it."""

DIGITS = 4
"""Decimals of c_mt in the paper's tables."""

Segments: TypeAlias = Sequence[tuple[float, float, float]]
"""(length in m, slope in degrees, step up in m) each, as `Terrain.from_segments` takes them."""


FOUND: Segments = [(length, slope, step) for length, slope, step in SECTION_5["table_3"]["found"]]
"""The mixed ground that comes nearest to Table III, which `scripts/paper/search_table_3.py` found."""


class Place(NamedTuple):
    """A ground of Table II as it is read.

    Attributes:
        ground: Name of the ground.
        pattern: Pattern of its steps or changes of slope; empty on level ground.
        first: Position of the first step or change of slope, m.
    """

    ground: str
    pattern: str
    first: float


LEVEL = Place("level", "", 0.0)

COUNT = 30
"""Number of steps or changes of slope of a ground: more than 100 steps of 0.38 m can reach."""

FIRST_RISERS, FIRST_CHANGES = (SECTION_5[kind]["first"] for kind in ("stairs", "slopes"))
"""Positions of the first riser, and lengths of the first slope segment, m."""

STAIR_PATTERNS, SLOPE_PATTERNS = (SECTION_5[kind]["patterns"] for kind in ("stairs", "slopes"))
"""Heights of the risers in units of the step's height, and slopes of the segments in units of the change Δ, downhill
positive; both are repeated."""

READINGS: Sequence[Place] = [
    LEVEL,
    *(Place(ground, pattern, x) for ground, x, pattern in product(STAIRS, FIRST_RISERS, STAIR_PATTERNS)),
    *(Place(ground, pattern, x) for ground, x, pattern in product(SLOPES, FIRST_CHANGES, SLOPE_PATTERNS)),
]
"""All readings of Table II's grounds."""

PRINTED: Sequence[Place] = [Place(*place) for place in SECTION_5["printed"]]
"""Readings by the signs of the paper's Fig. 4: steps up positive, slopes downhill positive, each change added."""


def meets(ours: float, paper: float) -> bool:
    """Whether a c_mt agrees with a printed one within half a unit of the last digit."""
    return abs(ours - paper) <= 0.5 * 10.0**-DIGITS


def root_mean_square(values: Sequence[float]) -> float:
    """Compute the root mean square of some values."""
    return math.sqrt(sum(value**2 for value in values) / len(values))


def log_ratio(ours: float, printed: float) -> float:
    """ln(ours / paper's); infinite where ours does not exist or is not positive."""
    return math.log(ours / printed) if ours > 0.0 else math.inf


class Agreement(NamedTuple):
    """Agreement with the paper on where methods fail, and on their numbers.

    Attributes:
        agreeing: Grounds and methods that are walked to the end in both, or in neither.
        asked: Grounds and methods in all.
        met: Numbers of the paper's that ours are to the last digit.
        numbers: Numbers that the paper has.
        distance: Root mean square of ln(ours / paper's) where both have a number; NaN where that is nowhere.
    """

    agreeing: int
    asked: int
    met: int
    numbers: int
    distance: float

    @property
    def rank(self) -> tuple[int, float]:
        """Sort key, smaller for better ones: first the number of X and numbers that stand where the paper's do."""
        return -self.agreeing, math.inf if math.isnan(self.distance) else self.distance

    @property
    def in_kind(self) -> str:
        """Write how many cells of Table II are X or number as in the paper."""
        return f"{self.agreeing} of {self.asked}"


def agreement(costs: Iterable[tuple[str, str, float]]) -> Agreement:
    """Compare costs with the paper's Table II.

    Args:
        costs: Method, ground, and c_mt, which is NaN where the robot did not come to the end.
    """
    both = [(ours, TABLE_2[method][ground]) for method, ground, ours in costs]
    agreeing = sum(math.isnan(ours) == math.isnan(printed) for ours, printed in both)
    numbers = [(ours, printed) for ours, printed in both if not math.isnan(printed)]
    off = [log_ratio(*each) for each in numbers if each[0] > 0.0]
    distance = root_mean_square(off) if off else math.nan
    return Agreement(agreeing, len(both), sum(meets(*each) for each in numbers), len(numbers), distance)


def terrain_of(place: Place) -> Terrain:
    """Make a ground of Table II as it is read."""
    if place == LEVEL:
        return Terrain.level()
    kind, change = SECTION_5["stairs" if place.ground in STAIRS else "slopes"], SECTION_5["changes"][place.ground]
    changes = [factor * change for factor in islice(cycle(kind["patterns"][place.pattern]), COUNT)]
    if place.ground in STAIRS:
        segments = [(place.first, 0.0, 0.0), *((kind["length"], 0.0, rise) for rise in changes)]
    else:
        lengths = [place.first, *[kind["length"]] * (COUNT - 1)]
        segments = [(length, slope, 0.0) for length, slope in zip(lengths, changes, strict=True)]
    return Terrain.from_segments(segments, name=place.ground)


def end_of(segments: Segments) -> float:
    """Position x of the end of the last segment, m, at which the walk is finished."""
    return math.fsum(length * math.cos(math.radians(slope)) for length, slope, _ in segments)


DELAYS = (None, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Values of the adaptive controller's zeta that are tried; the paper gives none for Table II."""

SLOPE_SOURCES = ("two_point", "local", "none")
"""Sources of the slope for the comparison controllers; the paper does not name it for all of them."""

METHODS: Mapping[str, str] = SECTION_5["methods"]
"""Registered controllers by the paper's names; LCTC, limit cycle tracking [20], is not in its Table II."""

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
        return _law(METHODS[self.method], settings)


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


def adaptive(replanning_delay: float | None, **settings: object) -> dict[str, Any]:
    """Values of the paper's controller in a cell, with its gains apart from some settings."""
    return _law("adaptive", {"replanning_delay": replanning_delay, **settings})


def _law(name: str, settings: Mapping[str, object]) -> dict[str, object]:
    return {f"controller.{key}": value for key, value in {"name": name, **settings}.items()}
