"""Walking in the hybrid engine: integrate, find the first event, apply its reset map.

The functions are plain Python, called as such for a controller in plain Python, and compiled by
`mjbiped.numerics.machine` for one that gives its laws as functions.
"""

from __future__ import annotations

import math

from mjbiped.disturbances.chance import following
from mjbiped.dynamics.integrate import STAGES
from mjbiped.dynamics.modes import FREE, RESTING
from mjbiped.engines.hybrid import guards, impacts
from mjbiped.engines.hybrid.accounting import accumulate, note_peaks, take_sample
from mjbiped.engines.hybrid.meeting import FACE_IMPACT, NOTHING, OVER_THE_TOP, TOUCHDOWN, foot_over_ground
from mjbiped.engines.hybrid.motion import (
    attempt,
    carry_over,
    enter_mode,
    is_motion,
    note_ground_force,
    note_impact,
    start_step,
    take_angles,
)
from mjbiped.engines.hybrid.resets import lands, stands_still, transfer_support
from mjbiped.engines.hybrid.state import (
    Constants,
    State,
    constants_at,
    from_memory,
    pushes_at,
    state_at,
    to_memory,
    touches,
)
from mjbiped.numerics.blocks import call, call_for_float, numbers, row
from mjbiped.rules.termination import Outcome

DIVERGED, FELL, LEFT_TERRAIN = int(Outcome.DIVERGED), int(Outcome.FELL), int(Outcome.LEFT_TERRAIN)
STALLED, UNRESOLVED, WALKING = int(Outcome.STALLED), int(Outcome.UNRESOLVED), int(Outcome.WALKING)
CAUTION, LEAST, GREATEST = 0.8, 0.2, 1.5  # of a step's change of length; measured: few steps are rejected
# error thresholds below which the length may grow at its full rate, or is kept
FULL, KEPT = (CAUTION / GREATEST) ** 8, CAUTION**8
JUST_BESIDE = 2.3e-16  # next to a discontinuity's time, relative
SLIDING_STEP = 2e-3  # longest integration step while a surface pushes the swing foot, s
NOW = 1e-9  # times so close are the same, s


def advance(c: Constants, w: State) -> None:
    """Walk until the outcome is decided, the buffers have no room for one more step, or `w.pause` is reached.

    After a pause the next call goes on where this one stopped, be it in the middle of a gait step: the walk is bitwise
    the same, however often it pauses.

    Args:
        c: Constants of the walk.
        w: State; `w.outcome` says in the end whether the walk is over.
    """
    room = c.sample_room - 1
    if math.isfinite(c.sample_period):
        room -= int(c.stall_time / c.sample_period) + 2
    while w.outcome == WALKING and w.rows < c.row_room and w.samples <= room and w.evaluations < w.pause:
        if gait_step(c, w):
            transfer_support(c, w)
    if w.outcome != WALKING:
        take_sample(c, w, w.time, w.time - w.clock, numbers(w.y, c.size))


def advance_at(c: int, w: int) -> None:
    """`advance` for C: its arguments are addresses."""
    advance(constants_at(c, 0), state_at(w, 0))


def gait_step(c: Constants, w: State) -> bool:
    """Move from just after a support transfer to the next touchdown; whether there was one. The state is then in `w.y`.

    Where there was none, the outcome is decided, or the engine pauses.
    """
    if not w.under_way:
        w.elapsed = 0.0
        _look_ahead(c, w)
        begin(c, w)
        guards.watch(w)
        w.next_step = min(w.next_step, w.first_step)
    here = foot_over_ground(c, w, numbers(w.y, c.size))
    while _goes_on(c, w):
        h = _step_length(c, w)
        last = h == w.limit - w.elapsed
        error = attempt(c, w, h)
        if not error <= 1.0:
            _shorten(c, w, h, error)
            continue
        _lengthen(c, w, h, error)
        there = foot_over_ground(c, w, numbers(w.out, c.size))
        event, length = guards.first_event(c, w, h, here, there)
        if event != NOTHING and not is_motion(c, numbers(w.out, c.size)):  # between the stages the law may return NaN
            w.outcome, w.time = DIVERGED, w.clock + w.elapsed
            return False
        if not accumulate(c, w, length):
            w.outcome = DIVERGED
        _move(c, w, w.limit if last and length == h else w.elapsed + length)
        if event == NOTHING and w.elapsed < w.limit and w.outcome == WALKING:
            carry_over(c, w)
            here = there
            continue
        if w.outcome == WALKING and _reset(c, w, event):
            w.under_way = False
            return True
        if w.outcome == WALKING:
            begin(c, w)
            here = foot_over_ground(c, w, numbers(w.y, c.size))
    return False


def _goes_on(c: Constants, w: State) -> bool:
    """Whether the gait step goes on: the walk has not ended, makes progress, and need not pause."""
    if w.outcome != WALKING:
        return False
    if w.evaluations < w.look and w.evaluations < w.pause:
        return True
    if w.evaluations >= w.look and guards.lags(c, w):
        w.outcome, w.time = UNRESOLVED, w.clock + w.elapsed
        return False
    return bool(w.evaluations < w.pause)


def _step_length(c: Constants, w: State) -> float:
    """Length of the next integration step, s: at most up to the time at which the law is no longer smooth."""
    whole = w.limit - w.elapsed
    step = min(w.next_step, SLIDING_STEP if touches(w) else c.longest_step)
    w.next_step = step
    if step < 0.5 * whole:
        return float(step)
    return float(0.5 * whole if step < whole else whole)


