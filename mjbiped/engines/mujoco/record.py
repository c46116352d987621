"""Rows of a walk's record: touchdowns and samples, with the columns of `mjbiped.records.columns` in their order."""

from __future__ import annotations

import math

from mjbiped.engines.mujoco.bearing import least_normal_force
from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import Floats, call_for_float, numbers


def write_touchdown(c: Constants, u: State) -> None:
    """Write the touchdown that has just exchanged the legs; its slope estimates are not known yet."""
    row, n = numbers(c.row, c.row_width), c.angles
    row[0] = u.time
    at = _write_posture(c, u, row, 1)
    row[at] = u.foot_x - c.radius * math.sin(u.slope)
    row[at + 1] = u.foot_z - c.radius * math.cos(u.slope)
    row[at + 2], row[at + 3] = u.stance, u.slope
    at = _write(row, at + 4, u.told_before, n)
    at = _write(row, at, u.turning, n)
    at = _write(row, at, u.told_q, n)
    at = _write(row, at, u.told_dq, n)
    row[at], row[at + 1], row[at + 2] = u.work_absolute, u.work_net, u.work_positive
    row[at + 3], row[at + 4], row[at + 5], row[at + 6] = u.slip, u.penetration, u.friction, u.face_impacts
    row[at + 7] = row[at + 8] = math.nan
    row[at + 9] = least_normal_force(u)
    row[at + 10], row[at + 11], row[at + 12] = u.pressure[0], u.pressure[1], u.bound_time
    row[at + 13] = u.contact_force
    at += 14
    if n > 2:
        row[at] = u.strike_time
        at = _write(row, at + 1, u.strike_q, n)
        at = _write(row, at, u.strike_rates, n)
        at = _write(row, at, u.struck_rates, n)
        servo = c.knee_stiffness > 0.0
        row[at], row[at + 1] = u.flexion, u.stubs
        row[at + 2], row[at + 3] = u.peak_hold if servo else math.nan, u.work_hold if servo else math.nan
    if c.feet:
        row[at], row[at + 1], row[at + 2] = u.tipped, u.one_sided, u.time - u.touched
        row[at + 3], row[at + 4], row[at + 5] = u.support_behind, u.support_ahead, u.intrusion


def keep_touchdown(c: Constants, u: State) -> None:
    """Write down the last touchdown's row, whose estimates are known by now, if there is room."""
    index = int(u.rows)
    if 0 <= index < c.row_room:
        rows, row = numbers(c.rows, c.row_room * c.row_width), numbers(c.row, c.row_width)
        for column in range(c.row_width):
            rows[index * c.row_width + column] = row[column]
        u.rows += 1.0


def take_sample(c: Constants, u: State, memory: Floats) -> None:
    """Write down the state now, with the torque that is held from now on, if there is room and no law fails of it.

    Args:
        c: The walk's constants.
        u: State.
        memory: The controller's.
    """
    index, n = int(u.samples), c.angles
    if not 0 <= index < c.sample_room:
        return
    row, first = numbers(c.samples, c.sample_room * c.sample_width), index * c.sample_width
    row[first] = u.time
    at = _write(row, first + 1, u.angles, n)
    at = _write(row, at, u.turning, n)
    at = _write(row, at, u.torque, n)
    row[at], row[at + 1] = u.ankle, u.slope
    failed = numbers(c.failed, 1)[0]
    row[at + 2] = call_for_float(c.slope_estimate, c.parameters, memory)
    if numbers(c.failed, 1)[0] != failed:
        return
    row[at + 3] = u.stance
    at = _write_posture(c, u, row, at + 4)
    if n > 2:
        row[at], row[at + 1] = u.locked, u.hold if c.knee_stiffness > 0.0 else math.nan
        at += 2
    for state in range(c.states):
        row[at + state] = memory[state]
    u.samples += 1.0


def _write(row: Floats, at: int, values: Floats, count: int) -> int:
    """Write the first numbers of an array into a row; returns the index behind them."""
    for index in range(count):
        row[at + index] = values[index]
    return at + count


def _write_posture(c: Constants, u: State, row: Floats, at: int) -> int:
    """Write the robot's coordinates in the record's order; returns the index behind them."""
    order = numbers(c.order, c.nq)
    for index in range(c.nq):
        row[at + index] = u.q[int(order[index])]
    return at + int(c.nq)
