"""Summary of a study: outcomes, quantiles, measures by value, and the best combination of a grid."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.studies.bins import COST, MOST_VALUES, SHOWN, binned, grouped, is_numeric, known_of, middle, values_of
from mjbiped.studies.cell import FAILED, Row
from mjbiped.studies.plan import FINISHED, Study

SUMMARISED = (
    "cost_of_transport", "cost_of_transport_net", "speed_m_per_s", "peak_ankle_torque_Nm", "peak_hip_torque_Nm",
    "estimate_error_at_step_end_deg", "largest_stance_friction", "least_normal_force_weights", "pressure_ahead_m",
    "pressure_behind_m", "foot_length_99_percent_m",
)  # fmt: skip
QUANTILES = (0.05, 0.5, 0.95)

_ERRORS = 10  # kinds of them that are listed


def summarised(rows: Sequence[Row]) -> dict[str, Any]:
    """Count outcomes and errors, and take quantiles of the measures of finished walks, in plain JSON types.

    The `verdicts` are the outcomes, with finished walks in which steps violate the contact counted by themselves.
    Quantiles are None where no walk finished or none has the measure.
    """
    known = {name: known_of(values_of(rows, name)) for name in SUMMARISED}
    errors = Counter(row["error"] for row in rows if row["outcome"] == FAILED)
    first = {row["error"]: row["cell"] for row in reversed(rows)}
    return {
        "walks": len(rows),
        "outcomes": dict(Counter(row["outcome"] for row in rows).most_common()),
        "verdicts": dict(Counter(map(_verdict, rows)).most_common()),
        "quantiles": list(QUANTILES),
        "finished": {
            name: np.quantile(values, QUANTILES).tolist() if values.size else None for name, values in known.items()
        },
        "errors": [
            {"error": error, "walks": count, "first_cell": first[error]} for error, count in errors.most_common(_ERRORS)
        ],
    }


def _verdict(row: Row) -> str:
    violating = row["outcome"] == FINISHED and row["steps_violating_contact"]
    return f"{FINISHED}, contact violated" if violating else str(row["outcome"])


def by_value(rows: Sequence[Row], study: Study) -> dict[str, list[Row]]:
    """Share of walks that finished and medians of those, for each value of each quantity that varies but random seeds.

    Returns:
        For each quantity's name a list with an entry for each value, or for each of some ranges where there are many:
        `value` as text, the number of `walks`, and the study's measures, None where no walk has one.
    """
    columns = {name: values_of(rows, name) for name in study.plot_measures or SHOWN}

    def entry(value: str, chosen: NDArray[np.bool_]) -> Row:
        medians = {name: middle(values[chosen], name) for name, values in columns.items()}
        known = {name: None if math.isnan(median) else median for name, median in medians.items()}
        return {"value": value, "walks": int(chosen.sum()), **known}

    found = {}
    for name in _compared(study):
        axis = binned(rows, name, MOST_VALUES // 2) if is_numeric(rows, name) else grouped(rows, [name], _bare)
        entries = [entry(text, axis.bin == k) for k, text in enumerate(axis.texts)]
        found[name] = [each for each in entries if each["walks"]]
    return found


def _bare(_: str, value: object) -> str:
    return "(has none)" if value is None else str(value)


def best(rows: Sequence[Row], study: Study) -> Row | None:
    """Find the combination of a grid's values of which most walks finish, and of several such the cheapest.

    Returns:
        The combination in words, its values by name, the number of its walks, the share that finished, the median cost
        of transport of those, and the first cell; None where nothing varies but what is drawn, or nothing finished.
    """
    names = [name for name in _compared(study) if name not in study.drawn]
    groups = grouped(rows, names)
    finished, costs = values_of(rows, FINISHED), values_of(rows, COST)
    chosen = [groups.bin == k for k in range(groups.count)]
    ranked = [(-middle(finished[each], FINISHED), middle(costs[each], COST), k) for k, each in enumerate(chosen)]
    share, cost, k = min((rank for rank in ranked if not math.isnan(rank[1])), default=(0.0, 0.0, -1))
    if k < 0 or not names:
        return None
    first = rows[int(chosen[k].argmax())]
    return {
        "combination": groups.ticks[k],
        "values": {name: first[name] for name in names},
        "walks": int(chosen[k].sum()),
        FINISHED: -share,
        COST: cost,
        "first_cell": first["cell"],
    }


def _compared(study: Study) -> list[str]:
    """Names of what varies, but seeds."""
    return [name for name in study.varied if not name.endswith(".seed")]
