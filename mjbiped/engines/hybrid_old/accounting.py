"""Book-keeping of the hybrid engine: work, peak torques, forces and samples of an accepted integration step.

The net work of each joint is integrated with the motion. Its absolute and positive work follow from the turning points
of that integral, where the power changes sign: there it is flat, so that it hardly matters how exactly they are found,
and no step has to end on them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mjbiped.engines.hybrid.dynamics import component_at, dense_state, ensure_dense, is_motion
from mjbiped.engines.hybrid.events import flexion_within
from mjbiped.engines.hybrid.forces import PIECES, note_ground_force, note_least_force, note_pressures, parabola_top
from mjbiped.engines.hybrid.stance import on_sole
from mjbiped.engines.hybrid.state import Walk, hand_over, hip, pose_of
from mjbiped.numerics.dormand_prince import IN_ORDER, PLACES, STAGES, dense_rate_at
from mjbiped.robots.equations import FLAT, LOCKED

BARELY = 1.0 + 1e-9  # ignore peaks within the step that are less than 1e-9 higher
HARDLY = 0.7  # of the weight: in a gait step that bears less, the least force is looked for within integration steps
NO_WORK = 1e-14  # J in a step: rounding
FAR, NEAR = 0.25, 0.05  # of the power's spread in a step: whether zero can be, and is looked for, between two stages


def accumulate(s: Walk, pose: Any, h: float) -> bool:
    """Take a step of length h into work, peaks, forces and samples; the law was last asked at its end.

    Returns:
        Whether the motion within it is one: a torque may be no number where only a sample is taken.
    """
    w = s.w
    note_peaks(w, STAGES)
    acts = False
    for joint in range(len(w.peak_torque)):
        size, place = _greatest_torque(w, joint)
        acts = acts or size > 0.0
        if size > w.peak_torque[joint] * BARELY:
            _note_peak_within(s, h, joint, place)
    _add_work(s, h, acts)
    normal = w.normal_now
    note_ground_force(s, pose, w.out, STAGES * len(w.y) + len(w.strike_q))
    if (
        acts or s.c.toe > 0.0 or w.pressure[0] < 0.0 or w.pressure[1] < 0.0
    ):  # else the centre of pressure stays at the ankle
        note_pressures(s, normal, h)
    if w.normal_force < HARDLY * s.c.mass * s.c.gravity and w.face == 0.0 and not w.sliding:
        ensure_dense(s, h)
        note_least_force(s, h)
    if w.locked != LOCKED:
        _note_flexion(s, h)
    if w.edge != FLAT:
        _note_tip(s, h)
    return _take_samples(s, h)


def note_peaks(w: Any, stage: int) -> None:
    """Keep the greatest magnitudes of the torques, with those at a stage."""
    joints = len(w.peak_torque)
    for joint in range(joints):
        w.peak_torque[joint] = max(w.peak_torque[joint], abs(w.torques[stage * joints + joint]))


def _greatest_torque(w: Any, joint: int) -> tuple[float, float]:
    """Greatest magnitude of a joint's torque in the step as its stages tell it, N m, and its share of the step.

    Near the peak known so far it is the top of the parabola through the greatest value and two beside it.
    """
    joints, last, greatest, least = len(w.peak_torque), 0, 0.0, math.inf
    for i in range(len(IN_ORDER)):
        size = abs(w.torques[IN_ORDER[i] * joints + joint])
        least = min(least, size)
        if size > greatest:
            last, greatest = i, size
    if 2.0 * greatest - least > w.peak_torque[joint]:
        i = min(max(last, 1), len(IN_ORDER) - 2)
        middle = abs(w.torques[IN_ORDER[i] * joints + joint])
        left = middle - abs(w.torques[IN_ORDER[i - 1] * joints + joint])
        right = abs(w.torques[IN_ORDER[i + 1] * joints + joint]) - middle
        slope, bend, before, after = _parabola(i, left, right)
        if 2.0 * bend * after < -slope < -2.0 * bend * before:
            return middle - slope * slope / (4.0 * bend), PLACES[i] - slope / (2.0 * bend)
    return greatest, PLACES[last]


def _parabola(i: int, left: float, right: float) -> tuple[float, float, float, float]:
    """The parabola through three values at neighbouring places of stages.

    Args:
        i: The middle one of the places, in their order.
        left: Change of the value up to it.
        right: Change after it.

    Returns:
        Slope and half the second derivative there, by the share of the step; distances from the place before, and to
        the place after.
    """
    before, after = PLACES[i] - PLACES[i - 1], PLACES[i + 1] - PLACES[i]
    falling, rising = left / before, right / after
    bend = (rising - falling) / (before + after)
    return falling + bend * before, bend, before, after


def _add_work(s: Walk, h: float, acts: bool) -> None:
    """Add the work of a step; where no torque acts there is none."""
    w = s.w
    n = len(w.y)
    for component in range(n - len(w.peak_torque), n):
        net = w.out[component] - w.y[component]
        variation = abs(net)
        if acts and _turns(w.k, n, component, h):
            ensure_dense(s, h)
            variation = _total_variation(w, component)
        w.work_absolute += variation
        w.work_net += net
        w.work_positive += 0.5 * (variation + net)


def _asked(s: Walk, t: float, state: Any) -> Any:
    """Torques of the law in a state, and the rates of its own."""
    laws, w = s.laws, s.w
    hand_over(s, state)
    q, dq = laws.told(laws.q(state)), laws.told_rates(laws.dq(state))
    return laws.torque(s.law, w.memory, min(max(t, w.after), w.before), q, dq)


def _given(s: Walk, state: Any, asked: Any) -> Any:
    """What the sole transmits of what `_asked` returns; all of it without a sole."""
    if s.c.behind == math.inf:
        return asked
    given, _ = on_sole(s, state, s.laws.q(state), s.laws.dq(state), asked)
    return given


def _note_peak_within(s: Walk, h: float, joint: int, place: float) -> None:
    """Keep a joint's peak inside the step: the top of the parabola through a greatest value and its neighbours.

    It is climbed to in sixteenths of the step from the place, a share of the step, at which the torque seemed greatest.
    """
    w = s.w
    piece = min(max(int(PIECES * place + 0.5), 1), PIECES - 1)
    ensure_dense(s, h)
    middle = _torque_within(s, h, piece, joint)
    left = _torque_within(s, h, piece - 1, joint)
    right = _torque_within(s, h, piece + 1, joint)
    while abs(left) > abs(middle) and piece > 1:
        piece -= 1
        right, middle = middle, left
        left = _torque_within(s, h, piece - 1, joint)
    while abs(right) > abs(middle) and piece < PIECES - 1:
        piece += 1
        left, middle = middle, right
        right = _torque_within(s, h, piece + 1, joint)
    found = max(abs(left), abs(middle), abs(right), abs(parabola_top(left, middle, right)))
    w.peak_torque[joint] = max(w.peak_torque[joint], found)


def _torque_within(s: Walk, h: float, piece: int, joint: int) -> float:
    """A joint's torque so many sixteenths into the step, N m."""
    x = piece / PIECES
    dense_state(s, x)
    return float(_given(s, s.w.spare, _asked(s, s.w.elapsed + x * h, s.w.spare))[joint])


