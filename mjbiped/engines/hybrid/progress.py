"""Whether a gait step of the hybrid engine gets on: a torque that switches would keep it busy without end.

Where a torque jumps, integration steps shrink until its jump is no more than the tolerance, and then grow again. Where
it jumps to and fro without end (a torque by the sign of a rate, which it brings to zero), they never do, and the motion
all but stands still. Gains beyond what any robot has are of the same effect.
"""

from __future__ import annotations

from mjbiped.dynamics.integrate import STAGES
from mjbiped.engines.hybrid.state import Constants, State
from mjbiped.numerics.blocks import numbers

MOST_ATTEMPTS = 100_000  # integration steps tried in one gait step; the paper's controller needs some 20
ATTEMPTS_BETWEEN_LOOKS = 2000
LEAST_PROGRESS = 2e-3
"""Between two looks, of the stall time: at this pace a gait step would need ten times `MOST_ATTEMPTS`."""

TAME = 1e3
"""Of the legs' rates, in sqrt(g / l): the robot moves, and is not about to fly apart."""


def watch(w: State) -> None:
    """Begin to watch a gait step."""
    w.under_way, w.looked = True, 0.0
    w.step_started = w.evaluations
    w.look = w.step_started + STAGES * ATTEMPTS_BETWEEN_LOOKS


def lags(c: Constants, w: State) -> bool:
    """Whether a gait step takes too many integration steps, or the last of them have brought it on too little."""
    progress = w.elapsed - w.looked
    w.looked, w.look = w.elapsed, w.evaluations + STAGES * ATTEMPTS_BETWEEN_LOOKS
    tried = w.evaluations - w.step_started
    return bool(tried > STAGES * MOST_ATTEMPTS or progress < LEAST_PROGRESS * c.stall_time)


def is_tame(c: Constants, w: State) -> bool:
    """Whether the robot moves as robots do."""
    y, rates = numbers(w.y, c.size), 0.0
    for i in range(c.angles):
        rates += abs(y[c.angles + i])
    return bool(rates < TAME / c.pace)
