"""Book-keeping of the hybrid engine: work, peak torques, forces and samples of an accepted integration step.

The net work of each joint is integrated with the motion. Absolute and positive work follow from the turning points of
that integral, where the power changes sign. Since the integral is flat at a turning point, its exact time hardly
matters, and no integration step has to end there.
"""

from __future__ import annotations

import math
from itertools import pairwise

from mjbiped.dynamics.integrate import IN_ORDER, PLACES, STAGES, STAGES_WITH_DENSE, rate_at, value_at
from mjbiped.dynamics.linkage import ROOM, ground_force
from mjbiped.dynamics.modes import FLAT, LOCKED
from mjbiped.engines.hybrid import motion
from mjbiped.engines.hybrid.resets import write_sample
from mjbiped.engines.hybrid.state import Constants, State, linkage_of, touches
from mjbiped.numerics.blocks import Floats, numbers, row
from mjbiped.records.loads import BINS, note_pressure
from mjbiped.rules.termination import LIGHT_CONTACT

PIECES = 16  # of a step, in which a change of the power's sign, a peak or the least force is looked for
_BOUNDS = (0.0, *(0.5 * (near + far) for near, far in pairwise(PLACES)), 1.0)
SHARES = tuple(far - near for near, far in pairwise(_BOUNDS))  # of the step, one for each stage
NEGLIGIBLE = 1.0 + 1e-9  # ignore peaks within the step that are less than 1e-9 higher
UNLOADED = 0.7  # of the weight: if the normal force falls below it, look for the least force within steps as well
NO_WORK = 1e-14  # J in a step: rounding
NEAR = 0.25  # of the power's spread in a step: if the power is farther from zero at all stages, it has no zero between


def accumulate(c: Constants, w: State, h: float) -> bool:
    """Account for a step of length h: work, peaks, forces and samples; the law was last evaluated at the step's end.

    Returns:
        False if a sample within the step is not finite (`is_motion`), as after a torque that is NaN there alone.
    """
    note_peaks(c, w, STAGES)
    acts, peaks, pressure = False, numbers(w.peak_torque, ROOM), numbers(w.pressure, 2)
    for joint in range(c.joints):
        size, place = _greatest_torque(c, w, joint)
        acts = acts or size > 0.0
        if size > peaks[joint] * NEGLIGIBLE:
            _note_peak_within(c, w, h, joint, place)
    _add_work(c, w, h, acts)
    normal = w.normal_now
    motion.note_ground_force(c, w, numbers(w.out, c.size), row(w.k, STAGES, c.size))
    # without any torque, the centre of pressure stays at the ankle
    if acts or c.toe > 0.0 or pressure[0] < 0.0 or pressure[1] < 0.0:
        note_pressures(c, w, normal, h)
    if w.normal_force < UNLOADED * c.weight and not touches(w):
        motion.ensure_dense(c, w, h)
        note_least_force(c, w, h)
    if w.locked != LOCKED:
        _note_flexion(c, w, h)
    if w.edge != FLAT:
        _note_tip(c, w, h)
    return _take_samples(c, w, h)


def note_peaks(c: Constants, w: State, stage: int) -> None:
    """Update the greatest magnitudes of the torques by those at a stage."""
    peaks, torques = numbers(w.peak_torque, ROOM), row(w.given, stage, c.given)
    for joint in range(c.joints):
        peaks[joint] = max(peaks[joint], abs(torques[joint]))


def _greatest_torque(c: Constants, w: State, joint: int) -> tuple[float, float]:
    """Greatest magnitude of a joint's torque, at a stage or on a parabola about it, N m; and its place in the step."""
    last, greatest, least = 0, 0.0, math.inf
    for i in range(len(IN_ORDER)):
        size = _torque_at(c, w, i, joint)
        least = min(least, size)
        if size > greatest:
            last, greatest = i, size
    if 2.0 * greatest - least > numbers(w.peak_torque, ROOM)[joint]:
        i = min(max(last, 1), len(IN_ORDER) - 2)
        middle = _torque_at(c, w, i, joint)
        left, right = middle - _torque_at(c, w, i - 1, joint), _torque_at(c, w, i + 1, joint) - middle
        slope, bend, before, after = _parabola(i, left, right)
        if 2.0 * bend * after < -slope < -2.0 * bend * before:
            return middle - slope * slope / (4.0 * bend), PLACES[i] - slope / (2.0 * bend)
    return greatest, PLACES[last]


def _torque_at(c: Constants, w: State, i: int, joint: int) -> float:
    """Magnitude of a joint's torque at the i-th stage in the order of their places, N m."""
    return float(abs(row(w.given, IN_ORDER[i], c.given)[joint]))


