"""The paper's own numbers, tables II and III, as printed."""

from __future__ import annotations

import math
from collections.abc import Mapping

IMITATED_SLOPE = math.radians(2.0)
"""Slope of the imitated gait in every simulation of section V, rad."""

GROUNDS = ("level", "stair 1", "stair 2", "slope 1", "slope 2")

TREAD = 1.8
"""Depth of the treads of stair 1 and 2, m."""

SLOPE_LENGTH = 1.5
"""Length of the segments of slope 1 and 2, m."""

CHANGES: Mapping[str, float] = {"stair 1": 0.006, "stair 2": 0.06, "slope 1": 0.3, "slope 2": -1.0}
"""Height of a step (m) and change of slope (degrees), with the sign that the paper prints."""

TABLE_2: Mapping[str, Mapping[str, float | None]] = {
    "PBC": {"level": 0.0342, "stair 1": 0.0362, "stair 2": None, "slope 1": 0.0336, "slope 2": None},
    "ECC": {"level": 0.0352, "stair 1": 0.0361, "stair 2": None, "slope 1": 0.0338, "slope 2": 0.0353},
    "KETC": {"level": 0.0350, "stair 1": 0.0363, "stair 2": None, "slope 1": 0.0339, "slope 2": None},
    "adaptive": {"level": 0.0350, "stair 1": 0.0357, "stair 2": 0.0831, "slope 1": 0.0336, "slope 2": 0.0335},
}
"""c_mt by method and ground; None where the paper has an X (instability)."""

DIGITS = 4
"""Decimals of c_mt in the paper's tables."""


def meets(ours: float, paper: float) -> bool:
    """Whether a c_mt agrees with a printed one within half a unit of the last digit."""
    return abs(ours - paper) <= 0.5 * 10.0**-DIGITS


TABLE_3: Mapping[float | None, tuple[float, float]] = {
    None: (98.29, 0.1362),
    0.1: (1141.8, 1.1312),
    0.2: (330.4, 0.3343),
    0.3: (171.2, 0.2058),
    0.4: (112.4, 0.1691),
    0.5: (84.19, 0.1554),
    0.6: (68.48, 0.1486),
    0.7: (58.73, 0.1448),
    0.8: (52.13, 0.1438),
    0.9: (47.43, 0.1459),
    1.0: (46.42, 0.1742),
}
"""Greatest torque (N m) and c_mt by zeta; None: no re-planning."""