def _shorten(c: Constants, w: State, h: float, error: float) -> None:
    """Shorten the step of length h that was rejected; the walk ends if it could hardly be shorter."""
    step = h * (max(LEAST, CAUTION * _eighth_root(1.0 / error)) if error > 1.0 else LEAST)
    if step < guards.SHORTEST_STEP or not is_motion(c, numbers(w.y, c.size)):
        w.outcome = UNRESOLVED if math.isfinite(error) and guards.is_tame(c, w) else DIVERGED
        w.time = w.clock + w.elapsed
    if w.elapsed == 0.0:
        w.first_step = step
    w.next_step = step


def _lengthen(c: Constants, w: State, h: float, error: float) -> None:
    """Choose the next length after a step of length h that was accepted."""
    if error < FULL or (error < KEPT and h >= c.longest_step):  # the rule below would give the same
        grown = GREATEST * h
    else:
        grown = CAUTION * h * _eighth_root(1.0 / error)
    w.next_step = max(w.next_step, grown) if h < w.next_step else grown
    if w.elapsed == 0.0:
        w.first_step = max(w.first_step, grown)


def _eighth_root(x: float) -> float:
    return math.sqrt(math.sqrt(math.sqrt(x)))


def _move(c: Constants, w: State, elapsed: float) -> None:
    """Make the step's end the state, at a time since the support transfer, s."""
    w.elapsed, w.time = elapsed, w.clock + elapsed
    y, out = numbers(w.y, c.size), numbers(w.out, c.size)
    for i in range(c.size):
        y[i] = out[i]


def _reset(c: Constants, w: State, event: int) -> bool:
    """Apply the reset map of an event, which may end the walk; whether the support transfer follows."""
    if event == TOUCHDOWN:
        if stands_still(c, w):
            return False
        if lands(c, w):
            return not impacts.set_down(c, w)
        impacts.stub(c, w)
    elif event == guards.FOOT_DOWN:
        impacts.lay_down(c, w)
        return True
    elif event == FACE_IMPACT:
        impacts.hit_face(c, w)
    elif event == guards.KNEE_STRIKE:
        impacts.strike_knee(c, w)
        if w.sliding and lands(c, w):  # a straight leg that stands on the ground ahead
            return True
        _look_ahead(c, w)
    elif event in (OVER_THE_TOP, guards.FOOT_RELEASED):
        impacts.release_foot(c, w, event == OVER_THE_TOP)
    elif event == guards.KNEE_RELEASED:
        w.locked = FREE
        enter_mode(c, w)
    elif event == guards.EDGE:
        impacts.slide_on(c, w)
    elif event == guards.FOOT_FLAT:
        impacts.lay_flat(c, w)
    elif event == guards.FALLEN:
        w.outcome = FELL
    elif event == guards.BEYOND_END:
        w.outcome = LEFT_TERRAIN
    elif w.elapsed >= c.stall_time:
        w.outcome = STALLED
    elif event != guards.FOOT_TIPS:  # which `begin` sees
        _look_ahead(c, w)
    return False


def begin(c: Constants, w: State) -> None:
    """Compute rates, torques and forces of a state that no step has led to, and forces of an impact before it."""
    start_step(c, w)
    if w.locked == RESTING and w.stop_press < 0.0:
        w.locked = FREE
        enter_mode(c, w)
        start_step(c, w)
    if c.toe > 0.0 and numbers(w.margins, 1)[0] < 0.0:
        impacts.tip_over(c, w)
        start_step(c, w)
    note_peaks(c, w, 0)
    note_ground_force(c, w, numbers(w.y, c.size), row(w.k, 0, c.size))
    note_impact(c, w)


def _look_ahead(c: Constants, w: State) -> None:
    """Find the time of the next discontinuity of the law, at which an integration step has to end.

    Controller ticks, and beginnings and ends of pushes, that are due now take place first.
    """
    t = w.elapsed
    y, memory = numbers(w.y, c.size), numbers(w.memory, c.states)
    to_memory(c, w, y)
    time = w.clock + t
    if time > w.next_tick - NOW:
        w.next_tick += c.control_period
        # a step that ends at a tick is short by design: `progress` does not count it
        w.step_started += STAGES
        w.look += STAGES
        take_angles(c, w, y)
        call(c.tick, c.parameters, memory, t, numbers(w.told, c.told), numbers(w.told_rates, c.told))
        from_memory(c, w)
    if time > w.next_push - NOW:
        _begin_or_end_push(c, w)
    event = min(w.next_tick, w.next_push) - w.clock
    there = min(call_for_float(c.next_discontinuity, c.parameters, memory, t), event)
    if not there > t:
        there = math.inf
    w.after = t * (1.0 + JUST_BESIDE)
    w.before = there * (1.0 - JUST_BESIDE)
    w.limit = min(there, c.stall_time)


def _begin_or_end_push(c: Constants, w: State) -> None:
    """A push of constant force begins, or ends."""
    pushes = pushes_at(c.pushes, 0)
    if not w.pushing:
        w.pushing, w.push = True, w.push_impulse / pushes.duration
        w.next_push += pushes.duration
        return
    w.pushing, w.push = False, 0.0
    w.pushes += 1
    w.next_push, w.push_impulse = following(pushes, int(w.pushes), w.next_push)
