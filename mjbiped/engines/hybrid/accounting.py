"""Book-keeping of the hybrid engine: work, peak torques, friction and samples of an accepted integration step.

The net work of either joint is integrated with the motion. Its absolute and positive work follow from the turning
points of that integral, where the power changes sign: there it is flat, so that it hardly matters how exactly they are
found, and no step has to end on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import dense_state, ensure_dense, is_motion
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.numerics.dormand_prince import STAGE_PLACES, STAGES, TESTED_STAGES, dense_at, dense_rate_at
from mjbiped.records.pressure import note_pressure
from mjbiped.rules.termination import LIGHT_CONTACT

PIECES = 16  # of a step, in which a change of the power's sign or a peak is looked for
BARELY = 1.0 + 1e-9  # a peak is not looked for within the step for less: periodic walking would ask again every step
HARDLY = 0.7  # of the weight: in a step that bears less, the least force is looked for within integration steps, too
NO_WORK = 1e-14  # J in a step: rounding
FAR, NEAR = 0.25, 0.05  # of the power's spread in a step: whether zero can be, and is looked for, between two stages
IN_ORDER = tuple(sorted((0, *TESTED_STAGES), key=lambda stage: STAGE_PLACES[stage]))
PLACES = tuple(STAGE_PLACES[stage] for stage in IN_ORDER)
ALL_IN_ORDER = tuple(sorted((*range(STAGES - 1), STAGES), key=lambda stage: STAGE_PLACES[stage]))
ALL_PLACES = tuple(STAGE_PLACES[stage] for stage in ALL_IN_ORDER)
_BOUNDS = (0.0, *(0.5 * (near + far) for near, far in pairwise(ALL_PLACES)), 1.0)
SHARES = tuple(far - near for near, far in pairwise(_BOUNDS))  # of the step, that each of these stages stands for


def accumulate(
    laws: Laws,
    parameters: Any,
    constants: SimulationConstants,
    b: Buffers,
    pose: Any,
    t: float,
    h: float,
) -> bool:
    """Take the step from t to t + h into work, peaks, friction and samples; the law was last asked at its end.

    Returns:
        Whether the motion within it is one: a torque may be no number where only a sample is taken.
    """
    w, n, joints = b.w, len(b.y), constants.joints
    works = 0.0
    for joint in range(joints):
        w[at.KEPT_ANKLE + joint], w[at.KEPT_WHEN_ANKLE + joint] = w[at.STAGE_ANKLE + joint], w[at.WHEN_ANKLE + joint]
        works += w[at.STAGE_ANKLE + joint]
    note_peaks(constants, w)
    for joint in range(joints):
        if w[at.KEPT_ANKLE + joint] > w[at.PEAK_ANKLE + joint] * BARELY:
            ensure_dense(laws, parameters, constants, b, t, h)
            _peak_within(laws, parameters, constants, b, t, h, joint)
    for component in range(n - joints, n):
        net = b.out[component] - b.y[component]
        variation = abs(net)
        if works > 0.0 and _turns(b.k, n, component, h):
            ensure_dense(laws, parameters, constants, b, t, h)
            variation = _total_variation(b, n, component)
        w[at.WORK_ABSOLUTE] += variation
        w[at.WORK_NET] += net
        w[at.WORK_POSITIVE] += 0.5 * (variation + net)
    normal = w[at.NORMAL_NOW]
    note_ground_force(laws, constants, b, pose, b.out, STAGES * n)
    note_pressures(constants, w, normal, h)
    if w[at.NORMAL_FORCE] < HARDLY * constants.mass * constants.gravity and w[at.FACE] == w[at.GROUND] == 0.0:
        ensure_dense(laws, parameters, constants, b, t, h)
        _normal_force_within(laws, constants, b, h)
    laws.note(laws, parameters, constants, b, t, h)
    first = w[at.SAMPLE] * constants.sample_period
    if first < w[at.CLOCK] + t + h:
        ensure_dense(laws, parameters, constants, b, t, h)
        while w[at.SAMPLE] * constants.sample_period < w[at.CLOCK] + t + h:
            time = w[at.SAMPLE] * constants.sample_period
            x = min(max((time - w[at.CLOCK] - t) / h, 0.0), 1.0)
            dense_state(b, x, b.spare)
            if not is_motion(constants, b.spare):
                return False
            take_sample(laws, parameters, constants, b, time, t + x * h, b.spare)
            w[at.SAMPLE] += 1.0
    return True


def note_peaks(constants: SimulationConstants, w: Any) -> None:
    """Keep the greatest magnitudes of the torques."""
    for joint in range(constants.joints):
        w[at.PEAK_ANKLE + joint] = max(w[at.PEAK_ANKLE + joint], abs(w[at.ANKLE + joint]))


def _asked(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, state: Sequence[float]
) -> Any:
    """Torques of the law in a state."""
    w, first = b.w, 2 * constants.angles
    for index in range(len(b.y) - first - constants.joints):
        b.memory[index] = state[first + index]
    return laws.asked(laws.torque, parameters, b.memory, min(max(t, w[at.AFTER]), w[at.BEFORE]), state)


def _peak_within(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float, joint: int
) -> None:
    """A joint's peak inside the step: the top of the parabola through a greatest value and its neighbours.

    It is climbed to from the stage at which the torque seemed greatest, in sixteenths of the step.
    """
    when = b.w[at.KEPT_WHEN_ANKLE + joint]
    piece = min(max(int(PIECES * (when - t) / h + 0.5), 1), PIECES - 1)
    middle = _torque_within(laws, parameters, constants, b, t, h, piece, joint)
    left = _torque_within(laws, parameters, constants, b, t, h, piece - 1, joint)
    right = _torque_within(laws, parameters, constants, b, t, h, piece + 1, joint)
    while abs(left) > abs(middle) and piece > 1:
        piece -= 1
        right, middle = middle, left
        left = _torque_within(laws, parameters, constants, b, t, h, piece - 1, joint)
    while abs(right) > abs(middle) and piece < PIECES - 1:
        piece += 1
        left, middle = middle, right
        right = _torque_within(laws, parameters, constants, b, t, h, piece + 1, joint)
    found = max(abs(left), abs(middle), abs(right), abs(_parabola_top(left, middle, right)))
    b.w[at.PEAK_ANKLE + joint] = max(b.w[at.PEAK_ANKLE + joint], found)


def _torque_within(
    laws: Laws, parameters: Any, constants: SimulationConstants, b: Buffers, t: float, h: float, piece: int, joint: int
) -> float:
    """A joint's torque so many sixteenths into the step, N m."""
    x = piece / PIECES
    dense_state(b, x, b.spare)
    return float(_asked(laws, parameters, constants, b, t + x * h, b.spare)[joint])


