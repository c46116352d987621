"""The gains with which the comparison methods come nearest to Table II: many settings on the grounds of one reading."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from tqdm.auto import tqdm

from mjbiped.errors import RecordError
from mjbiped.records.measures import WORK_KINDS
from mjbiped.reproduction.cell import Cell
from mjbiped.reproduction.grounds import reading_at
from mjbiped.reproduction.methods import SLOPE_SOURCES, Variant, gains_told
from mjbiped.reproduction.published import GROUNDS, TABLE_2
from mjbiped.reproduction.rows import rounded
from mjbiped.reproduction.table_2 import Agreement, Choice, agreement
from mjbiped.reproduction.walks import Walks
from mjbiped.rollout.walk_many import walk_many
from mjbiped.terrain.terrain import Terrain

GAINS = (
    0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0,
    60.0, 80.0, 100.0, 150.0, 200.0, 300.0,
)  # fmt: skip
"""k of PBC in s, zeta of ECC and lambda of KETC in 1/s."""

RATIOS = (
    -3.5, -3.25, -3.0, -2.75, -2.5, -2.4, -2.3, -2.25, -2.2, -2.15, -2.1, -2.05, -2.0, -1.95, -1.9, -1.8, -1.75, -1.7,
    -1.6, -1.5, -1.4, -1.25, -1.0,
)  # fmt: skip
"""mu of ECC; docs/comparison.md says why positive ones are of no use."""

HIP_WEIGHTS = (0.0, 1.0)
"""w of KETC: the ankle alone, or both legs alike."""

_COSTS = ("cost_of_transport", "cost_of_transport_net", "cost_of_transport_positive")  # in the order of WORK_KINDS


@dataclass(frozen=True)
class Tried:
    """A setting of a comparison method, and what came of it on the grounds of Table II in the hybrid engine.

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
        """How far it agrees with the paper's row."""
        return agreement((self.variant.method, ground, cost) for ground, cost in self.cost.items())


def settings() -> list[Variant]:
    """All that is tried: every gain with every slope source."""
    gains: list[tuple[str, tuple[tuple[str, float], ...]]] = [("PBC", (("gain", gain),)) for gain in GAINS]
    gains += [("ECC", (("ratio", ratio), ("gain", gain))) for ratio in RATIOS for gain in GAINS]
    gains += [("KETC", (("gain", gain), ("hip_weight", weight))) for weight in HIP_WEIGHTS for gain in GAINS]
    return [Variant(method, slope_source=source, gains=each) for method, each in gains for source in SLOPE_SOURCES]


def scan(
    choice: Choice,
    kept: Walks,
    tried: Sequence[Variant] | None = None,
    *,
    workers: int | None = None,
    progress: bool = False,
) -> list[Tried]:
    """Let every setting walk the five grounds of a reading in the hybrid engine, as many steps as the reading's.

    The walks of a method on a ground are kept together as soon as they have ended.

    Args:
        choice: The reading.
        kept: Where finished walks are.
        tried: The settings; `settings()` unless given.
        workers: Walks at a time; see `mjbiped.walk_many`.
        progress: Show a progress bar (never where the output is not a terminal).
    """
    chosen = settings() if tried is None else list(tried)
    by_method = {method: [each for each in chosen if each.method == method] for method in TABLE_2}
    grounds = {place[0]: reading_at(place).terrain for place in choice.places}
    batches = [(each, name) for each in by_method.values() if each for name in grounds]
    costs: dict[Variant, dict[str, float]] = {variant: {} for variant in chosen}
    ended: dict[Variant, dict[str, int]] = {variant: {} for variant in chosen}
    with tqdm(total=len(batches), desc="gains", unit="batch", disable=None if progress else True) as bar:
        for variants, name in batches:
            walked = _batch(variants, grounds[name], choice.length, kept, workers)
            for variant, (steps, *values) in zip(variants, walked, strict=True):
                costs[variant][name] = rounded(values[WORK_KINDS.index(choice.kind)])
                if math.isnan(costs[variant][name]):
                    ended[variant][name] = int(steps) + 1
            bar.update()
    return [Tried(variant, costs[variant], ended[variant]) for variant in chosen]


def _batch(
    variants: Sequence[Variant], terrain: Terrain, steps: int, kept: Walks, workers: int | None
) -> list[list[float]]:
    """Touchdowns and c_mt of every kind of each walk, NaN where it did not come to its end."""
    cells = [Cell("hybrid", variant.controller(terrain), terrain, steps=steps) for variant in variants]

    def walked() -> list[list[float]]:
        walks = walk_many(
            [cell.controller for cell in cells],
            terrain,
            engine="hybrid",
            steps=steps,
            sample_period=None,
            summaries=True,
            workers=workers,
        )
        return [
            [walk["steps"], *(walk[name] if walk["outcome"] == "finished" else math.nan for name in _COSTS)]
            for walk in walks
        ]

    return kept.numbers(cells, walked)


def ranked(tried: Iterable[Tried]) -> list[Tried]:
    """The settings whose X stand where the paper's do first, and of these the nearest to its numbers."""
    return sorted(tried, key=lambda each: each.agreement.rank)


def fitted(tried: Sequence[Tried]) -> dict[str, Tried]:
    """The first of each method, by its name: one setting for all its rows."""
    methods = dict.fromkeys(each.variant.method for each in tried)
    return {method: ranked(each for each in tried if each.variant.method == method)[0] for method in methods}


_NAMES = ("ratio", "gain", "hip_weight")
_HEADINGS = ("method", "slope_source", *_NAMES, *GROUNDS)


def write_tried(tried: Iterable[Tried]) -> str:
    """Settings as CSV, a heading first: c_mt by ground, or X and the step in which the walk ended."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_HEADINGS)
    for each in tried:
        gains = dict(each.variant.gains)
        cells = [f"X {each.ended[name]}" if name in each.ended else repr(each.cost[name]) for name in GROUNDS]
        writer.writerow([each.variant.method, each.variant.slope_source, *(gains.get(n, "") for n in _NAMES), *cells])
    return text.getvalue()


def read_tried(text: str) -> list[Tried]:
    """The settings that `write_tried` wrote.

    Raises:
        RecordError: The text is no such table.
    """
    found = []
    try:
        for line in csv.DictReader(io.StringIO(text)):
            gains = tuple((name, float(line[name])) for name in _NAMES if line[name])
            ended = {name: int(line[name][2:]) for name in GROUNDS if line[name].startswith("X ")}
            cost = {name: math.nan if name in ended else float(line[name]) for name in GROUNDS}
            variant = Variant(line["method"], slope_source=line["slope_source"], gains=gains)
            found.append(Tried(variant, cost, ended))
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"not a table of the gains that were tried: {error!r}") from error
    return found


def told(variant: Variant) -> str:
    """A setting in words."""
    return f"{gains_told(dict(variant.gains))}, {variant.slope_source}"
