"""How long the next physics step is where something is about to strike: the foot the ground, or the knee its stop.

As for the compass biped (`mjbiped.engines.mujoco.step_size`): the step that is under way ends where the gap closes, one
short contact step makes the impact, and the steps before become shorter by a factor of 4 each.
"""

from __future__ import annotations

from collections.abc import Callable, MutableSequence, Sequence
from typing import Any, NamedTuple

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.contact_forces import Felt
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.state import KNEES, THIGHS, Constants, X, Z, end_of_leg
from mjbiped.engines.mujoco.leapfrog import effective_step
from mjbiped.engines.mujoco.step_size import DEPTH, HALVINGS, LOOK_AHEAD, MARGIN, SHORTER, SHORTEST, face_between
from mjbiped.terrain.profile import height_over_ground

STOPPED = 1e-9  # beyond its stop, to which a step leads the knee, rad
TOUCHING = 4.0  # steps are so many times shorter while the swing foot drags along the ground, ...
SLIDING = 16.0  # ... or on a riser's face, before which all are contact steps


class Lengths(NamedTuple):
    """Of two steps.

    Attributes:
        length: Of the step under way, s.
        following: Of the next one, as planned, s.
        reached: Whether the gap is closed at the step's end, and the next step makes the impact.
    """

    length: float
    following: float
    reached: bool


def approach(
    gap: Callable[..., float],
    constants: Any,
    u: Sequence[float],
    planned: float,
    shortest: float,
    usual: float,
) -> Lengths:
    """The steps that a gap asks for.

    Args:
        gap: (constants, u, t): what it is after a step of a length t in s, if it is made now; positive while it is
            open, as it is at 0.
        constants: For the gap.
        u: The same.
        planned: Length of the step under way as planned, s; it may become shorter, or half as long again.
        shortest: Of the contact step, s.
        usual: Of a step with nothing ahead, s.
    """
    shorter = max(planned / SHORTER, shortest)
    rest, part = 0.0, planned
    while part > shortest:
        part = max(part / SHORTER, shortest)
        rest += part
    above, below = 0.0, planned
    if gap(constants, u, below) > 0.0:
        below = LOOK_AHEAD * (planned + rest)
        if gap(constants, u, below) > 0.0:
            return Lengths(planned, usual, False)
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        if gap(constants, u, middle) > 0.0:
            above = middle
        else:
            below = middle
    if rest == 0.0:
        return Lengths(max(below, SHORTEST), shortest, True)
    if below > planned + rest:
        return Lengths(planned, planned, False)
    if below > rest:
        return Lengths(max(below - rest, SHORTEST), shorter, False)
    return Lengths(max(0.5 * below, SHORTEST), shorter, False)


def sooner(first: Lengths, second: Lengths, planned: float) -> Lengths:
    """What two gaps ask for together: nothing closes in the step but what is reached at its end.

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


def step_lengths(constants: Constants, u: MutableSequence[float], toe: Felt) -> Lengths:
    """How long this step and the next one are.

    Args:
        constants: The walk's.
        u: Its memory, with the accelerations of this step; it is noted whether the knee strikes in the next one.
        toe: What the swing foot feels.
    """
    planned, usual, shortest = u[events.PLANNED], constants.timestep, constants.contact_timestep
    if not constants.lands:
        strikes = u[at.OPENED] != 0.0 and u[at.LOCKED] == 0.0 and knee_after(u, usual) <= 0.0
        u[at.STRIKES_NEXT] = 1.0 if strikes else 0.0
        return Lengths(usual, usual, True)
    if u[events.NOTED] != 0.0 or u[at.STRUCK] != 0.0:
        return Lengths(planned, usual, False)
    if swing_height(constants, u, 0.0) > 0.0:
        found = approach(swing_gap, constants, u, planned, shortest, usual)
    elif toe.ground:
        found = Lengths(planned, max(usual / TOUCHING, shortest), False)
    elif swing_height(constants, u, planned) > swing_height(constants, u, 0.0):  # it has left the ground
        found = Lengths(planned, usual, False)
    else:
        found = Lengths(planned, shortest, True)
    if u[at.OPENED] != 0.0 and u[at.LOCKED] == 0.0:
        if knee_after(u, 0.0) > 0.0:
            stop = approach(stop_gap, constants, u, planned, shortest, usual)
        else:
            stop = Lengths(planned, shortest, True)
        found = sooner(found, stop, planned)
        u[at.STRIKES_NEXT] = 1.0 if stop.reached and stop.length == found.length else 0.0
    if constants.control_period > 0.0:
        due = u[events.NEXT_CONTROL] - u[events.TIME]
        if due < found.length - SHORTEST:
            u[at.STRIKES_NEXT] = 0.0
            found = Lengths(due, planned, False)
    if constants.stepped and not found.reached and _near_face(constants, u, found.length):
        if toe.face:
            return Lengths(found.length, max(usual / SLIDING, shortest), False)
        return Lengths(found.length, shortest, found.length <= shortest)
    return found


def after(u: Sequence[float], index: int, t: float) -> float:
    """A coordinate after a step of length t in s, if it is made now."""
    k = effective_step(u[events.PLAIN], u[events.LAST_STEP], t)
    return u[at.Q + index] + t * (u[at.QVEL + index] + k * u[at.QACC + index])


def _foot_after(constants: Constants, u: Sequence[float], t: float) -> tuple[float, float]:
    """Place of the swing foot then, x and z in m."""
    leg = 1 - at.stance_of(u)
    return end_of_leg(
        constants.links, after(u, X, t), after(u, Z, t), after(u, THIGHS[leg], t), after(u, KNEES[leg], t)
    )


def swing_height(constants: Constants, u: Sequence[float], t: float) -> float:
    """Its height over the ground, m."""
    x, z = _foot_after(constants, u, t)
    return height_over_ground(constants.places.profile, x, z)


def swing_gap(constants: Constants, u: Sequence[float], t: float) -> float:
    """What closes where a step may end for the foot's contact, m."""
    return swing_height(constants, u, t) + DEPTH


def knee_after(u: Sequence[float], t: float) -> float:
    """Flexion of the swing knee then, rad."""
    return after(u, KNEES[1 - at.stance_of(u)], t)


def stop_gap(constants: Constants, u: Sequence[float], t: float) -> float:  # noqa: ARG001 (as every gap)
    """What closes where a step may end for the knee's stop, rad."""
    return knee_after(u, t) + STOPPED


def _near_face(constants: Constants, u: Sequence[float], t: float) -> bool:
    """Whether the swing foot could touch a riser in the step after this one, which is of length t."""
    x, z = _foot_after(constants, u, t)
    further, _ = _foot_after(constants, u, t + 2.0 * constants.timestep)
    margin = MARGIN + abs(further - x)
    return face_between(constants.places, x, z, x - margin, x + margin, margin)
