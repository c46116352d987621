"""How long the next physics step is where something is about to strike: the foot the ground, or the knee its stop.

As for the compass biped (`mjbiped.engines.mujoco.step_size`): the step that is under way ends where the gap closes, one
short contact step makes the impact, and the steps before become shorter by a factor of 4 each.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from mjbiped.engines.mujoco.step_size import HALVINGS, LOOK_AHEAD, SHORTER, SHORTEST


class Lengths(NamedTuple):
    """Of two steps.

    Attributes:
        length: Of the step under way, s.
        following: Of the next one, as planned, s.
        reached: Whether the gap is closed at the step's end, and the next step makes the impact.
    """

    length: float
    following: float
    reached: bool = False


def approach(gap: Callable[[float], float], planned: float, shortest: float, usual: float) -> Lengths:
    """The steps that a gap asks for.

    Args:
        gap: What it is after a step of a length in s, if it is made now; positive while it is open, as it is at 0.
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
    if gap(below) > 0.0:
        below = LOOK_AHEAD * (planned + rest)
        if gap(below) > 0.0:
            return Lengths(planned, usual)
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        if gap(middle) > 0.0:
            above = middle
        else:
            below = middle
    if rest == 0.0:
        return Lengths(max(below, SHORTEST), shortest, True)
    if below > planned + rest:
        return Lengths(planned, planned)
    if below > rest:
        return Lengths(max(below - rest, SHORTEST), shorter)
    return Lengths(max(0.5 * below, SHORTEST), shorter)


def sooner(first: Lengths, second: Lengths) -> Lengths:
    """What two gaps ask for together: nothing closes in the step but what is reached at its end."""
    if first.length > second.length:
        first, second = second, first
    reached = first.reached or (second.reached and second.length == first.length)
    return Lengths(first.length, min(first.following, second.following), reached)
