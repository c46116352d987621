r"""Landing on impacts: the length of each physics step, and the damping of its contacts.

With steps of one length a touchdown falls between two steps. The foot then sinks into the ground before its contact
counts, and the rates after the impact err by up to 11 %. So mjbiped ends a step where the foot meets the ground, and
one short *contact step* makes the impact. The accelerations a, which the solver has found, lead in MuJoCo's Euler step
to the rates and positions

.. math:: v' = v + k \, a, \qquad x' = x + t \, v'

From this equation the length t that leads to the ground is computed exactly, before the integrator reads
`opt.timestep` and `qacc`.

**Effective step.** The length k is the time for which accelerations act. In steps of one length k = t, as in MuJoCo.
Where the length changes, k is the mean of this step's length and the previous step's length. After an impact k is half
of this step's length, because the rates after an impact belong to the impact's end. With k = t each gait step would
begin and end with rates that err by t a / 2. So where k differs from t, `qacc` is scaled by k / t before the integrator
uses `qacc`.

**Approach.** Before the touchdown each step is a quarter as long as the previous step: the rates that enter the impact
are half a step old, and a stance foot that has lost its contact falls during the step.

**Damping.** A contact has the damping 1 / k, so that the contact is plastic within the step. The solver needs this
damping before the step's length is known. So the length is *planned* one step ahead and kept in userdata. A step may
become shorter than planned, and the step that lands also half as long again.

**Faces.** Contact steps begin a step or two before the swing foot can meet a riser's face. While the foot slides on the
face, steps last `Constants.sliding`. Where the scuffing rule lets the foot collide only once the foot is already at the
face, the current long step is cut at once: in the first short step after a long step accelerations act for half of the
long step, and the damping for a short step would throw the foot back fifty times as fast as the foot came.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from mjbiped.engines.mujoco.collisions import SHORTEST
from mjbiped.engines.mujoco.constants import Constants, end_of_leg, stance_leg, swing_leg
from mjbiped.engines.mujoco.feet import Felt, read_contacts
from mjbiped.engines.mujoco.state import State, X, Z, effective_step
from mjbiped.numerics.blocks import borrowed, numbers
from mjbiped.rules.termination import STALL_TIME
from mjbiped.terrain.profile import height_over_ground, segment_under

DEPTH = 1e-6  # under the ground to which a step leads the swing foot, m; single precision of a heightfield is 3e-7
STOPPED = 1e-9  # beyond its stop, to which a step leads the knee, rad
SHORTER = 4.0  # factor between the steps of the approach
MARGIN = 1e-3  # about a riser's face, m
HALVINGS = 50  # of a step, until only rounding is left
LOOK_AHEAD = 1.5
"""Times the distance to the ground that a step and its approach may take: it is foreseen a step earlier."""
TOUCHING = 4.0  # steps are so many times shorter while the swing foot drags along the ground, ...
SLIDING = 16.0  # ... or on a riser's face, where it may do so


class Lengths(NamedTuple):
    """Lengths of two steps.

    Attributes:
        length: Of the step under way, s.
        following: Of the next one, as planned, s.
        reached: Whether the gap is closed at the step's end, and the next step makes the impact.
    """

    length: float
    following: float
    reached: bool


def resolve(c: Constants, u: State, struck: float, ahead: float) -> None:
    """Take in what the step under way has shown: its contacts' forces. Say how long it is, and plan the next one.

    Accelerations are scaled to the time for which they act.

    Args:
        c: The walk's constants; MuJoCo's data hold the step's accelerations and sensor data.
        u: State.
        struck: Whether the knee was locked at its stop in the step.
        ahead: In steps of one length, how many of them later a knee can be locked.
    """
    qacc, readings = numbers(c.qacc, c.nq), borrowed(c.sensordata, c.nsensordata)
    for index in range(c.nq):
        u.qacc[index] = qacc[index]
    u.struck, u.strikes = struck, 0.0
    found = step_lengths(c, u, read_contacts(c, u, readings), ahead)
    length = found.length
    u.effective_step = effective_step(u, length)
    note_lag(c, u, length)
    u.planned, u.plain = found.following, 1.0 if found.reached else 0.0
    weight = u.effective_step / length
    if weight != 1.0:
        for index in range(c.nq):
            qacc[index] *= weight
    numbers(c.timestep, 1)[0] = length


def step_lengths(c: Constants, u: State, toe: Felt, ahead: float) -> Lengths:
    """How long this step and the next one are.

    Args:
        c: The walk's constants.
        u: State, with the accelerations of this step; it is noted whether the knee strikes in the next one.
        toe: What the swing foot feels.
        ahead: See `resolve`.
    """
    planned, usual, shortest = u.planned, c.longest, c.shortest
    free = u.opened != 0.0 and not u.locked and not u.noted
    if not c.lands:
        u.strikes = 1.0 if free and knee_after(c, u, ahead * usual) <= 0.0 else 0.0
        return Lengths(usual, usual, True)
    found = _to_the_ground(c, u, toe)
    if u.struck:
        return found
    if free:
        opened = knee_after(c, u, 0.0) > 0.0
        stop = approach(knee_after, STOPPED, c, u) if opened else Lengths(planned, shortest, True)
        found = sooner(found, stop, planned)
        u.strikes = 1.0 if stop.reached and stop.length == found.length else 0.0
    # an impact is not cut in two; the tick waits for its end
    if c.control_period > 0.0 and not u.noted:
        due = u.next_control - u.time
        if due < found.length - SHORTEST:
            u.strikes = 0.0
            found = Lengths(due, planned, False)
    return _at_a_face(c, u, toe, found)


def _to_the_ground(c: Constants, u: State, toe: Felt) -> Lengths:
    """What the gap between the swing foot and the ground asks for."""
    planned, usual, shortest = u.planned, c.longest, c.shortest
    if u.noted or u.struck or not u.enabled:
        return Lengths(planned, usual, False)
    height = swing_height(c, u, 0.0)
    if height > 0.0:
        return approach(swing_height, DEPTH, c, u)
    if toe.ground:
        return Lengths(planned, max(usual / TOUCHING, shortest), False)
    if swing_height(c, u, planned) > height:  # it has left the ground
        return Lengths(planned, usual, False)
    return Lengths(planned, shortest, True)  # it lies lower than where its contact should have been felt


def _at_a_face(c: Constants, u: State, toe: Felt, found: Lengths) -> Lengths:
    """What a riser near the swing foot makes of the lengths that were found."""
    shortest = c.shortest
    if not (c.stepped and u.enabled):
        return found
    length, following, reached = found
    if not u.noted and length > c.sliding:
        here, _ = foot_after(c, u, 0.0)
        x, z = foot_after(c, u, length)
        if face_between(c, x, z, min(here, x) - MARGIN, max(here, x) + MARGIN, MARGIN):
            length = shortest
    if not reached:
        x, z = foot_after(c, u, length)
        further, _ = foot_after(c, u, length + 2.0 * c.longest)
        margin = MARGIN + abs(further - x)  # within which it could touch a riser in the step after this one
        if face_between(c, x, z, x - margin, x + margin, margin):
            # the first of them still has half a long step's accelerations to come
            following = c.sliding if toe.face else shortest
            reached = length <= shortest and following <= shortest
    return Lengths(length, following, reached)


def approach(gap: Callable[..., float], beyond: float, c: Constants, u: State) -> Lengths:
    """The steps that a gap asks for.

    Args:
        gap: (c, u, t): what it is after a step of a length t in s, if it is made now.
        beyond: Negative gap to which a step leads; less than that the gap is open, as it is at 0.
        c: The walk's constants.
        u: State. The step under way may become shorter than planned, or half as long again.
    """
    planned, usual, shortest = u.planned, c.longest, c.shortest
    shorter = max(planned / SHORTER, shortest)
    rest, part = 0.0, planned  # of the approach
    while part > shortest:
        part = max(part / SHORTER, shortest)
        rest += part
    above, below = 0.0, planned
    if gap(c, u, below) + beyond > 0.0:
        below = LOOK_AHEAD * (planned + rest)  # which may be behind an edge already
        if gap(c, u, below) + beyond > 0.0:
            return Lengths(planned, usual, False)
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        if gap(c, u, middle) + beyond > 0.0:
            above = middle
        else:
            below = middle
    if rest == 0.0:
        return Lengths(max(below, SHORTEST), shortest, True)  # it lands; the next step is the contact step
    if below > planned + rest:
        return Lengths(planned, planned, False)
    if below > rest:
        return Lengths(max(below - rest, SHORTEST), shorter, False)
    return Lengths(max(0.5 * below, SHORTEST), shorter, False)  # seen late, behind an edge


def sooner(first: Lengths, second: Lengths, planned: float) -> Lengths:
    """Combine what two gaps ask for: nothing closes in the step but what is reached at its end.

    Args:
        first: What one asks for.
        second: What the other does.
        planned: Length of the step as planned, s: a gap that asks for no less stays open for half as long again.
    """
    if first.length > second.length:
        first, second = second, first
    if second.reached and not first.reached and first.length >= planned:
        return second
    reached = first.reached or (second.reached and second.length == first.length)
    return Lengths(first.length, min(first.following, second.following), reached)


def after(u: State, index: int, t: float) -> float:
    """A coordinate after a step of length t in s, if it is made now."""
    k = effective_step(u, t)
    return float(u.q[index] + t * (u.qvel[index] + k * u.qacc[index]))


def foot_after(c: Constants, u: State, t: float) -> tuple[float, float]:
    """Place of the swing foot after such a step, x and z in m."""
    leg = swing_leg(c, u)
    flexion = after(u, leg.knee, t) if leg.knee >= 0 else 0.0
    return end_of_leg(leg, after(u, X, t), after(u, Z, t), after(u, leg.hip, t), flexion)


def swing_height(c: Constants, u: State, t: float) -> float:
    """Height of the swing foot over the ground after such a step, m."""
    x, z = foot_after(c, u, t)
    return height_over_ground(c, x, z)


def knee_after(c: Constants, u: State, t: float) -> float:
    """Flexion of the swing knee after such a step, rad."""
    return after(u, swing_leg(c, u).knee, t)


def face_between(c: Constants, x: float, z: float, low: float, high: float, margin: float) -> bool:
    """Whether the face behind or ahead of a foot at x, z lies between two places, and the foot no higher than that."""
    starts, heights, rises = numbers(c.x, c.segments), numbers(c.z, c.segments), numbers(c.rises, c.segments)
    segment = segment_under(c, x)
    for index in range(segment, min(segment + 2, c.segments)):
        rise, top = rises[index], heights[index]
        if rise != 0.0 and low < starts[index] < high and z < max(top, top - rise) + margin:
            return True
    return False


def note_lag(c: Constants, u: State, length: float) -> None:
    """Note what the rates will lack after this step.

    Args:
        c: The walk's constants.
        u: State, after `bearing.read_contacts` of this time.
        length: Of the step, s.
    """
    impact = u.noted or u.struck or u.plain
    lag = 0.0 if impact else 0.5 * length  # rates after an impact are those of its end
    falling = (STALL_TIME / c.stall_time) * (STALL_TIME / c.stall_time)
    for index in range(2, c.nq):  # the hip's is not shown
        acceleration = u.qacc[index]
        if u.smooth:
            before = u.acceleration[index]
            room = abs(before) + falling
            acceleration = min(max(acceleration, before - room), before + room)
        u.lag[index] = lag * acceleration
    u.smooth = 0.0 if impact else 1.0
    if c.knee_stiffness > 0.0:
        # a stop that is shown a rate of now leaves a knee that lies against it swinging, and off it now and then
        u.lag[stance_leg(c, u).knee] = 0.0