def _parabola_top(left: float, middle: float, right: float) -> float:
    """Extremum of the parabola through three values at equal distances, or 0 if it is not between the outer ones."""
    bend, lean = 0.5 * (left + right) - middle, 0.5 * (right - left)
    if abs(lean) >= 2.0 * abs(bend):
        return 0.0
    return middle - lean * lean / (4.0 * bend)


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
        before, after = PLACES[i] - PLACES[i - 1], PLACES[i + 1] - PLACES[i]
        middle = sign * k[IN_ORDER[i] * n + component]
        falling = (middle - sign * k[IN_ORDER[i - 1] * n + component]) / before
        rising = (sign * k[IN_ORDER[i + 1] * n + component] - middle) / after
        bend = (rising - falling) / (before + after)
        slope = falling + bend * before
        if -2.0 * bend * before < -slope < 2.0 * bend * after and middle - slope * slope / (4.0 * bend) < NEAR * spread:
            return True
    return False


def _total_variation(b: Buffers, n: int, component: int) -> float:
    """Sum of a work integral's ups and downs over the step."""
    y, total = b.y[component], 0.0
    last, x = y, 0.0
    power = dense_rate_at(b.dense, n, component, 0.0)
    for piece in range(1, PIECES + 1):
        end = piece / PIECES
        power_there = dense_rate_at(b.dense, n, component, end)
        if (power < 0.0) != (power_there < 0.0):
            low, high = x, end
            for _ in range(20):  # the integral is flat at the turn: 2^-24 of a step is more than enough
                middle = 0.5 * (low + high)
                if (dense_rate_at(b.dense, n, component, middle) < 0.0) == (power < 0.0):
                    low = middle
                else:
                    high = middle
            turn = dense_at(b.dense, n, component, y, low)
            total += abs(turn - last)
            last = turn
        x, power = end, power_there
    return float(total + abs(b.out[component] - last))


