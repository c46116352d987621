"""Writes the rows of a walk's record, for every engine: in plain Python, or as part of compiled code.

The arguments are the columns of `mjbiped.records.columns` by their names; what two columns hold is a pair.
"""

from __future__ import annotations

from collections.abc import MutableSequence
from typing import Any, TypeAlias

from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, width

Pair: TypeAlias = tuple[float, float]
Posture: TypeAlias = tuple[float, float, float, float]

SAMPLED = width(SAMPLES)
"""Floats of a sample; the controller's integrated states stand behind them."""

TOUCHED = width(TOUCHDOWNS)
"""Floats of a touchdown."""


def write_sample(
    row: Any,
    time: float,
    q: Pair,
    dq: Pair,
    torque: Pair,
    slope: float,
    slope_estimate: float,
    stance: float,
    qpos: Posture,
) -> None:
    """Fill the first `SAMPLED` floats of a sample's row."""
    row[0] = time
    row[1], row[2] = q
    row[3], row[4] = dq
    row[5], row[6] = torque
    row[7] = slope
    row[8] = slope_estimate
    row[9] = stance
    row[10], row[11], row[12], row[13] = qpos


def write_touchdown(
    row: MutableSequence[float],
    first: int,
    time: float,
    qpos: Posture,
    x: float,
    z: float,
    stance: float,
    slope: float,
    q_before: Pair,
    dq_before: Pair,
    q: Pair,
    dq: Pair,
    work_absolute: float,
    work_net: float,
    work_positive: float,
    slip: float,
    penetration: float,
    friction: float,
    strikes: float,
    slope_estimate_before: float,
    slope_estimate: float,
    normal_force: float,
) -> None:
    """Fill the `TOUCHED` floats of a touchdown's row, from the index `first` on."""
    values = (
        time,
        *qpos,
        x,
        z,
        stance,
        slope,
        *q_before,
        *dq_before,
        *q,
        *dq,
        work_absolute,
        work_net,
        work_positive,
        slip,
        penetration,
        friction,
        strikes,
        slope_estimate_before,
        slope_estimate,
        normal_force,
    )
    for index in range(TOUCHED):
        row[first + index] = values[index]
