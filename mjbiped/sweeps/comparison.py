"""Comparison of a study's values: measures of the walks with each of them, and the best combination of a grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mjbiped.sweeps.bins import MOST_VALUES, SHOWN, Axis, binned, grouped, is_numeric, middle, values_of
from mjbiped.sweeps.cell import Row
from mjbiped.sweeps.plan import FINISHED, Study

_COST = "cost_of_transport"


def by_value(rows: Sequence[Row], study: Study) -> dict[str, list[dict[str, Any]]]:
    """Share of walks that finished and medians of those, for each value of each quantity that varies but random seeds.

    Returns:
        For each quantity's name a list with an entry for each value, or for each of some ranges where there are many:
        `value` as text, the number of `walks`, and the study's measures, None where no walk has one.
    """
    measures = study.plot_measures or SHOWN
    columns = {name: values_of(rows, name) for name in measures}
    found = {}
    for name in _compared(study):
        numeric = is_numeric(rows, name)
        axis = binned(rows, name, MOST_VALUES // 2) if numeric else grouped(rows, [name])
        values = _values(axis) if numeric else _words(rows, name)
        entries = []
        for k, value in enumerate(values):
            chosen = axis.bin == k
            medians = {measure: _known(middle(columns[measure][chosen], measure)) for measure in measures}
            entries.append({"value": value, "walks": int(chosen.sum()), **medians})
        found[name] = [entry for entry in entries if entry["walks"]]
    return found


def best(rows: Sequence[Row], study: Study) -> dict[str, Any] | None:
    """Find the combination of a grid's values of which most walks finish, and of several such the cheapest.

    Returns:
        The combination in words, its values by name, the number of its walks, the share that finished, the median cost
        of transport of those, and the first cell; None where nothing varies but what is drawn, or nothing finished.
    """
    names = [name for name in _compared(study) if name not in study.drawn]
    if not names:
        return None
    groups = grouped(rows, names)
    finished, costs = values_of(rows, FINISHED), values_of(rows, _COST)
    ranked = []
    for k, words in enumerate(groups.ticks):
        chosen = groups.bin == k
        cost = middle(costs[chosen], _COST)
        if not math.isnan(cost):
            ranked.append((-float(finished[chosen].mean()), cost, k, words, chosen))
    if not ranked:
        return None
    share, cost, _, words, chosen = min(ranked, key=lambda entry: entry[:3])
    first = rows[int(chosen.argmax())]
    return {
        "combination": words,
        "values": {name: first[name] for name in names},
        "walks": int(chosen.sum()),
        FINISHED: -share,
        _COST: cost,
        "first_cell": first["cell"],
    }


def _compared(study: Study) -> list[str]:
    """Names of what varies, but seeds."""
    return [name for name in study.varied if not name.endswith(".seed")]


def _values(axis: Axis) -> list[str]:
    """The values or ranges of a numeric axis's bins as texts."""
    edges = zip(axis.edges[:-1], axis.edges[1:], strict=True)
    return list(axis.ticks) or [f"{low:.3g} to {high:.3g}" for low, high in edges]


def _words(rows: Sequence[Row], name: str) -> list[str]:
    """The values of a column in order of appearance, as `grouped` has them, as texts."""
    return ["(has none)" if value is None else str(value) for value in dict.fromkeys(row[name] for row in rows)]


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