def _parabola(i: int, left: float, right: float) -> tuple[float, float, float, float]:
    """Parabola through stage i and its neighbours, from the changes on both sides: slope, half the bend, widths."""
    before, after = PLACES[i] - PLACES[i - 1], PLACES[i + 1] - PLACES[i]
    falling, rising = left / before, right / after
    bend = (rising - falling) / (before + after)
    return falling + bend * before, bend, before, after


def _add_work(c: Constants, w: State, h: float, acts: bool) -> None:
    """Add the work of a step; `acts` says whether any torque acts, and so whether a power can change its sign."""
    y, out = numbers(w.y, c.size), numbers(w.out, c.size)
    for component in range(c.size - c.joints, c.size):
        net = out[component] - y[component]
        variation = abs(net)
        if acts and _turns(c, w, component, h):
            motion.ensure_dense(c, w, h)
            variation = _total_variation(c, w, component)
        w.work_absolute += variation
        w.work_net += net
        w.work_positive += 0.5 * (variation + net)


def _note_peak_within(c: Constants, w: State, h: float, joint: int, place: float) -> None:
    """Keep a joint's peak torque inside the step: climb by sixteenths of the step from the estimated place."""
    piece = min(max(int(PIECES * place + 0.5), 1), PIECES - 1)
    motion.ensure_dense(c, w, h)
    middle = _torque_within(c, w, h, piece, joint)
    left = _torque_within(c, w, h, piece - 1, joint)
    right = _torque_within(c, w, h, piece + 1, joint)
    while abs(left) > abs(middle) and piece > 1:
        piece -= 1
        right, middle = middle, left
        left = _torque_within(c, w, h, piece - 1, joint)
    while abs(right) > abs(middle) and piece < PIECES - 1:
        piece += 1
        left, middle = middle, right
        right = _torque_within(c, w, h, piece + 1, joint)
    found = max(abs(left), abs(middle), abs(right), abs(parabola_top(left, middle, right)))
    peaks = numbers(w.peak_torque, ROOM)
    peaks[joint] = max(peaks[joint], found)


def _torque_within(c: Constants, w: State, h: float, piece: int, joint: int) -> float:
    """Torque of a joint after a number of sixteenths (`piece`) of the step, N m."""
    x = piece / PIECES
    motion.write_state_at(c, w, x)
    write_torques(c, w, w.elapsed + x * h, numbers(w.spare, c.size))
    return float(numbers(w.sampled, c.given)[joint])


def write_torques(c: Constants, w: State, t: float, y: Floats) -> float:
    """Write the torques that act in a state into `w.sampled`; returns the ankle torque that the law asks for, N m."""
    given = numbers(w.sampled, c.given)
    motion.take_angles(c, w, y)
    motion.ask(c, w, t, y, given)
    asked = given[0]
    if c.behind < math.inf:
        motion.bound_ankle(c, w, given)
    return float(asked)


def _turns(c: Constants, w: State, component: int, h: float) -> bool:
    """Whether a joint's power may change its sign in the step: at a stage it does, or comes near to zero."""
    least = greatest = row(w.k, 0, c.size)[component]
    for stage in IN_ORDER:
        power = row(w.k, stage, c.size)[component]
        least, greatest = min(least, power), max(greatest, power)
    spread = greatest - least
    return spread * h > NO_WORK and least < NEAR * spread and greatest > -NEAR * spread


def _total_variation(c: Constants, w: State, component: int) -> float:
    """Sum of a work integral's ups and downs over the step."""
    last, x, total = numbers(w.y, c.size)[component], 0.0, 0.0
    power = rate_at(c, w, component, 0.0)
    for piece in range(1, PIECES + 1):
        end = piece / PIECES
        power_there = rate_at(c, w, component, end)
        if (power < 0.0) != (power_there < 0.0):
            low, high = x, end
            for _ in range(20):  # the integral is flat at the turn: 2^-24 of a step is more than enough
                middle = 0.5 * (low + high)
                if (rate_at(c, w, component, middle) < 0.0) == (power < 0.0):
                    low = middle
                else:
                    high = middle
            turn = value_at(c, w, component, low)
            total += abs(turn - last)
            last = turn
        x, power = end, power_there
    return float(total + abs(numbers(w.out, c.size)[component] - last))


def _note_flexion(c: Constants, w: State, h: float) -> None:
    """Keep the greatest flexion of the swing knee, also where it lies within the step."""
    y, out, n, thigh, shank = numbers(w.y, c.size), numbers(w.out, c.size), c.angles, c.thigh, c.shank
    w.flexion = max(w.flexion, y[shank] - y[thigh], out[shank] - out[thigh])
    if y[n + shank] - y[n + thigh] <= 0.0 or out[n + shank] - out[n + thigh] >= 0.0:
        return
    motion.ensure_dense(c, w, h)
    x = _last_before_turn(c, w, n + shank, n + thigh)
    w.flexion = max(w.flexion, value_at(c, w, shank, x) - value_at(c, w, thigh, x))


