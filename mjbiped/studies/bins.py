"""A study's rows in bins, the contents of its figures, and their labels."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.records.summary import measures_of
from mjbiped.robots.compass import Array
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.kneed import KneedBiped
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.studies.cell import FAILED, Row, state_of
from mjbiped.studies.plan import FINISHED
from mjbiped.terrain.presets import PRESETS
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import annotated

COST = "cost_of_transport"

_IN_WORDS = {".plus_minus": ", ±", ".low": ", low end", ".high": ", high end", "_deg": "", ".": " ", "_": " "}
"""Parts of a dotted name, in the order in which they are replaced."""

_OWNERS = (Disturbances, ScuffingRule, Mujoco, *(getattr(Terrain, name) for name in PRESETS), *KINDS.values())
_DOMAINS = {name: domain for owner in _OWNERS for name, (domain, _) in annotated(owner).items()} | state_of(KneedBiped)
_UNITS = {name: str(getattr(getattr(d, "ends", d), "unit", "")).replace("^2", "²") for name, d in _DOMAINS.items()}
_UNITS |= {"distance": "m", "position_gain": "1/s", "velocity_gain": "1/s"}
"""Units of quantities by their names; those of walks and control laws are not in reach here."""
_MEASURES = {
    each.key: (each.label, each.unit if each.factor == 1 else "m" if each.key.endswith("_m") else "")
    for each in measures_of(KneedBiped)
} | {FINISHED: ("share that finished", "")}
"""Labels and units of measures as the table has them, which summaries of single walks may show scaled."""


def parameter_label(name: str) -> str:
    """Label a varied quantity in words, with its unit."""
    words = name.removesuffix(".name")
    for part, said in _IN_WORDS.items():
        words = words.replace(part, said)
    unit = "°" if "_deg" in name else next((_UNITS[part] for part in name.split(".") if part in _UNITS), "")
    return f"{words} ({unit})" if unit else words


def measure_label(name: str) -> str:
    """Label a measure in words, with its unit."""
    label, unit = _MEASURES.get(name, (name.replace("_", " "), ""))
    return f"{label} ({unit})" if unit else label


def value_label(name: str, value: object) -> str:
    """Label a value that tells groups apart: a name alone, others after their parameter's name, None not at all."""
    if value is None:
        return ""
    if name == "engine" or name.endswith((".name", ".file", ".kind")):
        return str(value)
    return f"{name.rpartition('.')[2].replace('_', ' ')} {value}"


SHOWN = (COST, FINISHED, "peak_ankle_torque_Nm")
"""Measures in the figures of a study unless its file says otherwise."""

MOST_VALUES = 16
"""Greatest number of a parameter's values that are shown one by one; more are binned."""

_MOST_PARAMETERS = 3
_MOST_GROUPS = 5
_MOST_LISTED = 40  # where there is nothing else
_FEWEST_BINS = 3
_WALKS_IN_BIN = 12  # at least, in the mean


