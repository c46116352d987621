"""Motion between touchdowns: rates of a state by law and linkage, integration steps, and forces of the ground."""

from __future__ import annotations

import math

from mjbiped.dynamics import integrate
from mjbiped.dynamics.equations import accelerate, load, settle
from mjbiped.dynamics.integrate import STAGES, STAGES_WITH_DENSE, value_at
from mjbiped.dynamics.linkage import END, HIP, ROOM, SYSTEM, ground_force, speed, stand
from mjbiped.dynamics.modes import FLAT, LOCKED, RESTING, TOE, hold_angle, hold_contact, hold_stop, push_contact
from mjbiped.engines.hybrid.meeting import level_angle
from mjbiped.engines.hybrid.state import Constants, State, linkage_of, pushed, sole_angle, to_memory, touches
from mjbiped.numerics.blocks import Floats, Numbers, call, numbers, row
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.rules.sole import bounded_by_own_force, moment_about_ankle, servo_torque
from mjbiped.rules.termination import AVERAGED, LIGHT_CONTACT
from mjbiped.terrain.profile import GROUND_FRICTION

SLOW = 1e-3
"""Slip, m/s, below which friction grows with it: edges slide with some 0.1 m/s."""
WILDEST_ANGLE = 1e6  # beyond it, rad, the motion has no meaning, and sine and cosine no digits


def rates(c: Constants, w: State, t: float, y: Floats, dy: Floats) -> None:
    """Write the rates of a state at time t since the support transfer, by the controller's law and the linkage."""
    n, joints, dq, ddq = c.angles, c.joints, numbers(w.dq, ROOM), numbers(w.ddq, ROOM)
    given, tame = row(w.given, w.stage, c.given), take_angles(c, w, y)
    ask(c, w, t, y, given)
    numbers(w.asked, STAGES_WITH_DENSE)[w.stage] = given[0]
    if c.behind < math.inf:
        numbers(w.normals, STAGES_WITH_DENSE)[w.stage] = bound_ankle(c, w, given)
    _move(c, w, given)
    if c.toe > 0.0:
        _bear(c, w, given)
    for i in range(n):
        dy[i], dy[n + i] = dq[i], ddq[i]
    if not tame:
        dy[n] = math.nan
    for i in range(c.states):
        dy[2 * n + i] = given[joints + i]
    first, turned = 2 * n + c.states, sole_angle(c, dq)
    for i in range(joints):
        dy[first + i] = given[i] * (dq[i] - turned)
        turned = dq[i]
    w.stage += 1


def take_angles(c: Constants, w: State, y: Floats) -> bool:
    """Write angles and rates of a state into `w.q` and `w.dq`, and those that a law is told.

    Returns:
        Whether the angles have a meaning; where not, zeros stand in place of all.
    """
    q, dq, n, tame = numbers(w.q, ROOM), numbers(w.dq, ROOM), c.angles, True
    told, told_rates = numbers(w.told, c.told), numbers(w.told_rates, c.told)
    for i in range(n):
        tame = tame and abs(y[i]) < WILDEST_ANGLE
    for i in range(n):
        q[i], dq[i] = (y[i], y[n + i]) if tame else (0.0, 0.0)
    tip = sole_angle(c, q)
    for i in range(c.told):
        told[i], told_rates[i] = q[i] - tip, dq[i]
    return tame


def ask(c: Constants, w: State, t: float, y: Floats, given: Floats) -> None:
    """Ask the law for torques and rates of its states in a state whose angles `take_angles` has taken."""
    to_memory(c, w, y)
    memory, told, told_rates = numbers(w.memory, c.states), numbers(w.told, c.told), numbers(w.told_rates, c.told)
    call(c.torque, c.parameters, memory, min(max(t, w.after), w.before), told, told_rates, given)


def bound_ankle(c: Constants, w: State, given: Floats) -> float:
    """Let the sole transmit what it can of the first of the torques; returns the normal force on the stance foot, N."""
    asked, force = given[0], _normal_force(c, w, given)
    if asked == 0.0:
        return force
    given[0] = 0.0
    given[0], force = bounded_by_own_force(asked, force, _normal_force(c, w, given), c.behind, c.ahead)
    return force