def _note_tip(c: Constants, w: State, h: float) -> None:
    """Keep how long the stance foot has stood on an edge, and how far it has tipped, also within the step."""
    y, out, rate = numbers(w.y, c.size), numbers(w.out, c.size), c.angles + c.foot
    w.one_sided += h
    w.tipped = max(w.tipped, abs(out[c.foot]))
    if y[rate] * out[rate] < 0.0:
        motion.ensure_dense(c, w, h)
        x = _last_before_turn(c, w, rate, -1)
        w.tipped = max(w.tipped, abs(value_at(c, w, c.foot, x)))


def _last_before_turn(c: Constants, w: State, rate: int, other: int) -> float:
    """Share of the step up to which a rate, relative to another one if there is one, keeps its sign."""
    y, x, end = numbers(w.y, c.size), 0.0, 1.0
    sign = y[rate] - (y[other] if other >= 0 else 0.0)
    for _ in range(30):
        middle = 0.5 * (x + end)
        here = value_at(c, w, rate, middle) - (value_at(c, w, other, middle) if other >= 0 else 0.0)
        if here * sign > 0.0:
            x = middle
        else:
            end = middle
    return x


def _take_samples(c: Constants, w: State, h: float) -> bool:
    """Take the samples that lie in the step; False if the state of one is not finite (`is_motion`)."""
    end, y = w.clock + w.elapsed + h, numbers(w.spare, c.size)
    while w.sample * c.sample_period < end:
        motion.ensure_dense(c, w, h)
        time = w.sample * c.sample_period
        x = min(max((time - w.clock - w.elapsed) / h, 0.0), 1.0)
        motion.write_state_at(c, w, x)
        if not motion.is_motion(c, y):
            return False
        take_sample(c, w, time, w.elapsed + x * h, y)
        w.sample += 1
    return True


def take_sample(c: Constants, w: State, time: float, t: float, y: Floats) -> None:
    """Write a row of the samples, with the torques of the law in a state at time t since the support transfer."""
    asked = write_torques(c, w, t, y)
    write_sample(c, w, time, y, asked)
    w.samples += 1


def note_least_force(c: Constants, w: State, h: float) -> None:
    """Keep the least normal force inside the step, at equally spaced moments or on parabolas through the least."""
    y, dq, ddq = numbers(w.spare, c.size), numbers(w.dq, ROOM), numbers(w.ddq, ROOM)
    last = before = 0.0
    for piece in range(PIECES + 1):
        x = piece / PIECES
        motion.write_state_at(c, w, x)
        for i in range(c.angles):
            dq[i], ddq[i] = y[c.angles + i], rate_at(c, w, c.angles + i, x) / h
        _, normal = ground_force(linkage_of(c, w), w, y, dq, ddq)
        normal -= w.push * w.sine
        w.normal_force = min(w.normal_force, normal)
        if piece > 1 and last < min(before, normal):
            w.normal_force = min(w.normal_force, parabola_top(before, last, normal))
        before, last = last, normal


def parabola_top(left: float, middle: float, right: float) -> float:
    """Extremum of the parabola through three values at equal distances; 0 if it lies outside them."""
    bend, lean = 0.5 * (left + right) - middle, 0.5 * (right - left)
    if abs(lean) >= 2.0 * abs(bend):
        return 0.0
    return middle - lean * lean / (4.0 * bend)


def note_pressures(c: Constants, w: State, before: float, h: float) -> None:
    """Note the centre of pressure at the stages of a step of length h, where the torques are known.

    Without a sole, the normal force is taken to change linearly from `before` (N) to its value at the step's end.
    """
    pressure, normals = numbers(w.pressure, 2 + BINS), numbers(w.normals, STAGES_WITH_DENSE)
    moments, asked = numbers(w.moments, STAGES_WITH_DENSE), numbers(w.asked, STAGES_WITH_DENSE)
    change, light = w.normal_now - before, LIGHT_CONTACT * c.weight
    for i in range(len(IN_ORDER)):
        stage, time = IN_ORDER[i], SHARES[i] * h
        torque, normal = row(w.given, stage, c.given)[0], before + PLACES[i] * change
        if c.toe > 0.0:
            torque, normal = moments[stage], normals[stage]
        elif c.behind < math.inf:
            normal = normals[stage]
            if torque != asked[stage]:
                w.bound_time += time
        note_pressure(pressure, torque, normal, light, c.length, time)
