"""What holds a linkage: the rows of J that a foot, a knee, a face or the ground adds to its equations.

A mode of the robot is a number of free angles, what the others follow (`Motion.free`, `Motion.follows`), and such rows.
The force or the impulse of each row stands behind the motion in the solution (`Motion.right`), in the rows' order.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.dynamics.linkage import END, PIVOT, ROOM, SYSTEM, hold, load_impact, solve_impact
from mjbiped.numerics.blocks import numbers, row

FREE, LOCKED, RESTING = 0, 1, 2
"""How the swing knee is: it bends freely, is locked since it has struck its stop, or is straight and rests on it. A leg
without a knee is always locked."""

HEEL, FLAT, TOE = -1, 0, 1
"""How the stance foot stands: flat, or on one of its edges, about which it turns. Feet without mass stand flat."""


def hold_pivot(linkage: Any, w: Any) -> None:
    """Let the stance foot stand, or roll, in an impact: two rows, the ground's impulse along it and normal to it."""
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[0], added[PIVOT] = 1.0, -linkage.radius
    hold(w, 0.0)
    add_row(w)
    row(w.matrix, w.size + w.held, SYSTEM)[1] = 1.0
    hold(w, 0.0)


def hold_end(linkage: Any, w: Any) -> None:
    """Let the swing foot stand, or begin to roll, in an impact: two rows likewise."""
    n, sines, cosines = linkage.segments, numbers(w.sines, ROOM), numbers(w.cosines, ROOM)
    along, ahead = row(linkage.levers, END, n), row(linkage.levers, END + 1, n)
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[0] = 1.0
    for i in range(n):
        added[PIVOT + i] = along[i] * cosines[i] - ahead[i] * sines[i]
    if n > 1:
        added[PIVOT + 1] -= linkage.radius
    hold(w, 0.0)
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[1] = 1.0
    for i in range(n):
        added[PIVOT + i] = -along[i] * sines[i] - ahead[i] * cosines[i]
    hold(w, 0.0)


def hold_joint(w: Any, upper: int, lower: int, share: float = 1.0) -> None:
    """Let a segment's rate be a share of another one's in an impact: 1 locks the joint, 0 stops the lower one."""
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[PIVOT + upper] -= share
    added[PIVOT + lower] += 1.0
    hold(w, 0.0)


def hold_mode(linkage: Any, w: Any) -> None:
    """Let the stance foot stand, and the angles that are not free follow the others, in an impact."""
    hold_pivot(linkage, w)
    for i in range(linkage.angles, linkage.segments):
        hold_joint(w, 0, i)
    for i in range(w.free, linkage.angles):
        hold_joint(w, w.free - 1, i, w.follows)


def stop_end(linkage: Any, w: Any, along: float, normal: float) -> None:
    """Let a surface stop the swing foot in an impact, without friction, along a direction in the ground's frame."""
    add_row(w)
    n, sines, cosines = linkage.segments, numbers(w.sines, ROOM), numbers(w.cosines, ROOM)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    line, ahead = row(linkage.levers, END, n), row(linkage.levers, END + 1, n)
    added[0], added[1] = along, normal
    for i in range(n):
        added[PIVOT + i] = along * (line[i] * cosines[i] - ahead[i] * sines[i])
        added[PIVOT + i] -= normal * (line[i] * sines[i] + ahead[i] * cosines[i])
    hold(w, 0.0)


def hold_contact(linkage: Any, w: Any, dq: Any, along: float, normal: float) -> None:
    """Let a surface hold the swing foot of a moving robot, without friction, along a direction in the ground's frame.

    The equations are `loaded`, with the sines and cosines of the free angles.
    """
    add_row(w)
    sines, cosines, added = numbers(w.sines, ROOM), numbers(w.cosines, ROOM), row(w.matrix, w.size + w.held, SYSTEM)
    line, ahead = row(w.levers, END, ROOM), row(w.levers, END + 1, ROOM)
    rest = 0.0
    added[0] = along * linkage.radius
    for i in range(linkage.angles):
        at, share = (i, 1.0) if i < w.free else (w.free - 1, w.follows)
        forward = line[i] * cosines[at] - ahead[i] * sines[at]
        upward = -line[i] * sines[at] - ahead[i] * cosines[at]
        added[at] += share * (along * forward + normal * upward)
        rest -= share * share * (along * upward - normal * forward) * dq[at] * dq[at]
    hold(w, rest)


def hold_stop(w: Any, upper: int, lower: int) -> None:
    """Let a moving robot's knee rest on its stop: the row's force is the torque with which the stop bends it."""
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[upper], added[lower] = -1.0, 1.0
    hold(w, 0.0)


def add_row(w: Any) -> None:
    """Let the row that is held next have zeros."""
    added = row(w.matrix, w.size + w.held, SYSTEM)
    for i in range(w.size):
        added[i] = 0.0


def land(linkage: Any, w: Any, y: Any, held: bool) -> None:
    """Solve the impact of a swing foot that comes to stand in a state; both knees are locked as they then are.

    Rates of the pivot and of all segments then stand in `right`, then the ground's impulse on the new stance foot.

    Args:
        linkage: The linkage.
        w: Its motion.
        y: Angles, rad, and rates, rad/s, before the impact.
        held: Whether the knee of the leg that leaves the ground is held as well.
    """
    load_impact(linkage, w, y)
    hold_end(linkage, w)
    if linkage.knees:
        hold_joint(w, 1, 2)
        if held:
            hold_joint(w, 0, 3)
    solve_impact(w)
    lumped = numbers(w.lumped, 5)
    if w.closed and linkage.segments == 2 and lumped[2] != 0.0:
        # The leg that leaves the ground keeps its angular momentum about the hip. The equations of the whole robot give
        # its rate with few digits where the leg has almost no mass.
        sines, cosines, rates = numbers(w.sines, ROOM), numbers(w.cosines, ROOM), numbers(w.right, SYSTEM)
        between = cosines[0] * cosines[1] + sines[0] * sines[1]
        rates[PIVOT] = ((lumped[1] + lumped[2]) * y[linkage.angles] - lumped[1] * between * rates[PIVOT + 1]) / lumped[
            2
        ]


def opens(linkage: Any, w: Any, y: Any) -> bool:
    """Whether that impact bends the knee of the leg that leaves the ground, where nothing but its stop holds it."""
    land(linkage, w, y, False)
    result = numbers(w.right, SYSTEM)
    return bool(result[PIVOT + 3] > result[PIVOT])


def partner(linkage: Any, segment: int) -> int:
    """The segment that takes a segment's role in a support transfer."""
    other = segment ^ 1
    return other if other < linkage.segments else segment


def bend_stance_knee(w: Any, upper: float, lower: float, flexion: float) -> None:
    """Let the stance leg be locked at a flexion, rad; its angle is that of the line from its foot to the hip.

    Args:
        w: The motion; its `offsets` are changed.
        upper: Length of the thigh, m.
        lower: Length of the shank, m.
        flexion: Of the stance knee, rad.
    """
    offsets, lean = numbers(w.offsets, ROOM), 0.0
    if flexion != 0.0:
        lean = math.atan2(upper * math.sin(flexion), lower + upper * math.cos(flexion))
    offsets[0], offsets[3] = lean - flexion, lean
