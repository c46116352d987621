"""What the motion and its impacts ask of the ground under the stance foot.

An impulse's ratio alone says little, for the slightest touch has that of a strong one. What counts is whether a real
foot would slide or hop: so the impulse of an impact is spread over a short time, `AVERAGED`, as MuJoCo's forces are,
and added to the force after it.
"""

from __future__ import annotations

import math
from itertools import pairwise

from mjbiped.dynamics.integrate import IN_ORDER, PLACES, STAGES_WITH_DENSE, rate_at
from mjbiped.dynamics.linkage import ROOM, ground_force
from mjbiped.engines.hybrid.motion import stance_force, write_state_at
from mjbiped.engines.hybrid.state import Constants, State, linkage_of
from mjbiped.numerics.blocks import Floats, numbers, row
from mjbiped.records.loads import BINS, note_pressure
from mjbiped.rules.termination import AVERAGED, LIGHT_CONTACT

PIECES = 16  # of a step, in which a change of the power's sign, a peak or the least force is looked for
_BOUNDS = (0.0, *(0.5 * (near + far) for near, far in pairwise(PLACES)), 1.0)
SHARES = tuple(far - near for near, far in pairwise(_BOUNDS))  # of the step, one for each stage


def note_ground_force(c: Constants, w: State, y: Floats, rates: Floats) -> None:
    """Keep the least F_n and the greatest |F_t / F_n| that the motion asks of the ground under the stance foot.

    F_n < 0 means that the ground would have to pull. Where the foot hardly presses on it the ratio is left out.

    Args:
        c: The walk's constants.
        w: Its state.
        y: A state of motion.
        rates: Its rates.
    """
    dq, ddq = numbers(w.dq, ROOM), numbers(w.ddq, ROOM)
    for i in range(c.angles):
        dq[i], ddq[i] = y[c.angles + i], rates[c.angles + i]
    w.along_now, w.normal_now = stance_force(c, w, y, dq, ddq)
    note_force(c, w, w.along_now, w.normal_now)


def note_force(c: Constants, w: State, along: float, normal: float) -> None:
    """Keep the least F_n and the greatest |F_t / F_n| of a force along and normal to the stance foot's ground, N."""
    w.normal_force = min(w.normal_force, normal)
    if normal > LIGHT_CONTACT * c.weight:
        w.friction = max(w.friction, abs(along) / normal)


def note_least_force(c: Constants, w: State, h: float) -> None:
    """Keep the least F_n inside the step: that of some moments, and of the parabolas through the least of them."""
    y, dq, ddq = numbers(w.spare, c.size), numbers(w.dq, ROOM), numbers(w.ddq, ROOM)
    last = before = 0.0
    for piece in range(PIECES + 1):
        x = piece / PIECES
        write_state_at(c, w, x)
        for i in range(c.angles):
            dq[i], ddq[i] = y[c.angles + i], rate_at(c, w, c.angles + i, x) / h
        _, normal = ground_force(linkage_of(c, w), w, y, dq, ddq)
        normal -= w.push * w.sine
        w.normal_force = min(w.normal_force, normal)
        if piece > 1 and last < min(before, normal):
            w.normal_force = min(w.normal_force, parabola_top(before, last, normal))
        before, last = last, normal


def parabola_top(left: float, middle: float, right: float) -> float:
    """Extremum of the parabola through three values at equal distances, or 0 if it is not between the outer ones."""
    bend, lean = 0.5 * (left + right) - middle, 0.5 * (right - left)
    if abs(lean) >= 2.0 * abs(bend):
        return 0.0
    return middle - lean * lean / (4.0 * bend)


def note_pressures(c: Constants, w: State, before: float, h: float) -> None:
    """Keep where the centre of pressure was in a step of length h: at the stages, whose torques are known.

    The normal force, which changes slowly, is taken to change evenly from `before` (N) to what it is at the step's end;
    on a sole it is known at each stage, as is its moment on feet that are bodies.
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


def note_impact(c: Constants, w: State) -> None:
    """Take the impulse that has led to the state, if one has, into the gait step's normal force and friction."""
    along, normal, time = w.impulse_along, w.impulse_normal, AVERAGED * c.pace
    if along != 0.0 or normal != 0.0:
        note_force(c, w, w.along_now + along / time, w.normal_now + normal / time)
        w.impulse_along = w.impulse_normal = 0.0
