"""The controller's ticks: torques that motors hold, their work, pushes, the stance knee, and the rows of the record.

Rows have the columns of `mjbiped.records.columns` in their order.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from mjbiped.disturbances.chance import following
from mjbiped.dynamics.modes import bent_leg
from mjbiped.engines.mujoco.constants import Constants, Leg, angles_of, pushes_at, stance_leg, swing_leg
from mjbiped.engines.mujoco.feet import least_normal_force, swing_foot_torque
from mjbiped.engines.mujoco.state import State, effective_step
from mjbiped.numerics.blocks import Floats, borrowed, call, call_for_float, first, give_back, numbers
from mjbiped.rules.sole import bounded
from mjbiped.rules.termination import Outcome


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


NOTHING_LEFT = 1e-12  # of a push's impulse: rounding
NOW = 1e-9  # times so close are the same, s
INTERRUPTED = float(Outcome.INTERRUPTED)
SPARE = 64  # floats behind torques and rates into which a law may write intermediate results


def control(c: Constants, u: State, time: float) -> None:
    """One tick of motors and controller at each new time; a second call at the same time changes nothing.

    Args:
        c: The walk's constants.
        u: State, after the observation of this time.
        time: Now, s.
    """
    if not time > u.asked:
        return
    u.asked = time
    ctrl, memory = numbers(c.ctrl, c.nu), borrowed(c.memory, c.memory_size)
    before, hold, foot = (u.torque[0], u.torque[1], u.torque[2]), u.hold, u.foot_torque
    if u.pushing or time > u.next_push - NOW:
        push(c, u)
        numbers(c.qfrc_applied, c.nq)[0] = u.push
    due = time > u.next_control - NOW
    if due:
        u.next_control += c.control_period
    if u.torque[0] != u.ankle:
        u.bound_time += u.effective_step
    if due or (u.transferred and u.outcome):  # the last touchdown is told at once: its row is whole
        _tick(c, u, memory)
        if numbers(c.failed, 1)[0] != 0.0:
            u.outcome = INTERRUPTED
            return
        give_back(c.memory, memory)
    # the force of the step before; that of an impact tells nothing of the step to come
    u.torque[0] = bounded(u.ankle, u.force if u.turns else 0.0, c.behind, c.ahead)
    if not u.outcome:
        for joint in range(c.angles):
            if abs(u.torque[joint]) > u.peak[joint]:
                u.peak[joint] = abs(u.torque[joint])
    drive(c, u, ctrl)
    if u.turns:
        count_work(c, u, before, hold, foot)
    if not u.over and (time > u.next_sample - NOW or u.outcome):
        u.next_sample = (math.floor(time / c.sample_period + NOW) + 1.0) * c.sample_period
        take_sample(c, u, memory)
    u.over = 1.0 if u.outcome else 0.0


def push(c: Constants, u: State) -> None:
    """The force of a push in the step from now on: constant, until its impulse has been given to the last bit.

    A force of a time acts from the middle of the step before to the middle of the step after (`step`): so the first
    one from the push's time on is the smaller, the later the push begins before it. The last one is what is left; where
    its step becomes another than planned, one more makes up for it.
    """
    pushes = pushes_at(c.pushes, 0)
    if u.pushing:
        u.push_left -= u.push * u.effective_step
        if abs(u.push_left) <= NOTHING_LEFT * abs(u.push_impulse):
            u.pushing = u.push = 0.0
            u.pushes += 1.0
            u.next_push, u.push_impulse = following(pushes, int(u.pushes), u.next_push + pushes.duration)
    begun = math.inf
    if not u.pushing and u.time > u.next_push - NOW:
        u.pushing, u.push_left = 1.0, u.push_impulse
        begun = u.time - u.next_push
    if u.pushing:
        force = u.push_impulse / pushes.duration
        step = effective_step(u, u.planned)
        if begun < step:
            force *= 0.5 + begun / step
        enough = abs(u.push_left) <= abs(force) * step
        u.push = u.push_left / step if enough else force


def _tick(c: Constants, u: State, memory: Floats) -> None:
    """One tick of the digital controller: its events and its law, whose torques and rates are held from now on."""
    n, row, rates = c.angles, numbers(c.row, c.row_width), numbers(c.rates, c.states)
    told, since = u.transferred != 0.0, u.time - u.ticked
    if told or u.strike_untold or c.sampled:
        since = 0.0  # the rates of the last tick are not those of the same motion
    u.ticked = u.time
    if u.strike_untold:
        u.strike_untold = 0.0
        call(c.knee_strike, c.parameters, memory, u.strike_time, first(u.struck_q, n), first(u.struck_rates, n))
    if u.transferred:
        u.transferred = 0.0
        row[c.estimate_at] = call_for_float(c.slope_estimate, c.parameters, memory)
        if c.support >= 0:
            memory[c.support], memory[c.support + 1] = u.support_behind, u.support_ahead
        # the contact switch holds the touchdown's posture and time for a controller that ticks later
        before, q, dq = first(u.told_before, n), first(u.told_q, n), first(u.told_dq, n)
        call(c.touchdown, c.parameters, memory, before, q, dq)
        row[c.estimate_at + 1] = call_for_float(c.slope_estimate, c.parameters, memory)
    q, dq, t = first(u.angles, n), first(u.turning, n), u.time - u.transfer_time
    if c.ticks:
        call(c.tick, c.parameters, memory, t, q, dq)
    given = numbers(c.room, n + c.states + SPARE)
    call(c.torque, c.parameters, memory, t, q, dq, given)
    if told and numbers(c.failed, 1)[0] == 0.0:
        keep_touchdown(c, u)
    for index in range(c.states):  # the rates of the last tick have acted all the time: now the mean of both does
        memory[index] += 0.5 * since * (given[n + index] - rates[index])
        rates[index] = given[n + index]
    for joint in range(n):
        u.torque[joint] = given[joint]
    if u.locked:
        u.torque[2] = 0.0
    u.ankle = u.torque[0]


def drive(c: Constants, u: State, ctrl: MutableSequence[float]) -> None:
    """Set the motors: of the stance leg's ankle, of the hip, and of the swing knee, which does nothing while locked."""
    stance, swing = stance_leg(c, u), swing_leg(c, u)
    if u.locked:
        u.torque[2] = 0.0
    for index in range(c.nu):
        ctrl[index] = 0.0
    ctrl[stance.ankle] = u.torque[0]
    if c.feet:
        u.foot_torque = swing_foot_torque(c, u)
        ctrl[swing.ankle] = u.foot_torque
    if c.hip >= 0:
        ctrl[c.hip] = -u.torque[1] if u.stance else u.torque[1]
    if swing.knee >= 0:
        ctrl[swing.motor] = u.torque[2]
    if c.knee_stiffness > 0.0:
        # the ankle's torque goes through the knee as well, as it acts on the shank
        u.hold = c.knee_stiffness * (u.q[stance.knee] - u.rest) + c.knee_damping * u.rates[stance.knee]
        ctrl[stance.motor] = u.torque[0] - u.hold
        u.peak_hold = max(u.peak_hold, abs(u.hold))


