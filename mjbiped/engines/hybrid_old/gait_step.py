"""Walking in the hybrid engine: integrate, find the first event, apply its reset map.

The functions are plain Python, called as such for a controller in plain Python, and compiled by `mjbiped.numerics.jit`
for one that gives its laws as functions.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.disturbances.pushes import following
from mjbiped.engines.hybrid import dynamics
from mjbiped.engines.hybrid.accounting import accumulate, note_peaks, take_sample
from mjbiped.engines.hybrid.dynamics import attempt, carry_over, is_motion
from mjbiped.engines.hybrid.events import (
    BEYOND_END,
    EDGE,
    FACE_IMPACT,
    FALLEN,
    FOOT_FLAT,
    FOOT_RELEASED,
    FOOT_TIPS,
    KNEE_RELEASED,
    KNEE_STRIKE,
    NOTHING,
    OVER_THE_TOP,
    SHORTEST_STEP,
    TOUCHDOWN,
    first_event,
    foot_over_ground,
)
from mjbiped.engines.hybrid.forces import note_ground_force, note_impact
from mjbiped.engines.hybrid.progress import is_tame, lags, watch
from mjbiped.engines.hybrid.state import Laws, Walk, hand_over, pose_of
from mjbiped.engines.hybrid.transfer import (
    hit_face,
    lands,
    lay_flat,
    release_foot,
    slide_on,
    stands_still,
    strike_knee,
    stub,
    tip_over,
    transfer_support,
)
from mjbiped.numerics.dormand_prince import STAGES
from mjbiped.robots.equations import FREE, RESTING
from mjbiped.rules.termination import Outcome

DIVERGED, FELL, LEFT_TERRAIN, STALLED, UNRESOLVED, WALKING = (
    int(outcome)
    for outcome in (
        Outcome.DIVERGED,
        Outcome.FELL,
        Outcome.LEFT_TERRAIN,
        Outcome.STALLED,
        Outcome.UNRESOLVED,
        Outcome.WALKING,
    )
)
CAUTION, LEAST, GREATEST = 0.8, 0.2, 1.5  # of a step's change of length; measured: few steps are rejected
# error thresholds below which the length may grow at its full rate, or is kept
FULL, KEPT = (CAUTION / GREATEST) ** 8, CAUTION**8
JUST_BESIDE = 2.3e-16  # next to a discontinuity's time, relative
SLIDING_STEP = 2e-3  # longest integration step while the foot slides on a face or on the ground, s
NOW = 1e-9  # times so close are the same, s


def advance(laws: Laws, law: Any, c: Any, w: Any) -> None:
    """Walk until the outcome is decided, the buffers have no room for one more step, or `w.pause` is reached.

    After a pause the next call goes on where this one stopped, be it in the middle of a gait step: the walk is bitwise
    the same, however often it pauses.

    Args:
        laws: The functions of the walk.
        law: What the controller's functions take.
        c: Robot, rules and limits.
        w: State; `w.outcome` says in the end whether the walk is over.
    """
    s = Walk(laws, law, c, w)
    tables = laws.tables(c.tables)
    room = len(tables.samples) - 1
    if math.isfinite(c.sample_period):
        room -= int(c.stall_time / c.sample_period) + 2
    while w.outcome == WALKING and w.rows < len(tables.rows) and w.samples <= room and w.evaluations < w.pause:
        if gait_step(s):
            transfer_support(s)
    if w.outcome != WALKING:
        take_sample(s, w.time, w.time - w.clock, w.y)


def gait_step(s: Walk) -> bool:
    """Move from just after a support transfer to the next touchdown; whether there was one. The state is then in `w.y`.

    Where there was none, the outcome is decided, or the engine pauses.
    """
    w = s.w
    if not w.under_way:
        w.elapsed = 0.0
        _look_ahead(s)
        begin(s)
        watch(w)
        w.next_step = min(w.next_step, w.first_step)
    here = foot_over_ground(s, pose_of(s, w.y))
    while _goes_on(s):
        h = _step_length(s)
        last = h == w.limit - w.elapsed
        error = attempt(s, h)
        if not error <= 1.0:
            _shorten(s, h, error)
            continue
        _lengthen(s, h, error)
        pose = pose_of(s, w.out)
        there = foot_over_ground(s, pose)
        event, length = first_event(s, h, here, there, pose)
        if event != NOTHING:
            if not is_motion(s, w.out):  # between the stages the law may return NaN
                w.outcome, w.time = DIVERGED, w.clock + w.elapsed
                return False
            pose = pose_of(s, w.out)
        if not accumulate(s, pose, length):
            w.outcome = DIVERGED
        _move(s, w.limit if last and length == h else w.elapsed + length)
        if event == NOTHING and w.elapsed < w.limit and w.outcome == WALKING:
            carry_over(w)
            here = there
            continue
        if w.outcome == WALKING and _reset(s, event):
            w.under_way = False
            return True
        if w.outcome == WALKING:
            begin(s)
            here = foot_over_ground(s, pose_of(s, w.y))
    return False


def _goes_on(s: Walk) -> bool:
    """Whether the gait step goes on: the walk has not ended, makes progress, and need not pause."""
    w = s.w
    if w.outcome != WALKING:
        return False
    if w.evaluations < w.look and w.evaluations < w.pause:
        return True
    if w.evaluations >= w.look and lags(s):
        w.outcome, w.time = UNRESOLVED, w.clock + w.elapsed
        return False
    return bool(w.evaluations < w.pause)


def _step_length(s: Walk) -> float:
    """Length of the next integration step, s: at most up to the time at which the law is no longer smooth."""
    w = s.w
    whole = w.limit - w.elapsed
    step = min(w.next_step, SLIDING_STEP if w.face != 0.0 or w.sliding else s.c.longest_step)
    w.next_step = step
    if step < 0.5 * whole:
        return float(step)
    return float(0.5 * whole if step < whole else whole)


def _shorten(s: Walk, h: float, error: float) -> None:
    """Shorten the step of length h that was rejected; the walk ends if it could hardly be shorter."""
    w = s.w
    step = h * (max(LEAST, CAUTION * _eighth_root(1.0 / error)) if error > 1.0 else LEAST)
    if step < SHORTEST_STEP or not is_motion(s, w.y):
        w.outcome = UNRESOLVED if math.isfinite(error) and is_tame(s) else DIVERGED
        w.time = w.clock + w.elapsed
    if w.elapsed == 0.0:
        w.first_step = step
    w.next_step = step


def _lengthen(s: Walk, h: float, error: float) -> None:
    """Choose the next length after a step of length h that was accepted."""
    w = s.w
    if error < FULL or (error < KEPT and h >= s.c.longest_step):  # the rule below would give the same
        grown = GREATEST * h
    else:
        grown = CAUTION * h * _eighth_root(1.0 / error)
    w.next_step = max(w.next_step, grown) if h < w.next_step else grown
    if w.elapsed == 0.0:
        w.first_step = max(w.first_step, grown)


def _eighth_root(x: float) -> float:
    return math.sqrt(math.sqrt(math.sqrt(x)))


def _move(s: Walk, elapsed: float) -> None:
    """Make the step's end the state, at a time since the support transfer, s."""
    w = s.w
    w.elapsed, w.time = elapsed, w.clock + elapsed
    for i in range(len(w.y)):
        w.y[i] = w.out[i]


