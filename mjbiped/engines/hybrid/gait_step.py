"""Walking in the hybrid engine: from one touchdown to the next, and the support transfer between.

The functions are plain Python, called as such for a controller in plain Python, and compiled by `mjbiped.numerics.jit`
for one that gives its laws as functions.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.disturbances.pushes import Pushes, following
from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.accounting import accumulate, note_ground_force, note_peaks, take_sample
from mjbiped.engines.hybrid.dynamics import attempt, begin, ensure_dense, is_motion
from mjbiped.engines.hybrid.events import (
    CORNER,
    FACE_IMPACT,
    KNEE_STRIKE,
    NOTHING,
    OVER_THE_TOP,
    TOUCHDOWN,
    body_ends,
    decided_by_ends,
    face_gap,
    first_event,
    foot_over_ground,
    landing,
    pose_within,
)
from mjbiped.engines.hybrid.impulses import momentum, note_impact, note_impulse
from mjbiped.engines.hybrid.progress import is_tame, lags, watch
from mjbiped.engines.hybrid.sliding import end_at_edge, end_of_contact, hit_face, on_its_segment, slides_on
from mjbiped.engines.hybrid.state import KNEE_FREE, KNEE_RESTING, Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import FACE_WIDTH, begin_step
from mjbiped.numerics.dormand_prince import STAGES
from mjbiped.rules.termination import FALLEN_HIP, Outcome
from mjbiped.terrain.profile import height_of, segment_stood_on

FINISHED, FELL, STALLED, LEFT_TERRAIN, DIVERGED, UNRESOLVED = (
    float(outcome)
    for outcome in (
        Outcome.FINISHED,
        Outcome.FELL,
        Outcome.STALLED,
        Outcome.LEFT_TERRAIN,
        Outcome.DIVERGED,
        Outcome.UNRESOLVED,
    )
)
CAUTION, LEAST, GREATEST = 0.8, 0.2, 1.5  # of a step's change of length; measured: few steps are rejected
FREE, HELD = (CAUTION / GREATEST) ** 8, CAUTION**8  # errors up to which the length may grow as it can, or stays
JUST_BESIDE = 2.3e-16  # next to a break's time, relative
SLIDING_STEP = 2e-3  # longest integration step while the foot slides on a face or on the ground, s
SHORTEST_STEP = 1e-12  # s; below it the motion is none
MISSED = 1e-6  # of the leg's length: a foot that lands so far off the ground has not been followed
NOW = 1e-9  # times so close are the same, s
POLISHED = 1e-7  # a touchdown found so closely is brought home by one term of its Taylor series, s


def advance(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers) -> None:
    """Walk until the outcome is decided, the buffers have no room for one more step, or `b.w[at.PAUSE]` is reached.

    After a pause the next call goes on where this one stopped, be it in the middle of a gait step: the walk is bitwise
    the same, however often it pauses.

    Args:
        laws: The controller's and the integrator's functions.
        parameters: What the controller's take.
        constants: Robot, ground and limits.
        b: State; `b.w[at.OUTCOME]` says in the end whether the walk is over.
    """
    w = b.w
    room = len(b.samples) - 1
    if math.isfinite(constants.sample_period):
        room -= int(constants.stall_time / constants.sample_period) + 2
    while (
        w[at.OUTCOME] == 0.0 and w[at.ROWS] < len(b.rows) and w[at.SAMPLES] <= room and w[at.EVALUATIONS] < w[at.PAUSE]
    ):
        if gait_step(laws, parameters, constants, b):
            transfer_support(laws, parameters, constants, b)
    if w[at.OUTCOME] != 0.0:
        take_sample(laws, parameters, constants, b, w[at.TIME], w[at.TIME] - w[at.CLOCK], b.y)


def gait_step(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers) -> bool:
    """Move from just after a support transfer to the next touchdown; whether there was one. The state is then in `b.y`.

    Where there was none, the outcome is decided, or the engine pauses.
    """
    w, n = b.w, len(b.y)
    t, step, limit = w[at.ELAPSED], w[at.NEXT_STEP], w[at.LIMIT]
    if w[at.UNDER_WAY] == 0.0:
        t = 0.0
        limit = _look_ahead(laws, parameters, constants, b, t)
        _begin(laws, parameters, constants, b, t)
        watch(w)
        step = min(step, w[at.FIRST_STEP])
    here = foot_over_ground(laws, constants, b, laws.pose(b, b.y))
    check = min(w[at.LOOK], w[at.PAUSE])
    while True:
        if w[at.EVALUATIONS] >= check:
            if w[at.EVALUATIONS] >= w[at.LOOK] and lags(constants, w, t):
                w[at.OUTCOME], w[at.TIME] = UNRESOLVED, w[at.CLOCK] + t
                return False
            if w[at.EVALUATIONS] >= w[at.PAUSE]:
                w[at.ELAPSED], w[at.NEXT_STEP], w[at.LIMIT] = t, step, limit
                return False
            check = min(w[at.LOOK], w[at.PAUSE])
        whole = limit - t
        step = min(step, SLIDING_STEP if w[at.FACE] != 0.0 or w[at.GROUND] != 0.0 else constants.longest_step)
        h = step if step < 0.5 * whole else (0.5 * whole if step < whole else whole)
        error = attempt(laws, parameters, constants, b, t, h)
        if not error <= 1.0:
            step = h * (max(LEAST, CAUTION * _eighth_root(1.0 / error)) if error > 1.0 else LEAST)
            if step < SHORTEST_STEP or not is_motion(constants, b.y):
                w[at.OUTCOME] = UNRESOLVED if math.isfinite(error) and is_tame(constants, b) else DIVERGED
                w[at.TIME] = w[at.CLOCK] + t
                return False
            if t == 0.0:
                w[at.FIRST_STEP] = step
            continue
        if error < FREE or (error < HELD and h >= constants.longest_step):  # roots would change nothing
            grown = GREATEST * h
        else:
            grown = CAUTION * h * _eighth_root(1.0 / error)
        step = max(step, grown) if h < step else grown
        if t == 0.0:
            w[at.FIRST_STEP] = max(w[at.FIRST_STEP], grown)
        pose = laws.pose(b, b.out)
        ended = body_ends(laws, constants, b, pose, FALLEN_HIP)
        there = foot_over_ground(laws, constants, b, pose)
        event, share = NOTHING, 1.0
        stops = laws.stops(constants, b)
        if ended or stops or not decided_by_ends(laws, constants, b, t, h, here, there):
            ensure_dense(laws, parameters, constants, b, t, h)
            if ended:
                share = _end_of_walk(laws, constants, b, h)
            if stops:
                strike = _stop_within(laws, b, h)
                stops = strike < share
                share = strike if stops else share
            event, share = first_event(laws, constants, b, t, h, share)
            if stops:
                event, ended = (KNEE_STRIKE if event == NOTHING else event), 0
        if event != NOTHING or ended:
            h = _end_on(laws, parameters, constants, b, t, share * h, event)
            if not is_motion(constants, b.out):  # a torque that is none between the times at which it was asked before
                w[at.OUTCOME], w[at.TIME] = DIVERGED, w[at.CLOCK] + t
                return False
        slid = w[at.GROUND] != 0.0 and not on_its_segment(laws, constants, b, b.out)
        if slid:
            h = end_at_edge(laws, parameters, constants, b, t, h)
        released = (w[at.FACE] != 0.0 or w[at.GROUND] != 0.0) and w[at.PRESS] < 0.0
        if released:  # and what the foot in contact would have met later in the step, it does not
            h = end_of_contact(laws, parameters, constants, b, t, h, at.PRESS)
            event, ended, slid = NOTHING, 0, False
        elif w[at.LOCKED] == KNEE_RESTING and w[at.STOP_PRESS] < 0.0:
            h = end_of_contact(laws, parameters, constants, b, t, h, at.STOP_PRESS)
            w[at.LOCKED], event, ended, released, slid = KNEE_FREE, NOTHING, 0, True, False
        if released or slid or event != NOTHING or ended:
            pose = laws.pose(b, b.out)
        whole_motion = accumulate(laws, parameters, constants, b, pose, t, h)
        t = limit if h == whole else t + h
        for c in range(n):
            b.y[c] = b.out[c]
        w[at.TIME] = w[at.CLOCK] + t
        w[at.NEXT_STEP] = step
        if not whole_motion:
            w[at.OUTCOME] = DIVERGED
            return False
        if event == TOUCHDOWN:
            if laws.lands(constants, b):
                w[at.UNDER_WAY] = 0.0
                return True
            if not _stays_on_ground(laws, constants, b, slid=False):
                return False
            _begin(laws, parameters, constants, b, t)
        elif event == FACE_IMPACT:
            before = momentum(laws, constants, b)
            note_impulse(laws, constants, b, before, hit_face(laws, constants, b))
            _begin(laws, parameters, constants, b, t)
        elif event == KNEE_STRIKE:
            before = momentum(laws, constants, b)
            laws.strike_stop(laws, parameters, constants, b, t)
            note_impulse(laws, constants, b, before, 0.0)
            if w[at.GROUND] != 0.0 and laws.lands(constants, b):  # a straight leg that stands on the ground ahead
                w[at.UNDER_WAY] = 0.0
                return True
            limit = _look_ahead(laws, parameters, constants, b, t)
            _begin(laws, parameters, constants, b, t)
        elif event == OVER_THE_TOP or released:
            w[at.FACE] = 0.0 if w[at.PRESS] < 0.0 or event == OVER_THE_TOP else w[at.FACE]
            w[at.GROUND] = 0.0 if w[at.PRESS] < 0.0 else w[at.GROUND]
            _begin(laws, parameters, constants, b, t)
        elif slid:
            if not _stays_on_ground(laws, constants, b, slid=True):
                return False
            _begin(laws, parameters, constants, b, t)
        elif ended:
            w[at.OUTCOME] = FELL if ended == 1 else LEFT_TERRAIN
            return False
        elif t >= constants.stall_time:
            w[at.OUTCOME] = STALLED
            return False
        elif t == limit:
            limit = _look_ahead(laws, parameters, constants, b, t)
            _begin(laws, parameters, constants, b, t)
        else:
            for c in range(n):
                b.k[c] = b.k[STAGES * n + c]
            here = there
            continue
        here = foot_over_ground(laws, constants, b, laws.pose(b, b.y))


def _eighth_root(x: float) -> float:
    return math.sqrt(math.sqrt(math.sqrt(x)))


def _begin(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> None:
    """Rates of a state that no step has led to, with its torques and the forces of it and of an impact before it."""
    begin(laws, parameters, constants, b, t)
    if b.w[at.LOCKED] == KNEE_RESTING and b.w[at.STOP_PRESS] < 0.0:
        b.w[at.LOCKED] = KNEE_FREE
        begin(laws, parameters, constants, b, t)
    note_peaks(constants, b.w)
    note_ground_force(laws, constants, b, laws.pose(b, b.y), b.y, 0)
    note_impact(constants, b.w)


def _stays_on_ground(laws: Laws, constants: SimulationConstants, b: Buffers, slid: bool) -> bool:
    """Let the ground stop a swing foot that comes down, or that has slid to its end; False: the robot has fallen."""
    before = momentum(laws, constants, b)
    push = slides_on(laws, constants, b) if slid else laws.stub(constants, b)
    note_impulse(laws, constants, b, before, push)
    fell = math.isnan(push)
    if fell:
        b.w[at.OUTCOME], b.w[at.TOE] = FELL, 1.0
    return not fell


def _look_ahead(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float) -> float:
    """Time up to which the law is smooth, or the robot has stalled; keeps the law on this side of both.

    A controller that ticks does so here, when it is time, and a push begins or ends.
    """
    w = b.w
    first = 2 * constants.angles
    for index in range(len(b.y) - first - constants.joints):
        b.memory[index] = b.y[first + index]
    time = w[at.CLOCK] + t
    if time > w[at.NEXT_TICK] - NOW:
        w[at.NEXT_TICK] += constants.control_period
        w[at.STEP_STARTED] += (
            STAGES  # the integration step that ends here is no sign of a torque that cannot be followed
        )
        w[at.LOOK] += STAGES
        laws.ticked(laws.tick, parameters, b.memory, t, b.y)
    if time > w[at.NEXT_PUSH] - NOW:
        _begin_or_end_push(constants.pushes, w)
    event = min(w[at.NEXT_TICK], w[at.NEXT_PUSH]) - w[at.CLOCK]
    there = min(laws.next_discontinuity(parameters, b.memory, t), event)
    if not there > t:
        there = math.inf
    w[at.AFTER] = t * (1.0 + JUST_BESIDE)
    w[at.BEFORE] = there * (1.0 - JUST_BESIDE)
    return float(min(there, constants.stall_time))


def _begin_or_end_push(pushes: Pushes, w: Any) -> None:
    """A push of constant force begins, or ends."""
    if w[at.PUSHING] == 0.0:
        w[at.PUSHING], w[at.PUSH] = 1.0, w[at.PUSH_IMPULSE] / pushes.duration
        w[at.NEXT_PUSH] += pushes.duration
        return
    w[at.PUSHING] = w[at.PUSH] = 0.0
    w[at.PUSHES] += 1.0
    w[at.NEXT_PUSH], w[at.PUSH_IMPULSE] = following(pushes, int(w[at.PUSHES]), w[at.NEXT_PUSH])


def _end_of_walk(laws: Laws, constants: SimulationConstants, b: Buffers, h: float) -> float:
    """Share of the step at which the robot has fallen or left the ground."""
    x, end = 0.0, 1.0
    while (end - x) * h > 1e-9:
        middle = 0.5 * (x + end)
        if body_ends(laws, constants, b, pose_within(laws, b, middle), FALLEN_HIP):
            end = middle
        else:
            x = middle
    return end


def _stop_within(laws: Laws, b: Buffers, h: float) -> float:
    """Share of the step at which the swing knee reaches its stop, which it is beyond at the step's end."""
    x, end = 0.0, 1.0
    while (end - x) * h > 1e-9:
        middle = 0.5 * (x + end)
        if laws.stopped_within(b, middle):
            end = middle
        else:
            x = middle
    return end


