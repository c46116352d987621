"""Comparison of a study's values: measures of the walks with each of them, and the best combination of a grid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.sweeps.bins import MOST_VALUES, SHOWN, binned, grouped, is_numeric, middle, values_of
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.plan import FINISHED, Study

_COST = "cost_of_transport"


def by_value(rows: Sequence[Row], study: Study) -> dict[str, list[dict[str, Any]]]:
    """Share of walks that finished and medians of those, for each value of each quantity that varies but random seeds.

    Returns:
        For each quantity's name a list with an entry for each value, or for each of some ranges where there are many:
        `value` as text, the number of `walks`, and the study's measures, None where no walk has one.
    """
    columns = {name: values_of(rows, name) for name in study.plot_measures or SHOWN}

    def entry(value: str, chosen: NDArray[np.bool_]) -> dict[str, Any]:
        medians = {name: middle(values[chosen], name) for name, values in columns.items()}
        known = {name: None if math.isnan(median) else median for name, median in medians.items()}
        return {"value": value, "walks": int(chosen.sum()), **known}

    return {
        name: [entry(value, chosen) for value, chosen in _split(rows, name) if chosen.any()]
        for name in _compared(study)
    }


def _split(rows: Sequence[Row], name: str) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """The values of a column as texts, or its ranges where there are many numbers, and which rows have each of them."""
    if is_numeric(rows, name):
        axis = binned(rows, name, MOST_VALUES // 2)
        for k, (low, high) in enumerate(pairwise(axis.edges)):
            yield axis.ticks[k] if axis.ticks else f"{low:.3g} to {high:.3g}", axis.bin == k
        return
    values = [row[name] for row in rows]
    for value in dict.fromkeys(values):
        yield "(has none)" if value is None else str(value), np.array([each == value for each in values])


def best(rows: Sequence[Row], study: Study) -> dict[str, Any] | None:
    """Find the combination of a grid's values of which most walks finish, and of several such the cheapest.

    Returns:
        The combination in words, its values by name, the number of its walks, the share that finished, the median cost
        of transport of those, and the first cell; None where nothing varies but what is drawn, or nothing finished.
    """
    names = [name for name in _compared(study) if name not in study.drawn]
    groups = grouped(rows, names)
    finished, costs = values_of(rows, FINISHED), values_of(rows, _COST)
    chosen = [groups.bin == k for k in range(groups.count)]
    ranked = [(-float(finished[each].mean()), middle(costs[each], _COST), k) for k, each in enumerate(chosen)]
    share, cost, k = min((rank for rank in ranked if not math.isnan(rank[1])), default=(0.0, 0.0, -1))
    if k < 0 or not names:
        return None
    first = rows[int(chosen[k].argmax())]
    return {
        "combination": groups.ticks[k],
        "values": {name: first[name] for name in names},
        "walks": int(chosen[k].sum()),
        FINISHED: -share,
        _COST: cost,
        "first_cell": first["cell"],
    }


def _compared(study: Study) -> list[str]:
    """Names of what varies, but seeds."""
    return [name for name in study.varied if not name.endswith(".seed")]