def note_ground_force(
    laws: Laws, constants: SimulationConstants, b: Buffers, pose: Any, state: Sequence[float], place: int
) -> None:
    """Least F_n and greatest |F_t / F_n| that the motion asks of the ground under the stance foot.

    F_n < 0 means that the ground would have to pull. Where the foot hardly presses on it the ratio is left out. `place`
    is that of the state's rates in `k`.
    """
    along, normal = _turned(b, laws.force_at(constants, b, pose, state, place))
    if b.w[at.FACE] != 0.0 or b.w[at.GROUND] != 0.0:  # what pushes at the swing foot does not at the stance foot
        push, x, z = b.w[at.PRESS], b.w[at.PUSHED_X], b.w[at.PUSHED_Z]
        along -= push * (x * b.w[at.COSINE] - z * b.w[at.SINE])
        normal -= push * (x * b.w[at.SINE] + z * b.w[at.COSINE])
    b.w[at.ALONG_NOW], b.w[at.NORMAL_NOW] = along, normal
    note_force(constants, b.w, along, normal)


def note_force(constants: SimulationConstants, w: Any, along: float, normal: float) -> None:
    """Keep the least F_n and the greatest |F_t / F_n| of a force along and normal to the stance foot's ground, N."""
    w[at.NORMAL_FORCE] = min(w[at.NORMAL_FORCE], normal)
    if normal > LIGHT_CONTACT * constants.mass * constants.gravity:
        w[at.FRICTION] = max(w[at.FRICTION], abs(along) / normal)


def note_pressures(constants: SimulationConstants, w: Any, before: float, h: float) -> None:
    """Take in where the centre of pressure was in a step of length h: at the stages, whose torques are known.

    The normal force, which changes slowly, is taken to change evenly from `before` (N) to what it is at the step's end.
    """
    change, light = w[at.NORMAL_NOW] - before, LIGHT_CONTACT * constants.mass * constants.gravity
    for i in range(len(ALL_IN_ORDER)):
        torque, normal = w[at.ANKLE_TORQUES + ALL_IN_ORDER[i]], before + ALL_PLACES[i] * change
        time = SHARES[i] * h
        note_pressure(w, at.PRESSURE_AHEAD, at.PRESSURE_TIMES, torque, normal, light, constants.length, time)
    w[at.ANKLE_TORQUES] = w[at.ANKLE_TORQUES + STAGES]  # where the next step begins


def _turned(b: Buffers, force: tuple[float, float]) -> tuple[float, float]:
    """Force on the feet along the stance foot's ground and normal to it, N, without a push at the hip."""
    force_x, force_z = force
    along = force_x * b.w[at.COSINE] - force_z * b.w[at.SINE]
    normal = force_x * b.w[at.SINE] + force_z * b.w[at.COSINE]
    if b.w[at.PUSH] != 0.0:  # is none of the ground's
        along -= b.w[at.PUSH] * b.w[at.COSINE]
        normal -= b.w[at.PUSH] * b.w[at.SINE]
    return along, normal


def _normal_force_within(laws: Laws, constants: SimulationConstants, b: Buffers, h: float) -> None:
    """Least F_n inside the step: the least of some values, and of the parabolas through it and its neighbours."""
    w = b.w
    last = before = 0.0
    for piece in range(PIECES + 1):
        x = piece / PIECES
        dense_state(b, x, b.spare)
        pose = laws.pose(b, b.spare)
        _, normal = _turned(b, laws.force_within(constants, b, pose, x, h))
        w[at.NORMAL_FORCE] = min(w[at.NORMAL_FORCE], normal)
        if piece > 1 and last < min(before, normal):
            w[at.NORMAL_FORCE] = min(w[at.NORMAL_FORCE], _parabola_top(before, last, normal))
        before, last = last, normal


def take_sample(
    laws: Laws,
    parameters: Any,
    constants: SimulationConstants,
    b: Buffers,
    time: float,
    t: float,
    state: Sequence[float],
) -> None:
    """Write a row of the samples: those of the robot's columns, then the controller's states."""
    w, torque = b.w, _asked(laws, parameters, constants, b, t, state)
    kept = w[at.ANKLE], w[at.HIP], w[at.KNEE]
    for joint in range(constants.joints):
        w[at.ANKLE + joint] = torque[joint]
    estimate = laws.slope_estimate(parameters, b.memory)
    laws.write_state(constants, b, b.samples[int(w[at.SAMPLES])], time, state, estimate)
    w[at.ANKLE], w[at.HIP], w[at.KNEE] = kept
    w[at.SAMPLES] += 1.0