def _turns(k: Sequence[float], n: int, component: int, h: float) -> bool:
    """Whether a joint's power seems to change its sign in the step, or to come near to it between two stages.

    Between stages it may change its sign twice: a parabola through three of them shows the dip, if not how deep it is.
    """
    least = greatest = k[component]
    for stage in IN_ORDER:
        power = k[stage * n + component]
        least, greatest = min(least, power), max(greatest, power)
    spread = greatest - least
    if spread * h <= NO_WORK:
        return False
    if least < 0.0 < greatest:
        return True
    sign = 1.0 if greatest > 0.0 else -1.0
    if min(abs(least), abs(greatest)) > FAR * spread:
        return False
    for i in range(1, len(IN_ORDER) - 1):
        middle = sign * k[IN_ORDER[i] * n + component]
        left, right = (
            middle - sign * k[IN_ORDER[i - 1] * n + component],
            sign * k[IN_ORDER[i + 1] * n + component] - middle,
        )
        slope, bend, before, after = _parabola(i, left, right)
        if -2.0 * bend * before < -slope < 2.0 * bend * after and middle - slope * slope / (4.0 * bend) < NEAR * spread:
            return True
    return False


def _total_variation(w: Any, component: int) -> float:
    """Sum of a work integral's ups and downs over the step."""
    n, total = len(w.y), 0.0
    last, x = w.y[component], 0.0
    power = dense_rate_at(w.dense, n, component, 0.0)
    for piece in range(1, PIECES + 1):
        end = piece / PIECES
        power_there = dense_rate_at(w.dense, n, component, end)
        if (power < 0.0) != (power_there < 0.0):
            low, high = x, end
            for _ in range(20):  # the integral is flat at the turn: 2^-24 of a step is more than enough
                middle = 0.5 * (low + high)
                if (dense_rate_at(w.dense, n, component, middle) < 0.0) == (power < 0.0):
                    low = middle
                else:
                    high = middle
            turn = component_at(w, component, low)
            total += abs(turn - last)
            last = turn
        x, power = end, power_there
    return float(total + abs(w.out[component] - last))


