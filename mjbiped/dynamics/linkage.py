"""Any planar linkage of rigid segments on one foot: its constants, how it moves in a mode, its points and momentum.

Each segment has one angle, absolute: from the normal of the ground, rad, positive forward. A point of the robot stands
at the sum, over the segments, of a lever along the segment's line and one a right angle ahead of it, so that

    (x, z) = sum_j (along_j sin q_j + ahead_j cos q_j, along_j cos q_j - ahead_j sin q_j)

from the pivot: the point foot, the edge of a flat one, or the centre of a round one's arc, which rolls by radius dq_0.
Summed up over the bodies k, with the levers as complex numbers l_kj = along + i ahead,

    M_ij = A_ij cos(q_i - q_j) + B_ij sin(q_i - q_j),   A_ij + i B_ij = sum_k m_k conj(l_ki) l_kj,
    C_ij = (A_ij sin(q_i - q_j) - B_ij cos(q_i - q_j)) dq_j,

plus the inertia of segment i in A_ii; gravity, the ground's force and rolling take the first moments sum_k m_k l_kj.
`mjbiped.dynamics.equations` solves the equations, and `mjbiped.dynamics.modes` has the rows that hold the robot.

The functions run in plain Python and as machine code. `linkage` is a `Linkage`, `w` a block with a `Motion`'s fields.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from mjbiped.numerics.blocks import Floats, Numbers, numbers, row
from mjbiped.numerics.trigonometry import sine_cosine

ROOM = 4
"""Most angles, and most segments."""

SYSTEM = ROOM + 3
"""Most equations at once: angles, and rows that hold them."""

HIP, END, BASE, MASS = 0, 2, 4, 6
"""Rows of `levers` along the segments, those ahead of them follow: of the hip; of the swing foot (point, ankle, or its
arc's centre); of the stance foot's ankle from the edge on which the foot turns; and first moments of mass, kg m."""

POINTS = 8


@dataclass(slots=True)
class Linkage:
    """The constants of a linkage.

    Attributes:
        segments: Number of segments. Legs stand side by side: segment i of the stance leg becomes i + 1 of the swing
            leg in a support transfer and the other way round, for even i.
        angles: Number of the angles of a state. A segment beyond them moves with the first one.
        knees: Whether segments 1 and 2 are thigh and shank of the swing leg, and 0 and 3 those of the stance leg.
        mass: Of the robot, kg.
        gravity: m/s^2.
        radius: Of the feet, m.
        between: Angle from the line of the stance leg back to that of the leg that stands next, rad, where both are one
            rigid body; 0 for legs with angles of their own.
        even: A, shape (segments, segments), kg m^2.
        odd: B, likewise.
        levers: Shape (POINTS, segments), m, kg m or N m.
    """

    segments: int
    angles: int
    knees: bool
    mass: float
    gravity: float
    radius: float
    between: float
    even: list[list[float]]
    odd: list[list[float]]
    levers: list[list[float]]


@dataclass(slots=True, kw_only=True)
class Motion:
    """The linkage as its mode holds it, by the free angles alone, and room to compute in.

    Attributes:
        free: Number of the free angles of a state. Those beyond them, if any, follow the last free one.
        follows: Factor by which they follow it: 1 for the shank of a locked knee, 0 for a foot that lies flat.
        closed: Whether it is two straight legs on a point, whose equations are short.
        offsets: Angle of each segment less that of the state with which it moves, shape (ROOM,), rad.
        even: A of the free angles, shape (ROOM, ROOM).
        odd: B of them.
        pull: First moments of the free angles, along and ahead, shape (2, ROOM), kg m.
        levers: Those of the linkage by the angles of a state, shape (POINTS, ROOM).
        lumped: Of two straight legs A_00, A_01, A_11, and the moments of weight of both, kg m^2 and N m.
        sines: Room for the angles' sines.
        cosines: Room for their cosines.
        ddq: Generalised forces of the angles (N m), then accelerations (rad/s^2), shape (ROOM,).
        matrix: The equations' matrix, shape (SYSTEM, SYSTEM).
        right: Their right side, then their solution: motion, and forces that hold it.
        size: Number of coordinates in these equations.
        held: Number of rows that hold them.
        sine: Of the ground's slope.
        cosine: Of it.
    """

    free: int = 0
    follows: float = 0.0
    closed: bool = False
    offsets: Floats
    even: list[list[float]]
    odd: list[list[float]]
    pull: list[list[float]]
    levers: list[list[float]]
    lumped: Floats
    sines: Floats
    cosines: Floats
    ddq: Floats
    matrix: list[list[float]]
    right: Floats
    size: int = 0
    held: int = 0
    sine: float = 0.0
    cosine: float = 1.0


def room() -> dict[str, Any]:
    """The arrays of a `Motion`, all zero."""
    tables = {"even": (ROOM, ROOM), "odd": (ROOM, ROOM), "pull": (2, ROOM), "levers": (POINTS, ROOM)}
    tables["matrix"] = SYSTEM, SYSTEM
    vectors = {"offsets": ROOM, "lumped": 5, "sines": ROOM, "cosines": ROOM, "ddq": ROOM, "right": SYSTEM}
    return {
        **{name: [[0.0] * columns for _ in range(rows)] for name, (rows, columns) in tables.items()},
        **{name: [0.0] * count for name, count in vectors.items()},
    }


def stand(linkage: Linkage, w: Motion) -> None:
    """Write the linkage by the angles of a state, as far as they are free, from `free`, `follows` and `offsets`."""
    n, offsets, straight = linkage.segments, numbers(w.offsets, ROOM), linkage.radius == 0.0
    for point in range(0, POINTS, 2):
        along, ahead = row(linkage.levers, point, n), row(linkage.levers, point + 1, n)
        to_along, to_ahead = row(w.levers, point, ROOM), row(w.levers, point + 1, ROOM)
        for i in range(n):
            to_along[i] = to_ahead[i] = 0.0
        for i in range(n):
            angle = i if i < linkage.angles else 0
            sine, cosine = math.sin(offsets[i]), math.cos(offsets[i])
            to_along[angle] += along[i] * cosine - ahead[i] * sine
            to_ahead[angle] += ahead[i] * cosine + along[i] * sine
    for i in range(w.free):
        row(w.pull, 0, ROOM)[i] = row(w.pull, 1, ROOM)[i] = 0.0
        for j in range(w.free):
            row(w.even, i, ROOM)[j] = row(w.odd, i, ROOM)[j] = 0.0
    for i in range(linkage.angles):
        at, share = _folded(w, i)
        row(w.pull, 0, ROOM)[at] += share * row(w.levers, MASS, ROOM)[i]
        row(w.pull, 1, ROOM)[at] += share * row(w.levers, MASS + 1, ROOM)[i]
    for i in range(n):
        at, share = _folded(w, i if i < linkage.angles else 0)
        for j in range(n):
            there, part = _folded(w, j if j < linkage.angles else 0)
            sine, cosine = math.sin(offsets[i] - offsets[j]), math.cos(offsets[i] - offsets[j])
            even, odd = row(linkage.even, i, n)[j], row(linkage.odd, i, n)[j]
            row(w.even, at, ROOM)[there] += share * part * (even * cosine + odd * sine)
            row(w.odd, at, ROOM)[there] += share * part * (odd * cosine - even * sine)
    for i in range(w.free):
        straight = straight and row(w.pull, 1, ROOM)[i] == 0.0
        for j in range(w.free):
            straight = straight and row(w.odd, i, ROOM)[j] == 0.0
    w.closed = straight and w.free == 2
    lumped, first, second = numbers(w.lumped, 5), row(w.even, 0, ROOM), row(w.even, 1, ROOM)
    lumped[0], lumped[1], lumped[2] = first[0], first[1], second[1]
    lumped[3], lumped[4] = linkage.gravity * row(w.pull, 0, ROOM)[0], linkage.gravity * row(w.pull, 0, ROOM)[1]


def _folded(w: Motion, angle: int) -> tuple[int, float]:
    """The free angle with which one of a state moves, and the factor by which it does."""
    return (angle, 1.0) if angle < w.free else (w.free - 1, w.follows)


def ground_force(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers, ddq: Numbers) -> tuple[float, float]:
    """Force of the ground along it and normal to it, N: the rate of the robot's momentum, less its weight."""
    along, ahead = row(w.levers, MASS, ROOM), row(w.levers, MASS + 1, ROOM)
    tangential = linkage.mass * (linkage.radius * ddq[0] - linkage.gravity * w.sine)
    normal = linkage.mass * linkage.gravity * w.cosine
    for j in range(linkage.angles):
        sine, cosine = sine_cosine(q[j])
        forward, upward = along[j] * cosine - ahead[j] * sine, -along[j] * sine - ahead[j] * cosine
        square = dq[j] * dq[j]
        tangential += forward * ddq[j] + upward * square
        normal += upward * ddq[j] - forward * square
    return tangential, normal


def point(linkage: Linkage, w: Motion, q: Numbers, which: int) -> tuple[float, float]:
    """A point of the robot from the pivot, along the ground and normal to it, m: `HIP`, `END` or `BASE`."""
    along, ahead, x, z = row(w.levers, which, ROOM), row(w.levers, which + 1, ROOM), 0.0, 0.0
    for j in range(linkage.angles):
        sine, cosine = sine_cosine(q[j])
        x += along[j] * sine + ahead[j] * cosine
        z += along[j] * cosine - ahead[j] * sine
    return x, z


def speed(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers, which: int) -> tuple[float, float]:
    """Rates of such a point's place, along the ground and normal to it, m/s; the pivot of a round foot rolls."""
    x, z = _swept(linkage, w, q, dq, which)
    return x + linkage.radius * dq[0], z


def momentum(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers) -> tuple[float, float]:
    """Momentum of the robot along the ground and normal to it, N s."""
    x, z = _swept(linkage, w, q, dq, MASS)
    return x + linkage.mass * linkage.radius * dq[0], z


def _swept(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers, which: int) -> tuple[float, float]:
    """What the rates make of a point's velocity, or of the momentum, about the pivot."""
    along, ahead, x, z = row(w.levers, which, ROOM), row(w.levers, which + 1, ROOM), 0.0, 0.0
    for j in range(linkage.angles):
        sine, cosine = sine_cosine(q[j])
        x += (along[j] * cosine - ahead[j] * sine) * dq[j]
        z -= (along[j] * sine + ahead[j] * cosine) * dq[j]
    return x, z


def partner(linkage: Linkage, segment: int) -> int:
    """The segment that takes a segment's role in a support transfer."""
    other = segment ^ 1
    return other if other < linkage.segments else segment
