"""What holds a linkage: the rows of J that a foot, a knee, a face or the ground adds to its equations.

A mode of the robot is a number of free angles, what the others follow (`Motion.free`, `Motion.follows`), and such rows.
The force or the impulse of each row stands behind the motion in the solution (`Motion.right`), in the rows' order.
"""

from __future__ import annotations

import math

from mjbiped.dynamics.equations import hold, solve
from mjbiped.dynamics.linkage import END, MASS, ROOM, SYSTEM, Linkage, Motion
from mjbiped.numerics.blocks import Numbers, numbers, row
from mjbiped.numerics.trigonometry import sine_cosine

FREE, LOCKED, RESTING = 0, 1, 2
"""How the swing knee is: it bends freely, is locked since it has struck its stop, or is straight and rests on it. A leg
without a knee is always locked."""

HEEL, FLAT, TOE = -1, 0, 1
"""How the stance foot stands: flat, or on one of its edges, about which it turns. Feet without mass stand flat."""


def hold_contact(linkage: Linkage, w: Motion, dq: Numbers, along: float, normal: float) -> None:
    """Let a surface hold the swing foot of a moving robot, without friction, along a direction in the ground's frame.

    The equations are `loaded`, with the sines and cosines of the free angles.
    """
    add_row(w)
    added, rest = row(w.matrix, w.size + w.held, SYSTEM), 0.0
    added[0] = along * linkage.radius
    for i in range(linkage.angles):
        at, share, forward, upward = _foot_lever(w, i)
        added[at] += share * (along * forward + normal * upward)
        rest -= share * share * (along * upward - normal * forward) * dq[at] * dq[at]
    hold(w, rest)


def push_contact(linkage: Linkage, w: Motion, along: float, normal: float) -> None:
    """Let the force of the contact that has been held last act along another direction: that of friction beside it."""
    place = w.size + w.held - 1
    for i in range(w.size):
        row(w.matrix, i, SYSTEM)[place] = 0.0
    for i in range(linkage.angles):
        at, share, forward, upward = _foot_lever(w, i)
        row(w.matrix, at, SYSTEM)[place] -= share * (along * forward + normal * upward)


def _foot_lever(w: Motion, i: int) -> tuple[int, float, float, float]:
    """The free angle with which one of a state moves, by which factor, and how it moves the swing foot, m."""
    at, share = (i, 1.0) if i < w.free else (w.free - 1, w.follows)
    sine, cosine = numbers(w.sines, ROOM)[at], numbers(w.cosines, ROOM)[at]
    line, ahead = row(w.levers, END, ROOM)[i], row(w.levers, END + 1, ROOM)[i]
    return at, share, line * cosine - ahead * sine, -line * sine - ahead * cosine


def hold_stop(w: Motion, upper: int, lower: int) -> None:
    """Let a knee be locked, or rest on its stop: the row's force is the torque with which the stop bends it."""
    add_row(w)
    added = row(w.matrix, w.size + w.held, SYSTEM)
    added[upper], added[lower] = -1.0, 1.0
    hold(w, 0.0)


def hold_angle(w: Motion, angle: int) -> None:
    """Let a foot lie flat."""
    add_row(w)
    row(w.matrix, w.size + w.held, SYSTEM)[angle] = 1.0
    hold(w, 0.0)


def add_row(w: Motion) -> None:
    """Let the row that is held next have zeros."""
    added = row(w.matrix, w.size + w.held, SYSTEM)
    for i in range(w.size):
        added[i] = 0.0


def land(linkage: Linkage, flat: Linkage, w: Motion, y: Numbers, held: bool) -> tuple[float, float, float]:
    """Solve the impact of a swing foot that comes to stand in a state; its knee is locked as it then is.

    The momenta of the segments about that foot, which the ground's impulse leaves as they are, make the rates after it.
    Those stand in `right`, of the segments in their new roles.

    Args:
        linkage: The linkage as it stands before the impact.
        flat: The linkage on a flat foot, as which it stands after it.
        w: Its motion.
        y: Angles, rad, and rates, rad/s, before the impact.
        held: Whether the knee of the leg that leaves the ground is held as well.

    Returns:
        The ground's impulse on the new stance foot, along the ground and normal to it, N s, and the rate at which the
        other foot leaves the ground, m/s.
    """
    n, rates, right = linkage.segments, numbers(w.ddq, ROOM), numbers(w.right, SYSTEM)
    x, z = _take_segments(linkage, w, y)
    along, ahead = _moved(flat, w, MASS, rates)
    along, ahead = along + flat.mass * x, ahead + flat.mass * z
    for i in range(n):
        forward, upward = _lever(flat, w, MASS, i)
        matrix, even, odd = row(w.matrix, i, SYSTEM), row(flat.even, i, n), row(flat.odd, i, n)
        right[i] = forward * x + upward * z
        for j in range(n):
            sine, cosine = _turned(w, i, j)
            matrix[j] = even[j] * cosine + odd[j] * sine
            right[i] += matrix[j] * rates[j]
    _roll(flat, w, along)
    w.size, w.held = n, 0
    if flat.knees:
        hold_stop(w, 0, 3)
        if held:
            hold_stop(w, 1, 2)
    solve(w)
    if flat.knees:
        right[3] = right[0]  # to the last digit
        if held:
            right[2] = right[1]
    x, z = _moved(flat, w, MASS, right)
    _, leaves = _moved(flat, w, END, right)
    return x + flat.mass * flat.radius * right[0] - along, z - ahead, leaves


