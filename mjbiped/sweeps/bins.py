"""A study's rows put into bins, and the middle of a measure in each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjbiped.robots.compass import Array
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.labels import parameter_label, value_label
from mjbiped.sweeps.plan import FINISHED

MOST_VALUES = 16
"""Of a parameter that are shown one by one; more are binned."""

_MOST_PARAMETERS = 3
_MOST_GROUPS = 5
_MOST_LISTED = 40  # where there is nothing else


@dataclass(frozen=True)
class Axis:
    """Bins of a parameter.

    Attributes:
        label: What stands beside it.
        bin: Each row's bin, -1 for a row without a value, shape (rows,).
        edges: Of the bins, shape (count + 1,); 0, 1, 2 ... where each bin has one value.
        at: Values of the bins, else their middles, shape (count,).
        ticks: Values of the bins, where each has one; else empty.
        log: Whether the scale is logarithmic.
    """

    label: str
    bin: NDArray[np.int64]
    edges: Array
    at: Array
    ticks: tuple[str, ...]
    log: bool = False

    @property
    def count(self) -> int:
        """Number of bins."""
        return len(self.edges) - 1

    @property
    def centres(self) -> Array:
        """Middles of the bins between their edges, shape (count,)."""
        return self.edges[:-1] + 0.5 if self.ticks else self.at


def values_of(rows: Iterable[Row], name: str) -> Array:
    """A measure of each row, NaN where it does not count: of walks that did not finish only `FINISHED` does."""
    if name == FINISHED:
        return np.array([float(row["outcome"] == "finished") for row in rows])
    return np.array(
        [row[name] if row["outcome"] == "finished" and row[name] is not None else math.nan for row in rows], dtype=float
    )


def middle(values: Array, name: str) -> float:
    """Median of a measure, or the share of walks that finished; NaN of nothing."""
    values = values[~np.isnan(values)]
    if not values.size:
        return math.nan
    return float(np.mean(values) if name == FINISHED else np.median(values))


def quartiles(values: Array) -> tuple[float, float]:
    """Lower and upper quartile of a measure; NaN of nothing."""
    values = values[~np.isnan(values)]
    if not values.size:
        return math.nan, math.nan
    lower, upper = np.quantile(values, (0.25, 0.75)).tolist()
    return lower, upper


def grouped(rows: Sequence[Row], names: Sequence[str]) -> Axis:
    """A bin for each combination of values that some columns have, in the order in which they come; one for none."""
    keys = [tuple(row[name] for name in names) for row in rows]
    kinds = list(dict.fromkeys(keys))
    places = {kind: i for i, kind in enumerate(kinds)}
    ticks = tuple(
        ", ".join(value_label(name, value) for name, value in zip(names, kind, strict=True) if value is not None)
        for kind in kinds
    )
    label = ", ".join(map(parameter_label, names))
    edges = np.arange(len(kinds) + 1.0)
    return Axis(label, np.array([places[key] for key in keys]), edges, edges[:-1], ticks)


def without_seeds(varied: Iterable[str]) -> list[str]:
    """Names of columns that mean something beside one another."""
    return [name for name in varied if not name.endswith(".seed")]


def chosen(rows: Sequence[Row], varied: Sequence[str]) -> tuple[list[str], list[str]]:
    """What figures of a study show of what varies in it.

    Args:
        rows: Of the table.
        varied: Names of columns, those that matter most first.

    Returns:
        Names of numeric columns, to be axes, and of those that tell groups of walks apart.
    """
    numeric = [name for name in varied if all(isinstance(row[name], float | int | None) for row in rows)]
    named = [name for name in varied if name not in numeric]
    while grouped(rows, named).count > (_MOST_GROUPS if numeric else _MOST_LISTED):
        named.pop()
    return numeric[:_MOST_PARAMETERS], named


def binned(rows: Sequence[Row], name: str, most: int, *, log: bool = False) -> Axis:
    """A numeric parameter's values one by one where they are few, else in so many bins of equal width.

    Args:
        rows: Of the table.
        name: Of its column.
        most: Number of bins.
        log: Whether their widths are equal on a logarithmic scale.
    """
    values = np.array([math.nan if row[name] is None else row[name] for row in rows], dtype=float)
    there = ~np.isnan(values)
    unique = np.unique(values[there])
    log = log or _is_geometric(unique)
    if len(unique) <= MOST_VALUES:
        place = np.where(there, np.searchsorted(unique, values), -1)
        ticks = tuple(f"{value:.4g}" for value in unique.tolist())
        return Axis(parameter_label(name), place, np.arange(len(unique) + 1.0), unique, ticks, log)
    low, high = float(unique[0]), float(unique[-1])
    edges = np.geomspace(low, high, most + 1) if log else np.linspace(low, high, most + 1)
    at = np.sqrt(edges[:-1] * edges[1:]) if log else (edges[:-1] + edges[1:]) / 2.0
    place = np.where(there, np.clip(np.searchsorted(edges, values, side="right") - 1, 0, most - 1), -1)
    return Axis(parameter_label(name), place, edges, at, (), log)


def _is_geometric(values: Array) -> bool:
    """Whether values have equal ratios, as a range on a logarithmic scale has."""
    if len(values) < 3 or not values[0] > 0.0:
        return False
    ratios = np.diff(np.log(values))
    return float(np.ptp(ratios)) < 1e-6 * float(ratios[0])
