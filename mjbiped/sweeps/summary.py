"""A study in a few numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.records.measures import verdict
from mjbiped.sweeps.cell import FAILED, Row

SUMMARISED = (
    "cost_of_transport",
    "cost_of_transport_net",
    "speed_m_per_s",
    "peak_ankle_torque_Nm",
    "peak_hip_torque_Nm",
    "estimate_error_at_step_end_deg",
    "largest_stance_friction",
    "least_normal_force_weights",
    "pressure_ahead_m",
    "pressure_behind_m",
    "foot_length_99_percent_m",
)
QUANTILES = (0.05, 0.5, 0.95)

_SHOWN = 10  # kinds of errors


def summarised(rows: Sequence[Row]) -> dict[str, Any]:
    """Counts of outcomes and verdicts, quantiles of the measures of finished walks, and errors, in plain JSON types.

    Quantiles are None where no walk finished or none has the measure.
    """
    outcomes = Counter(row["outcome"] for row in rows)
    verdicts = Counter(verdict(row["outcome"], row["steps_violating_contact"]) for row in rows)
    finished = [row for row in rows if row["outcome"] == "finished"]
    quantiles: dict[str, list[float] | None] = {}
    for name in SUMMARISED:
        values = [row[name] for row in finished if row[name] is not None]
        quantiles[name] = np.quantile(values, QUANTILES).tolist() if values else None
    errors = Counter(row["error"] for row in rows if row["outcome"] == FAILED)
    first = {row["error"]: row["cell"] for row in reversed(rows)}
    return {
        "walks": len(rows),
        "outcomes": dict(outcomes.most_common()),
        "verdicts": dict(verdicts.most_common()),
        "quantiles": list(QUANTILES),
        "finished": quantiles,
        "errors": [
            {"error": error, "walks": count, "first_cell": first[error]} for error, count in errors.most_common(_SHOWN)
        ],
    }