def count_work(c: Constants, u: State, before: tuple[float, float, float], hold: float, foot: float) -> None:
    """Work of the motors in the step that has led here: the mean of the torques at its ends times what was turned.

    In a leapfrog step's motion that is the work done: the torque of a time acts from the middle of the step before
    to the middle of the step after. The paper's power is τ1 q̇1 + τ2 (q̇2 - q̇1); the ground's slope does not change.

    Motors of a sampled controller hold their torque until the next tick, however much it changes there: that of a noisy
    one would lose half of its work in the mean.

    Args:
        c: The walk's constants.
        u: State, after the controller's tick.
        before: Torques that were held before it, N m.
        hold: Of the servo before it, N m.
        foot: Of the swing foot's servo before it, N m.
    """
    count = int(u.count)
    old1, old2, old3 = angles_of(c, u.old_q, count, u.old_tilt, 0.0)
    new1, new2, new3 = angles_of(c, u.q, count, u.tilt, 0.0)
    leg, swing, shank = new1 - old1, new2 - old2, new3 - old3
    thigh = leg
    if c.feet:
        leg -= u.slope - u.old_slope  # against the foot, which may tip
    if c.knee_stiffness > 0.0:  # ankle and hip turn against shank and thigh
        hip, knee = stance_leg(c, u).hip, stance_leg(c, u).knee
        thigh, flexed = u.q[hip] - u.old_q[hip], u.q[knee] - u.old_q[knee]
        leg = thigh + flexed
        work = -0.5 * (hold + u.hold) * flexed
        u.work_hold += abs(work)
        _add_work(u, work, 0.0, 0.0)
    ankle, hip_torque, knee_torque = before
    if not c.sampled:
        ankle, hip_torque = 0.5 * (ankle + u.torque[0]), 0.5 * (hip_torque + u.torque[1])
        knee_torque = 0.5 * (knee_torque + u.torque[2])
    _add_work(u, ankle * leg, hip_torque * (swing - thigh), knee_torque * (shank - swing))
    if c.feet:
        sole = swing_leg(c, u).sole
        _add_work(u, -0.5 * (foot + u.foot_torque) * (u.q[sole] - u.old_q[sole]), 0.0, 0.0)


def _add_work(u: State, ankle: float, hip: float, knee: float) -> None:
    u.work_absolute += abs(ankle) + abs(hip) + abs(knee)
    u.work_net += ankle + hip + knee
    u.work_positive += max(ankle, 0.0) + max(hip, 0.0) + max(knee, 0.0)


def lean_on(leg: Leg, u: State) -> None:
    """Note how the line from foot to hip stands of a stance leg whose knee gives."""
    flexion = u.q[leg.knee]
    reach, lean = bent_leg(leg.upper, leg.lower, flexion)
    u.reach, u.tilt = reach, flexion - lean
    u.share = leg.lower * (leg.lower + leg.upper * math.cos(flexion)) / (reach * reach)