def _note_flexion(s: Walk, h: float) -> None:
    """Keep the greatest flexion of the swing knee, also where it lies within the step."""
    w, thigh, shank = s.w, s.c.robot.thigh, s.c.robot.shank
    w.flexion = max(w.flexion, w.y[shank] - w.y[thigh], w.out[shank] - w.out[thigh])
    first = len(w.strike_q)
    thigh, shank = first + thigh, first + shank
    if w.y[shank] - w.y[thigh] <= 0.0 or w.out[shank] - w.out[thigh] >= 0.0:
        return
    ensure_dense(s, h)
    x = _last_before_turn(w, shank, thigh)
    w.flexion = max(w.flexion, flexion_within(s, x))


def _note_tip(s: Walk, h: float) -> None:
    """Keep how long the stance foot has stood on an edge, and how far it has tipped, also within the step."""
    w, foot = s.w, len(s.w.strike_q) - 1
    rate = foot + len(w.strike_q)
    w.one_sided += h
    w.tipped = max(w.tipped, abs(w.out[foot]))
    if w.y[rate] * w.out[rate] < 0.0:
        ensure_dense(s, h)
        x = _last_before_turn(w, rate, -1)
        w.tipped = max(w.tipped, abs(component_at(w, foot, x)))


def _last_before_turn(w: Any, rate: int, other: int) -> float:
    """Share of the step up to which a rate, relative to another one if there is one, keeps its sign."""
    x, end = 0.0, 1.0
    sign = w.y[rate] - (w.y[other] if other >= 0 else 0.0)
    for _ in range(30):
        middle = 0.5 * (x + end)
        here = component_at(w, rate, middle) - (component_at(w, other, middle) if other >= 0 else 0.0)
        if here * sign > 0.0:
            x = middle
        else:
            end = middle
    return x


def _take_samples(s: Walk, h: float) -> bool:
    """Take the samples that lie in the step; whether the motion is one where they are taken."""
    w = s.w
    end = w.clock + w.elapsed + h
    while w.sample * s.c.sample_period < end:
        ensure_dense(s, h)
        time = w.sample * s.c.sample_period
        x = min(max((time - w.clock - w.elapsed) / h, 0.0), 1.0)
        dense_state(s, x)
        if not is_motion(s, w.spare):
            return False
        take_sample(s, time, w.elapsed + x * h, w.spare)
        w.sample += 1
    return True


def take_sample(s: Walk, time: float, t: float, state: Any) -> None:
    """Write a row of the samples, with the torques of the law in a state at time t since the support transfer."""
    w = s.w
    asked = _asked(s, t, state)
    row, torques = s.laws.tables(s.c.tables).samples[w.samples], (asked[0], _given(s, state, asked))
    write_state(s, row, time, state, torques, s.laws.slope_estimate(s.law, w.memory))
    w.samples += 1


def write_state(s: Walk, row: Any, time: float, state: Any, torques: tuple[float, Any], estimate: float) -> None:
    """Fill a row of the samples.

    Args:
        s: The walk.
        row: To be filled.
        time: Since the start, s.
        state: State of motion, the controller's states behind it.
        torques: Torque that the ankle is asked for, then the torques of all joints, N m.
        estimate: Of the slope, rad.
    """
    w, laws = s.w, s.laws
    q = laws.q(state)
    laws.write_sample(
        row,
        0,
        time=time,
        q=laws.told(q),
        dq=laws.told_rates(laws.dq(state)),
        torque=torques[1],
        ankle_asked=torques[0],
        slope=laws.sole_slope(w.slope, q),
        slope_estimate=estimate,
        stance=w.stance,
        qpos=hip(s, pose_of(s, state)) + laws.limbs(s.c.robot, w, q),
        locked=1.0 if w.locked == LOCKED else 0.0,
    )
    angles = len(w.strike_q)
    own = len(w.y) - 2 * angles - len(w.peak_torque)
    for index in range(own):
        row[len(row) - own + index] = state[2 * angles + index]