def _normal_force(c: Constants, w: State, given: Floats) -> float:
    """Normal force on the stance foot under torques, N."""
    _move(c, w, given)
    _, normal = stance_force(c, w, numbers(w.q, ROOM), numbers(w.dq, ROOM), numbers(w.ddq, ROOM))
    return normal


def _move(c: Constants, w: State, given: Floats) -> None:
    """Write the accelerations under torques into `w.ddq`, with the state in `w.q` and `w.dq`."""
    linkage, q, dq = linkage_of(c, w), numbers(w.q, ROOM), numbers(w.dq, ROOM)
    _write_forces(c, w, given)
    touched = touches(w)
    if not touched and w.locked != RESTING:
        accelerate(linkage, w, q, dq)
        return
    load(linkage, w, q, dq)
    if w.down != FLAT:
        rub_edge(c, w)
        hold_edge(c, w, False)
    elif touched:
        along, normal = pushed(w)
        hold_contact(linkage, w, dq, along, normal)
    if w.locked == RESTING:
        hold_stop(w, c.thigh, c.shank)
    settle(linkage, w)
    forces, first = numbers(w.right, SYSTEM), w.size
    if touched:
        w.press = forces[first]
        first += 1
    if w.locked == RESTING:
        w.stop_press = forces[first]


def _write_forces(c: Constants, w: State, given: Floats) -> None:
    """Write the generalised forces of torques, and of a push at the hip, into `w.ddq`, N m.

    The ankle acts between the stance leg and the ground, or its foot, each other joint between two segments.
    """
    forces, last = numbers(w.ddq, ROOM), c.joints - 1
    for i in range(last):
        forces[i] = given[i] - given[i + 1]
    forces[last] = given[last]
    if c.foot >= 0:
        forces[c.foot], forces[c.foot + 1] = -given[0], 0.0
    if w.down != FLAT:
        q, dq, foot = numbers(w.q, c.angles), numbers(w.dq, c.angles), c.foot
        torque = servo_torque(c.foot_stiffness, c.foot_damping, q[foot + 1] - q[foot], dq[foot + 1] - dq[foot])
        forces[1] += torque
        forces[c.foot + 1] = -torque
    if w.push != 0.0:
        q, along, ahead = numbers(w.q, ROOM), row(w.levers, HIP, ROOM), row(w.levers, HIP + 1, ROOM)
        forces[0] += w.push * linkage_of(c, w).radius * w.cosine
        for i in range(c.angles):
            sine, cosine = sine_cosine(q[i] + w.slope)
            forces[i] += w.push * (along[i] * cosine - ahead[i] * sine)


def stance_force(c: Constants, w: State, q: Numbers, dq: Numbers, ddq: Numbers) -> tuple[float, float]:
    """Force on the stance foot along its ground and normal to it, N, without what pushes the hip or the swing foot."""
    along, normal = ground_force(linkage_of(c, w), w, q, dq, ddq)
    if w.push != 0.0:
        along -= w.push * w.cosine
        normal -= w.push * w.sine
    if touches(w):
        x, z = pushed(w)
        along -= w.press * x
        normal -= w.press * z
    return along, normal


def _bear(c: Constants, w: State, given: Floats) -> None:
    """Note how the ground bears a stance foot that is a body, in the current stage of a step.

    About the ankle its moment is tau + h F_t, of a force at x = -(tau + h F_t) / F_n. A flat foot stays so while x lies
    on its sole.
    """
    along, normal = stance_force(c, w, numbers(w.q, ROOM), numbers(w.dq, ROOM), numbers(w.ddq, ROOM))
    moment, margin = moment_about_ankle(given[0], c.height, along), math.inf
    if w.edge != FLAT:
        moment = -c.toe * normal if w.edge == TOE else c.heel * normal
    elif normal > 0.0:
        margin = min(c.toe * normal + moment, c.heel * normal - moment)
    numbers(w.normals, STAGES_WITH_DENSE)[w.stage] = normal
    numbers(w.moments, STAGES_WITH_DENSE)[w.stage] = moment
    numbers(w.margins, STAGES_WITH_DENSE)[w.stage] = margin


def enter_mode(c: Constants, w: State) -> None:
    """Let the linkage move as knee and stance foot are now."""
    w.free = c.angles
    if c.foot >= 0 and w.down == FLAT:
        w.free = c.foot + abs(w.edge)
    elif c.shank != c.thigh and w.locked == LOCKED:
        w.free = c.shank
    w.follows = 1.0 if c.foot < 0 or w.edge != FLAT else 0.0
    stand(linkage_of(c, w), w)
    y = numbers(w.y, c.size)
    for i in range(w.free, c.angles):
        y[i], y[c.angles + i] = w.follows * y[w.free - 1], w.follows * y[c.angles + w.free - 1]