def _end_on(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float, event: int
) -> float:
    """Take the step again so that it ends on its event; returns its length.

    Newton's method on steps of the full order, for the dense output is of a lower one, and at last a Taylor term.
    """
    n = len(b.y)
    h = max(h, SHORTEST_STEP)
    for _ in range(6):
        attempt(laws, parameters, constants, b, t, h)
        if event != TOUCHDOWN and event != FACE_IMPACT and event != KNEE_STRIKE:
            break
        if event == TOUCHDOWN:
            gap, speed = landing(laws, constants, b, int(b.w[at.LANDING]))
        elif event == FACE_IMPACT:
            gap, speed = face_gap(laws, constants, b)
        else:
            gap, speed = laws.stop_gap(b)
        if speed == 0.0 or abs(gap) > abs(speed) * 1e-3:
            break  # it grazes: the crossing that was found stands
        change = -gap / speed
        if h + change <= 0.0:
            break
        if abs(change) < POLISHED:
            for c in range(n):
                b.out[c] += change * b.k[STAGES * n + c]
            h += change
            break
        h += change
    return h


def transfer_support(laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers) -> None:
    """Impact map, support transfer, the controller's touchdown, and a row of the record.

    No row tells of a foot that is not on the ground: the walk has then diverged.
    """
    w = b.w
    foot_x, foot_z = laws.swing_foot(constants, b, laws.pose(b, b.y))
    segment = segment_stood_on(constants, foot_x, foot_z, CORNER, FACE_WIDTH, FACE_WIDTH)
    if not abs(foot_z - height_of(constants, segment, foot_x)) <= MISSED * constants.length + CORNER:
        w[at.OUTCOME] = DIVERGED
        return
    before = momentum(laws, constants, b)
    laws.transfer(laws, parameters, constants, b, segment, foot_x)
    w[at.ROWS] += 1.0
    w[at.COUNT] += 1.0
    begin_step(constants, w)
    note_impulse(laws, constants, b, before, 0.0)
    if w[at.COUNT] >= constants.steps or foot_x >= constants.distance:
        w[at.OUTCOME] = FINISHED
    elif foot_x >= constants.end:
        w[at.OUTCOME] = LEFT_TERRAIN