def _reset(s: Walk, event: int) -> bool:
    """Apply the reset map of an event, which may end the walk; whether the support transfer follows."""
    w = s.w
    if event == TOUCHDOWN:
        if stands_still(s):
            return False
        if lands(s):
            return True
        stub(s)
    elif event == FACE_IMPACT:
        hit_face(s)
    elif event == KNEE_STRIKE:
        strike_knee(s)
        if w.sliding and lands(s):  # a straight leg that stands on the ground ahead
            return True
        _look_ahead(s)
    elif event in (OVER_THE_TOP, FOOT_RELEASED):
        release_foot(s, event == OVER_THE_TOP)
    elif event == KNEE_RELEASED:
        w.locked = FREE
    elif event == EDGE:
        slide_on(s)
    elif event == FOOT_FLAT:
        lay_flat(s)
    elif event == FALLEN:
        w.outcome = FELL
    elif event == BEYOND_END:
        w.outcome = LEFT_TERRAIN
    elif w.elapsed >= s.c.stall_time:
        w.outcome = STALLED
    elif event != FOOT_TIPS:  # which `begin` sees
        _look_ahead(s)
    return False


def begin(s: Walk) -> None:
    """Compute rates, torques and forces of a state that no step has led to, and forces of an impact before it."""
    w = s.w
    dynamics.begin(s)
    if w.locked == RESTING and w.stop_press < 0.0:
        w.locked = FREE
        dynamics.begin(s)
    if s.c.toe > 0.0 and w.margins[0] < 0.0:
        tip_over(s)
        dynamics.begin(s)
    note_peaks(w, 0)
    note_ground_force(s, pose_of(s, w.y), w.y, len(w.strike_q))
    note_impact(s)


def _look_ahead(s: Walk) -> None:
    """Find the time of the next discontinuity of the law, at which an integration step has to end.

    Controller ticks, and beginnings and ends of pushes, that are due now take place first.
    """
    w, t = s.w, s.w.elapsed
    hand_over(s, w.y)
    time = w.clock + t
    if time > w.next_tick - NOW:
        w.next_tick += s.c.control_period
        # a step that ends at a tick is short by design: `progress` does not count it
        w.step_started += STAGES
        w.look += STAGES
        s.laws.tick(s.law, w.memory, t, s.laws.told(s.laws.q(w.y)), s.laws.told_rates(s.laws.dq(w.y)))
    if time > w.next_push - NOW:
        _begin_or_end_push(s)
    event = min(w.next_tick, w.next_push) - w.clock
    there = min(s.laws.next_discontinuity(s.law, w.memory, t), event)
    if not there > t:
        there = math.inf
    w.after = t * (1.0 + JUST_BESIDE)
    w.before = there * (1.0 - JUST_BESIDE)
    w.limit = min(there, s.c.stall_time)


def _begin_or_end_push(s: Walk) -> None:
    """A push of constant force begins, or ends."""
    w, pushes = s.w, s.laws.tables(s.c.tables).pushes
    if not w.pushing:
        w.pushing, w.push = True, w.push_impulse / pushes.duration
        w.next_push += pushes.duration
        return
    w.pushing, w.push = False, 0.0
    w.pushes += 1
    w.next_push, w.push_impulse = following(pushes, int(w.pushes), w.next_push)
