"""Rows of the record as the hybrid engine writes them: one layout for all robots, of which each has its columns."""

from __future__ import annotations

from collections import namedtuple
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.dynamics.linkage import ROOM
from mjbiped.dynamics.modes import LOCKED
from mjbiped.engines.hybrid.state import Constants, State, hip, sole_angle
from mjbiped.numerics.blocks import Floats, call_for_float, numbers, row
from mjbiped.records.columns import tables_of
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot

POSTURE = 8
"""Room for a posture `qpos`."""


def _widths(table: str) -> dict[str, int]:
    """All columns of a table that some robot has, with the greatest of their widths."""
    widths: dict[str, int] = {}
    for kind in KINDS.values():
        for name, column in getattr(tables_of(kind), table).items():
            widths[name] = max(widths.get(name, 0), column.width)
    return widths


def _layout(table: str) -> Any:
    """Index of the first number of each column in a row that has all columns."""
    widths = _widths(table)
    firsts = np.cumsum([0, *widths.values()]).tolist()
    return namedtuple("Layout", [*widths, "width"])(*firsts)


TOUCHDOWN, SAMPLE = _layout("touchdowns"), _layout("samples")


@cache
def columns_of(kind: type[Robot], table: str) -> NDArray[np.int64]:
    """Which numbers of a row that has all columns are those of a kind of robot."""
    layout, own = (TOUCHDOWN if table == "touchdowns" else SAMPLE), getattr(tables_of(kind), table)
    return np.concatenate([getattr(layout, name) + np.arange(column.width) for name, column in own.items()])


def write_posture(c: Constants, w: State, y: Floats) -> None:
    """Write the posture `qpos` of a state into `w.posture`: hip, upper segments of both legs, what is below."""
    posture, offsets = numbers(w.posture, POSTURE), numbers(w.offsets, ROOM)
    left = w.stance if c.angles > 1 else 0
    posture[0], posture[1] = hip(c, w, y)
    standing = y[0] + offsets[0] + w.slope + c.between * w.count
    posture[2 + left] = standing
    if c.angles == 1:
        return
    swinging = y[1] + w.slope
    posture[3 - left] = swinging
    if c.foot >= 0:
        sole = y[c.foot] + w.slope
        posture[4 + left], posture[5 - left] = sole - standing, y[c.foot + 1] + w.slope - swinging
    else:
        posture[4 + left], posture[5 - left] = w.stance_flexion, y[c.shank] - y[c.thigh]


def estimated_slope(c: Constants, w: State) -> float:
    """The controller's estimate of the slope, rad."""
    return call_for_float(c.slope_estimate, c.parameters, numbers(w.memory, c.states))


def write_sample(c: Constants, w: State, time: float, y: Floats, asked: float) -> None:
    """Write a row of the samples.

    Args:
        c: The walk's constants.
        w: Its state; the torques that act stand in `w.sampled`.
        time: Since the start, s.
        y: State of motion, the controller's states behind it.
        asked: Torque that the ankle is asked for, N m.
    """
    to, tip = row(c.sample_buffer, w.samples, c.sample_width), sole_angle(c, y)
    given, posture = numbers(w.sampled, c.given), numbers(w.posture, POSTURE)
    write_posture(c, w, y)
    to[SAMPLE.time] = time
    for i in range(c.told):
        to[SAMPLE.q + i], to[SAMPLE.dq + i] = y[i] - tip, y[c.angles + i]
    for i in range(c.joints):
        to[SAMPLE.torque + i] = given[i]
    to[SAMPLE.ankle_asked] = asked
    to[SAMPLE.slope] = w.slope + tip
    to[SAMPLE.slope_estimate] = estimated_slope(c, w)
    to[SAMPLE.stance] = w.stance
    for i in range(6):
        to[SAMPLE.qpos + i] = posture[i]
    to[SAMPLE.locked] = 1.0 if w.locked == LOCKED else 0.0
    for i in range(c.states):
        to[SAMPLE.width + i] = y[2 * c.angles + i]


def write_touchdown(c: Constants, w: State, slope: float, dq_before: Floats, estimate_before: float) -> None:
    """Write the row of a touchdown.

    Args:
        c: The walk's constants.
        w: Its state after the support transfer; the posture of the touchdown stands in `posture`, the angles that the
            law was told before it in `told_before`, and those after it in `told` and `told_rates`.
        slope: Slope of the ground under the new stance foot, rad.
        dq_before: Rates before the impact, rad/s.
        estimate_before: The controller's estimate of the slope before the touchdown, rad.
    """
    to = row(c.row_buffer, w.rows, TOUCHDOWN.width)
    before, after, dq, posture = (
        numbers(w.told_before, c.told),
        numbers(w.told, c.told),
        numbers(w.told_rates, c.told),
        numbers(w.posture, POSTURE),
    )
    strike_q, strike_dq, struck_dq = numbers(w.strike_q, ROOM), numbers(w.strike_dq, ROOM), numbers(w.struck_dq, ROOM)
    for i in range(6):
        to[TOUCHDOWN.qpos + i] = posture[i]
    for i in range(c.told):
        to[TOUCHDOWN.q_before + i], to[TOUCHDOWN.dq_before + i] = before[i], dq_before[i]
        to[TOUCHDOWN.q + i], to[TOUCHDOWN.dq + i] = after[i], dq[i]
        to[TOUCHDOWN.knee_q + i], to[TOUCHDOWN.knee_dq_before + i] = strike_q[i], strike_dq[i]
        to[TOUCHDOWN.knee_dq + i] = struck_dq[i]
    to[TOUCHDOWN.time], to[TOUCHDOWN.stance], to[TOUCHDOWN.slope] = w.time, w.stance, slope
    to[TOUCHDOWN.x], to[TOUCHDOWN.z] = w.foot_x - c.height * w.sine, w.foot_z - c.height * w.cosine
    to[TOUCHDOWN.work_absolute], to[TOUCHDOWN.work_net] = w.work_absolute, w.work_net
    to[TOUCHDOWN.work_positive] = w.work_positive
    to[TOUCHDOWN.slip] = to[TOUCHDOWN.penetration] = 0.0
    to[TOUCHDOWN.friction], to[TOUCHDOWN.normal_force] = w.friction, w.normal_force
    to[TOUCHDOWN.strikes], to[TOUCHDOWN.stubs] = w.face_impacts, w.stubs
    to[TOUCHDOWN.slope_estimate_before], to[TOUCHDOWN.slope_estimate] = estimate_before, estimated_slope(c, w)
    pressure = numbers(w.pressure, 2)
    to[TOUCHDOWN.pressure_ahead], to[TOUCHDOWN.pressure_behind] = pressure[0], pressure[1]
    to[TOUCHDOWN.sole_bound_time] = w.bound_time
    to[TOUCHDOWN.knee_strike], to[TOUCHDOWN.flexion] = w.strike_time, w.flexion
    to[TOUCHDOWN.tipped], to[TOUCHDOWN.one_sided], to[TOUCHDOWN.slap] = w.tipped, w.one_sided, w.slap
    to[TOUCHDOWN.support_behind], to[TOUCHDOWN.support_ahead] = c.heel, c.toe
