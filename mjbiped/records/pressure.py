"""The centre of pressure that the ankle's torque asks for, and the foot that would hold it.

The models' feet are points, on which no torque can act. A flat, massless foot under such a leg stands still only while
the ground's force, of the normal component F_n, goes through x = -τ₁ / F_n, measured from the ankle along the ground,
positive forward: that is the balance of moments about the ankle. Where x lies beyond the foot's end, it tips.

Engines keep the greatest distances of each step in the touchdowns' rows, and for how long x lies where in a table of
`BINS` bins of `WIDTH` leg lengths, half of them behind the ankle. The first and the last hold all that lies farther,
or where the ground would have to bear a torque without a force. Time without a torque is in no bin.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.records import stance_knee
from mjbiped.rules.termination import LIGHT_CONTACT

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

Floats: TypeAlias = NDArray[np.float64]

WIDTH = 0.01  # leg lengths
BINS = 130
HALF = BINS // 2
USUAL = 0.99
"""Share of the time for which a foot has to hold the centre of pressure, unless another is asked for."""


def bin_of(place: float) -> int:
    """The bin of a place of the centre of pressure, in leg lengths from the ankle; it may be infinite."""
    return math.floor(min(max(place / WIDTH, -float(HALF)), HALF - 1.0)) + HALF


def note_pressure(
    u: MutableSequence[float],
    ahead: int,
    times: int,
    torque: float,
    normal: float,
    light: float,
    leg_length: float,
    time: float,
) -> None:
    """Take in where the centre of pressure lies for a time.

    Args:
        u: An engine's memory of a walk.
        ahead: Index in it of the greatest distance ahead of the ankle, m; that behind it follows.
        times: Index of the first of the `BINS` times, s.
        torque: Of the ankle, N m.
        normal: Normal force of the ground, N.
        light: With a force no greater than this, N, the centre of pressure is as far away as can be.
        leg_length: m.
        time: For how long, s.
    """
    if normal > light:
        place = -torque / normal
        u[ahead], u[ahead + 1] = max(u[ahead], place), max(u[ahead + 1], -place)
    else:
        place = -math.copysign(math.inf, torque)
    if torque != 0.0:
        u[times + bin_of(place / leg_length)] += time


def unknown() -> Floats:
    """The times of a record that does not tell them."""
    return np.full(BINS, np.nan)


def centre_of_pressure(walk: Walk) -> Floats:
    """Where the ankle's torque asks for the centre of pressure at each sample, shape (samples,), m; see the module.

    The normal force is that of the equations of motion under the recorded torques: a push is none of them. NaN where
    the walk has diverged, and where the ground would have to pull.
    """
    robot, samples = walk.robot, walk.samples
    knees: dict[str, NDArray[np.generic]] = {}
    if robot.knees:
        knees = {"locked": samples["locked"], "stance_flexion": stance_knee.flexion(walk)}
    places = np.full(len(samples["time"]), math.nan)
    for k in np.flatnonzero(stance_knee.is_sound(walk)):
        q, dq, torque, slope = (samples[name][k] for name in ("q", "dq", "torque", "slope"))
        forward, upward = robot.ground_force(q, dq, torque, slope, **{name: of[k] for name, of in knees.items()})
        normal = forward * math.sin(slope) + upward * math.cos(slope)
        if normal > LIGHT_CONTACT * robot.weight:
            places[k] = -torque[0] / normal
    return places


class Sole(NamedTuple):
    """What a walk asks of a flat foot.

    Attributes:
        times: By bins of the centre of pressure's place, s.
        total: Time that was walked, s.
        ahead: Where it was at most ahead of the ankle, m.
        behind: The same behind it, m.
        leg_length: m.
    """

    times: Floats
    total: float
    ahead: float
    behind: float
    leg_length: float

    def length(self, share: float = USUAL) -> float:
        """Length of the shortest foot about the ankle that holds the centre of pressure for a share of the time, m.

        Within a bin the time is taken to be spread evenly. Infinite where no force bears the torque for longer than may
        be left out, NaN where the times are not known.
        """
        if np.isnan(self.times).any() or not self.total > 0.0:
            return math.nan
        left_out = (1.0 - share) * self.total
        edges = [
            np.minimum(np.arange(HALF) * WIDTH, max(most, 0.0) / self.leg_length) for most in (self.behind, self.ahead)
        ]
        beyond = [np.cumsum(side[::-1])[::-1] for side in (self.times[HALF - 1 :: -1], self.times[HALF:])]
        if beyond[0][-1] + beyond[1][-1] > left_out:
            return math.inf
        lengths = [_shortest(edges[k], beyond[k], edges[1 - k], beyond[1 - k], left_out) for k in (0, 1)]
        return float(min(lengths) * self.leg_length)


def _shortest(edges: Floats, beyond: Floats, other_edges: Floats, other_beyond: Floats, left_out: float) -> float:
    """Length of the shortest foot of which one end is at a bin's edge, in leg lengths.

    Args:
        edges: Of the bins on that side, from the ankle outwards, leg lengths.
        beyond: Time beyond each, s.
        other_edges: The same on the other side.
        other_beyond: The same.
        left_out: Time that may lie beyond either end together, s.
    """
    rest = left_out - beyond
    ends = np.interp(-rest, -other_beyond, other_edges)  # where just the rest lies beyond the other end
    possible = rest >= other_beyond[-1]
    return float(np.min((edges + ends)[possible], initial=math.inf))