def start_step(c: Constants, w: State) -> None:
    """Compute the rates of the state in `w.y`, which no step has led to."""
    w.stage = 0
    rates(c, w, w.elapsed, numbers(w.y, c.size), row(w.k, 0, c.size))


def attempt(c: Constants, w: State, h: float) -> float:
    """Integrate one step of length h from `w.y` to `w.out`.

    Returns:
        The estimated error over the tolerance; NaN where the motion has no meaning.
    """
    w.has_dense, w.stage = False, 1
    w.evaluations += STAGES
    return integrate.step(rates, c, w, w.elapsed, h)


def carry_over(c: Constants, w: State) -> None:
    """Let the rates and torques at the end of a step be those at the start of the next."""
    start, end = row(w.k, 0, c.size), row(w.k, STAGES, c.size)
    for i in range(c.size):
        start[i] = end[i]
    first, last = row(w.given, 0, c.given), row(w.given, STAGES, c.given)
    for i in range(c.joints):
        first[i] = last[i]
    for values in (w.asked, w.normals, w.moments, w.margins):
        at_stages = numbers(values, STAGES_WITH_DENSE)
        at_stages[0] = at_stages[STAGES]


def ensure_dense(c: Constants, w: State, h: float) -> None:
    """Compute the step's dense output, unless it is there; forces of contacts stay those at the step's end."""
    if w.has_dense:
        return
    press, stop_press = w.press, w.stop_press
    integrate.dense(rates, c, w, w.elapsed, h)
    w.press, w.stop_press = press, stop_press
    w.has_dense = True
    w.evaluations += STAGES_WITH_DENSE - STAGES - 1


def is_motion(c: Constants, y: Floats) -> bool:
    """Whether angles and rates are numbers."""
    total = 0.0
    for i in range(2 * c.angles):
        total += y[i]
    return math.isfinite(total)


def write_state_at(c: Constants, w: State, x: float) -> None:
    """Write the state at the share x of the step into `w.spare`."""
    spare = numbers(w.spare, c.size)
    for i in range(c.size):
        spare[i] = value_at(c, w, i, x)


def push_from_ground(c: Constants, w: State, ratio: float) -> None:
    """Let the ground push the swing foot along its normal, and against the slip by a share of the normal force."""
    slope = numbers(c.angle, c.segments)[w.landing]
    w.pushed_x = math.sin(slope) - ratio * math.cos(slope)
    w.pushed_z = math.cos(slope) + ratio * math.sin(slope)


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


def note_impact(c: Constants, w: State) -> None:
    """Take the impulse that has led to the state, if one has, into the gait step's normal force and friction."""
    along, normal, time = w.impulse_along, w.impulse_normal, AVERAGED * c.pace
    if along != 0.0 or normal != 0.0:
        note_force(c, w, w.along_now + along / time, w.normal_now + normal / time)
        w.impulse_along = w.impulse_normal = 0.0


def hold_edge(c: Constants, w: State, sticks: bool) -> None:
    """Hold the edge of the swing foot that is down, which the ground pushes or which sticks, and a flat stance foot."""
    linkage, level, dq = linkage_of(c, w), level_angle(c, w, w.landing), numbers(w.dq, ROOM)
    sine, cosine = math.sin(level), math.cos(level)
    hold_contact(linkage, w, dq, sine, cosine)
    along, normal = pushed(w)
    push_contact(linkage, w, along, normal)
    if sticks:
        hold_contact(linkage, w, dq, cosine, -sine)
    if w.edge == FLAT:
        hold_angle(w, c.foot)


def rub_edge(c: Constants, w: State) -> None:
    """Let the ground push that edge along its normal, and with friction against its slip."""
    level = level_angle(c, w, w.landing)
    along, normal = speed(linkage_of(c, w), w, numbers(w.q, ROOM), numbers(w.dq, ROOM), END)
    slip = along * math.cos(level) - normal * math.sin(level)
    push_from_ground(c, w, GROUND_FRICTION * slip / math.sqrt(slip * slip + SLOW * SLOW))