@dataclass(frozen=True)
class Axis:
    """Bins of a parameter.

    Attributes:
        name: Name of the column, or of the columns.
        label: The axis's label.
        bin: Each row's bin, -1 for a row without a value, shape (rows,).
        edges: Edges of the bins, shape (count + 1,); 0, 1, 2 ... where each bin has one value.
        at: Values of the bins where each has one, else their middles, shape (count,).
        ticks: Values of the bins as texts where each has one, else empty.
        log: Whether the scale is logarithmic.
    """

    name: str
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

    @property
    def texts(self) -> tuple[str, ...]:
        """The bins' values, or their ranges where they have many, as texts."""
        return self.ticks or tuple(f"{low:.3g} to {high:.3g}" for low, high in pairwise(self.edges))

    def within(self, which: int, group: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Rows of a group in a bin; all of them, as a comparison, where none of the group has the parameter."""
        there: NDArray[np.bool_] = group if bool((self.bin[group] < 0).all()) else group & (self.bin == which)
        return there


def values_of(rows: Iterable[Row], name: str) -> Array:
    """Return a measure of each row; NaN for walks that did not finish, for `FINISHED` for those that did not begin."""
    if name == FINISHED:
        return np.array([None if never_began(row) else row["outcome"] == FINISHED for row in rows], dtype=float)
    return np.array([row[name] if row["outcome"] == FINISHED else None for row in rows], dtype=float)


def never_began(row: Row) -> bool:
    """Whether an error kept a walk from its first step, so that the walk tells nothing of the controller."""
    return row["outcome"] == FAILED and row.get("steps") is None


def known_of(values: Array) -> Array:
    """Leave NaN out."""
    return values[~np.isnan(values)]


def middle(values: Array, name: str) -> float:
    """Median of a measure, or the share of walks that finished; NaN without values."""
    known = known_of(values)
    return math.nan if not known.size else float(np.mean(known) if name == FINISHED else np.median(known))


def measured(bins: Sequence[Array], name: str) -> Array:
    """Middle, quartiles and number of known values of a measure in bins, shape (4, bins).

    The quartiles of a share are the share itself.
    """
    found = []
    for known in map(known_of, bins):
        mean = middle(known, name)
        ends = [mean, mean] if name == FINISHED or not known.size else np.quantile(known, (0.25, 0.75)).tolist()
        found.append([mean, *ends, known.size])
    return np.array(found).T


def grouped(rows: Sequence[Row], names: Sequence[str], label: Callable[[str, object], str] = value_label) -> Axis:
    """Make a bin for each combination of values in some columns, in order of appearance; one bin for no columns."""
    keys = [tuple(row[name] for name in names) for row in rows]
    kinds = list(dict.fromkeys(keys))
    places = {kind: i for i, kind in enumerate(kinds)}
    ticks = tuple(", ".join(filter(None, map(label, names, kind))) for kind in kinds)
    words, edges = ", ".join(map(parameter_label, names)), np.arange(len(kinds) + 1.0)
    return Axis("_".join(names), words, np.array([places[key] for key in keys]), edges, edges[:-1], ticks)


def arranged(rows: Sequence[Row], shown: Sequence[str]) -> tuple[list[Axis], Axis]:
    """Choose what the figures of a study show, and bin it.

    Args:
        rows: Rows of the table.
        shown: Names of the varied columns, the most important first; random seeds are left out.

    Returns:
        Bins of up to three numeric columns, to be axes, and the groups of walks that the other columns tell apart; the
        name of the groups is empty where there are no other columns.
    """
    varied = [name for name in shown if not name.endswith(".seed")]
    numeric = [name for name in varied if is_numeric(rows, name)]
    named = [name for name in varied if name not in numeric]
    groups = grouped(rows, named)
    while groups.count > (_MOST_GROUPS if numeric else _MOST_LISTED):
        named.pop()
        groups = grouped(rows, named)
    numeric = numeric[:_MOST_PARAMETERS]
    each = len(rows) / groups.count / _WALKS_IN_BIN
    most = int(np.clip(each if len(numeric) == 1 else math.sqrt(each), _FEWEST_BINS, MOST_VALUES))
    return [binned(rows, name, most) for name in numeric], groups


@dataclass(frozen=True)
class Drawing:
    """A figure of a study, before it is drawn by any library.

    Attributes:
        kind: "map", "line", "groups" or "histograms".
        name: Name of its file.
        axes: Both axes of a map, the axis of lines, or the groups; none of histograms.
        groups: Groups of walks, a map or a line for each; one group where the axis is the groups.
        measures: By measure what `measured` finds, shape (groups, 4, bins), of a map (groups, 4, y, x); of histograms
            the known values.
    """

    kind: str
    name: str
    axes: Sequence[Axis]
    groups: Axis
    measures: Mapping[str, Array]


def drawings(rows: Sequence[Row], shown: Sequence[str], measures: Sequence[str]) -> Iterator[Drawing]:
    """Prepare the figures of a study: maps over pairs of parameters, lines over one, groups or histograms over none.

    Args:
        rows: Rows of the table, at least one.
        shown: Names of the varied columns, the most important first.
        measures: Names of the measures.
    """
    axes, groups = arranged(rows, shown)
    kind = "map" if len(axes) > 1 else "line" if axes else "groups" if groups.name else "histograms"
    if kind == "histograms":
        known = [name for name in measures if name != FINISHED] or [COST]
        yield Drawing(kind, kind, (), groups, {name: known_of(values_of(rows, name)) for name in known})
        return
    if kind == "groups":
        axes, groups = [groups], grouped(rows, [])
    for part in combinations(axes, 2) if kind == "map" else [axes]:
        found = {}
        for name in measures:
            values, spreads = values_of(rows, name), []
            for k in range(groups.count):
                bins = [[axis.within(i, groups.bin == k) for i in range(axis.count)] for axis in reversed(part)]
                spread = measured([values[np.logical_and.reduce(each)] for each in product(*bins)], name)
                spreads.append(spread.reshape(4, *map(len, bins)))
            found[name] = np.array(spreads)
        yield Drawing(kind, "_".join((kind, *(axis.name for axis in part))), part, groups, found)


def is_numeric(rows: Sequence[Row], name: str) -> bool:
    """Whether a column holds numbers and nothing else."""
    return all(isinstance(row[name], float | int | None) for row in rows)


def binned(rows: Sequence[Row], name: str, most: int) -> Axis:
    """Bin a numeric parameter: one bin for each value where they are few, else bins of equal width or ratio.

    Args:
        rows: Rows of the table.
        name: Name of the parameter's column.
        most: Number of bins where the values are many.
    """
    values = np.array([row[name] for row in rows], dtype=float)
    there = ~np.isnan(values)
    unique = np.unique(values[there])
    log = _is_geometric(unique)
    if len(unique) <= MOST_VALUES:
        place = np.where(there, np.searchsorted(unique, values), -1)
        ticks = tuple(f"{value:.4g}" for value in unique.tolist())
        return Axis(name, parameter_label(name), place, np.arange(len(unique) + 1.0), unique, ticks, log)
    low, high = float(unique[0]), float(unique[-1])
    edges = np.geomspace(low, high, most + 1) if log else np.linspace(low, high, most + 1)
    at = np.sqrt(edges[:-1] * edges[1:]) if log else (edges[:-1] + edges[1:]) / 2.0
    place = np.where(there, np.clip(np.searchsorted(edges, values, side="right") - 1, 0, most - 1), -1)
    return Axis(name, parameter_label(name), place, edges, at, (), log)


def _is_geometric(values: Array) -> bool:
    """Whether values in ascending order, such as draws, lie more evenly on a logarithmic scale than on a linear one."""
    if len(values) < 3 or not values[-1] > 3.0 * values[0] > 0.0:
        return False
    low, middle, high = values[0], float(np.median(values)), values[-1]
    return bool(abs(middle / math.sqrt(low * high) - 1.0) < abs(2.0 * middle / (low + high) - 1.0))