def _take_segments(linkage: Linkage, w: Motion, y: Numbers) -> tuple[float, float]:
    """Write sine, cosine and rate of each segment in its role after a support transfer.

    Returns:
        Velocity of the foot that is to stand, along the ground and normal to it, m/s.
    """
    n, offsets, rates = linkage.segments, numbers(w.offsets, ROOM), numbers(w.ddq, ROOM)
    sines, cosines = numbers(w.sines, ROOM), numbers(w.cosines, ROOM)
    for i in range(n):
        angle = i if i < linkage.angles else 0
        sines[i], cosines[i] = sine_cosine(y[angle] + offsets[i])
        rates[i] = y[linkage.angles + angle]
    x, z = _moved(linkage, w, END, rates)
    x += linkage.radius * rates[0]
    for i in range(0, n - 1, 2):
        sines[i], sines[i + 1] = sines[i + 1], sines[i]
        cosines[i], cosines[i + 1] = cosines[i + 1], cosines[i]
        rates[i], rates[i + 1] = rates[i + 1], rates[i]
    if linkage.between != 0.0:
        sines[0], cosines[0] = sine_cosine(y[0] - linkage.between)
    return x, z


def _lever(linkage: Linkage, w: Motion, which: int, i: int) -> tuple[float, float]:
    """Derivatives of a point's place, or of the first moments of mass, by the angle of a segment."""
    along, ahead = row(linkage.levers, which, linkage.segments)[i], row(linkage.levers, which + 1, linkage.segments)[i]
    sine, cosine = numbers(w.sines, ROOM)[i], numbers(w.cosines, ROOM)[i]
    return along * cosine - ahead * sine, -along * sine - ahead * cosine


def _moved(linkage: Linkage, w: Motion, which: int, rates: Numbers) -> tuple[float, float]:
    """What rates of the segments make of a point's velocity, or of the momentum, about the pivot."""
    x = z = 0.0
    for i in range(linkage.segments):
        forward, upward = _lever(linkage, w, which, i)
        x += forward * rates[i]
        z += upward * rates[i]
    return x, z


def _turned(w: Motion, i: int, j: int) -> tuple[float, float]:
    """Sine and cosine of the angle of a segment less that of another one."""
    sines, cosines = numbers(w.sines, ROOM), numbers(w.cosines, ROOM)
    return sines[i] * cosines[j] - cosines[i] * sines[j], cosines[i] * cosines[j] + sines[i] * sines[j]


def _roll(linkage: Linkage, w: Motion, along: float) -> None:
    """Let the new stance foot roll, which takes the robot's momentum along the ground, N s, into that of its leg."""
    right, first = numbers(w.right, SYSTEM), row(w.matrix, 0, SYSTEM)
    if linkage.radius == 0.0:
        return
    for i in range(linkage.segments):
        forward, _ = _lever(linkage, w, MASS, i)
        first[i] += linkage.radius * forward
        row(w.matrix, i, SYSTEM)[0] += linkage.radius * forward
    first[0] += linkage.radius * linkage.radius * linkage.mass
    right[0] += linkage.radius * along


def opens(linkage: Linkage, flat: Linkage, w: Motion, y: Numbers) -> bool:
    """Whether that impact bends the knee of the leg that leaves the ground, where nothing but its stop holds it."""
    land(linkage, flat, w, y, False)
    result = numbers(w.right, SYSTEM)
    return bool(result[2] > result[1])


def bend_stance_knee(w: Motion, upper: float, lower: float, flexion: float) -> None:
    """Let the stance leg be locked at a flexion, rad; its angle is that of the line from its foot to the hip.

    Args:
        w: The motion; its `offsets` are changed.
        upper: Length of the thigh, m.
        lower: Length of the shank, m.
        flexion: Of the stance knee, rad.
    """
    offsets, (_, lean) = numbers(w.offsets, ROOM), bent_leg(upper, lower, flexion)
    offsets[0], offsets[3] = lean - flexion, lean


def bent_leg(upper: float, lower: float, flexion: float) -> tuple[float, float]:
    """A leg whose knee is bent: its length from foot to hip, and how far its shank leans forward of that line.

    A leg that stands bent is told by the angle of the line from its foot to the hip. Its shank's angle is that plus the
    lean, its thigh's that plus the lean less the flexion.

    Args:
        upper: Length of the thigh, m.
        lower: Length of the shank, m.
        flexion: Of the knee, rad.

    Returns:
        Length, m, and lean, rad.
    """
    along, across = lower + upper * math.cos(flexion), upper * math.sin(flexion)
    # hypot has other last bits compiled
    return math.sqrt(along * along + across * across), math.atan2(across, along)
