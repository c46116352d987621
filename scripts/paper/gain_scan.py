"""Walks of the comparison methods on the grounds of Table II, with every gain and slope source that is tried."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mjbiped.studies.reproduction.cell import cell
from mjbiped.studies.reproduction.reproduce import walked
from mjbiped.studies.reproduction.results import Choice, as_csv
from mjbiped.studies.reproduction.section_5 import GROUNDS, SLOPE_SOURCES, Agreement, Variant, agreement, terrain_of

GAINS = (
    0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0,
    60.0, 80.0, 100.0, 150.0, 200.0, 300.0,
)  # fmt: skip
"""Values of k of PBC in s, and of zeta of ECC and lambda of KETC in 1/s."""

RATIOS = (
    -3.5, -3.25, -3.0, -2.75, -2.5, -2.4, -2.3, -2.25, -2.2, -2.15, -2.1, -2.05, -2.0, -1.95, -1.9, -1.8, -1.75, -1.7,
    -1.6, -1.5, -1.4, -1.25, -1.0,
)  # fmt: skip
"""Values of mu of ECC; docs/comparison.md says why positive ones are useless."""

HIP_WEIGHTS = (0.0, 1.0)
"""Values of w of KETC: the ankle alone, or both legs alike."""


@dataclass(frozen=True)
class Tried:
    """A setting of a comparison method, and its walks on the grounds of Table II in the hybrid engine.

    Attributes:
        variant: Method, gains and slope source.
        cost: c_mt by ground, of six digits; NaN where the robot did not come to the end.
        ended: The step in which it ended, by ground, where it did not come to it.
    """

    variant: Variant
    cost: Mapping[str, float]
    ended: Mapping[str, int]

    @property
    def agreement(self) -> Agreement:
        """Agreement with the paper's row."""
        return agreement((self.variant.method, ground, cost) for ground, cost in self.cost.items())


def settings() -> list[Variant]:
    """List all settings that are tried: every gain with every slope source."""
    gains: list[tuple[str, tuple[tuple[str, float], ...]]] = [("PBC", (("gain", gain),)) for gain in GAINS]
    gains += [("ECC", (("ratio", ratio), ("gain", gain))) for ratio in RATIOS for gain in GAINS]
    gains += [("KETC", (("gain", gain), ("hip_weight", weight))) for weight in HIP_WEIGHTS for gain in GAINS]
    return [Variant(method, slope_source=source, gains=each) for method, each in gains for source in SLOPE_SOURCES]


def scan(choice: Choice, folder: Path, tried: Sequence[Variant] | None = None) -> list[Tried]:
    """Walk the five grounds of a reading with every setting in the hybrid engine, as many steps as the reading's.

    Args:
        choice: The reading.
        folder: Folder of finished walks.
        tried: The settings; `settings()` unless given.
    """
    chosen = settings() if tried is None else list(tried)
    grounds = {place[0]: terrain_of(place) for place in choice.places}
    cells = {
        (variant, name): cell(ground, variant.law(ground), steps=choice.length, engine="hybrid")
        for name, ground in grounds.items()
        for variant in chosen
    }
    results = dict(zip(cells, walked([*cells.values()], folder, progress=True), strict=True))
    found = []
    for variant in chosen:
        walks = {name: results[variant, name] for name in grounds}
        cost = {
            name: getattr(walk, f"{choice.kind}_end") if walk.finished else math.nan for name, walk in walks.items()
        }
        ended = {name: walk.steps + 1 for name, walk in walks.items() if not walk.finished}
        found.append(Tried(variant, cost, ended))
    return found


def ranked(tried: Iterable[Tried]) -> list[Tried]:
    """Sort settings: first by how many X stand where the paper's do, then by distance from its numbers."""
    return sorted(tried, key=lambda each: each.agreement.rank)


def fitted(tried: Sequence[Tried]) -> dict[str, Tried]:
    """Choose the best setting of each method, one for all grounds."""
    methods = dict.fromkeys(each.variant.method for each in tried)
    return {method: ranked(each for each in tried if each.variant.method == method)[0] for method in methods}


_NAMES = ("ratio", "gain", "hip_weight")
_HEADINGS = ("method", "slope_source", *_NAMES, *GROUNDS)


def write_tried(tried: Iterable[Tried]) -> str:
    """Write settings as CSV: c_mt by ground, or X and the step in which the walk ended."""
    lines = []
    for each in tried:
        gains = dict(each.variant.gains)
        cells = [f"X {each.ended[name]}" if name in each.ended else repr(each.cost[name]) for name in GROUNDS]
        lines.append([each.variant.method, each.variant.slope_source, *(gains.get(n, "") for n in _NAMES), *cells])
    return as_csv(_HEADINGS, lines)


def read_tried(text: str) -> list[Tried]:
    """Read the settings that `write_tried` wrote."""
    found = []
    for line in csv.DictReader(text.splitlines()):
        gains = tuple((name, float(line[name])) for name in _NAMES if line[name])
        ended = {name: int(line[name][2:]) for name in GROUNDS if line[name].startswith("X ")}
        cost = {name: math.nan if name in ended else float(line[name]) for name in GROUNDS}
        found.append(Tried(Variant(line["method"], slope_source=line["slope_source"], gains=gains), cost, ended))
    return found
