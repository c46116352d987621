"""Any planar linkage of rigid segments on one foot: its equations of motion, its forces, and its plastic impacts.

Each segment has one angle, absolute: from the normal of the ground, rad, positive forward. A point of the robot stands
at the sum, over the segments, of a lever along the segment's line and one a right angle ahead of it, so that

    (x, z) = sum_j (along_j sin q_j + ahead_j cos q_j, along_j cos q_j - ahead_j sin q_j)

from the pivot: the point foot, the edge of a flat one, or the centre of a round one's arc, which rolls by radius dq_0.
Summed up over the bodies k, with the levers as complex numbers l_kj = along + i ahead,

    M_ij = A_ij cos(q_i - q_j) + B_ij sin(q_i - q_j),   A_ij + i B_ij = sum_k m_k conj(l_ki) l_kj,
    C_ij = (A_ij sin(q_i - q_j) - B_ij cos(q_i - q_j)) dq_j,

plus the inertia of segment i in A_ii; gravity, the ground's force and rolling take the first moments sum_k m_k l_kj.
What holds the robot are rows of J (`mjbiped.dynamics.modes`): M ddq = f + J' force and J ddq = rest at once. An impact
is the same in momenta, of the linkage whose pivot is free to move: M (u - u_before) = J' impulse and J u = 0.

The functions run in plain Python and as machine code. `linkage` is a `Linkage`, `w` a block with a `Motion`'s fields.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from mjbiped.numerics.blocks import Floats, numbers, row
from mjbiped.numerics.trigonometry import sine_cosine

ROOM = 4
"""Most angles, and most segments."""

PIVOT = 2
"""Coordinates of the pivot's place, which stand before the segments' angles in an impact: along the ground, up."""

SYSTEM = 12
"""Most equations at once: coordinates, and rows that hold them."""

HIP, END, BASE, MASS, WEIGHT = 0, 2, 4, 6, 8
"""Rows of `levers` along the segments, those ahead of them follow: of the hip; of the swing foot (point, ankle, or its
arc's centre); of the stance foot's ankle from the edge on which the foot turns; first moments of mass, kg m; and of
weight, N m."""

POINTS = 10


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


def stand(linkage: Any, w: Any) -> None:
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


def _folded(w: Any, angle: int) -> tuple[int, float]:
    """The free angle with which one of a state moves, and the factor by which it does."""
    return (angle, 1.0) if angle < w.free else (w.free - 1, w.follows)


def accelerate(linkage: Any, w: Any, q: Any, dq: Any) -> None:
    """Turn the generalised forces in `w.ddq` into accelerations, rad/s^2, where nothing holds the free angles."""
    if w.closed:
        fold(linkage, w)
        _accelerate_legs(w, q, dq)
        unfold(linkage, w)
    else:
        load(linkage, w, q, dq)
        settle(linkage, w)


def fold(linkage: Any, w: Any) -> None:
    """Let the forces in `w.ddq` on angles that are not free act on the one that they follow."""
    ddq = numbers(w.ddq, ROOM)
    for i in range(w.free, linkage.angles):
        ddq[w.free - 1] += w.follows * ddq[i]


def unfold(linkage: Any, w: Any) -> None:
    """Let the accelerations in `w.ddq` of angles that are not free be those of the one that they follow."""
    ddq = numbers(w.ddq, ROOM)
    for i in range(w.free, linkage.angles):
        ddq[i] = w.follows * ddq[w.free - 1]


def _accelerate_legs(w: Any, q: Any, dq: Any) -> None:
    """Equation (1) of the paper: two straight legs on a point."""
    ddq, lumped = numbers(w.ddq, ROOM), numbers(w.lumped, 5)
    s1, c1 = sine_cosine(q[0])
    s2, c2 = sine_cosine(q[1])
    m11, m22 = lumped[0], lumped[2]
    m12, coupling = lumped[1] * (c1 * c2 + s1 * s2), lumped[1] * (s1 * c2 - c1 * s2)
    f1 = ddq[0] - coupling * dq[1] * dq[1] + lumped[3] * (c1 * w.sine + s1 * w.cosine)
    f2 = ddq[1] + coupling * dq[0] * dq[0] + lumped[4] * (c2 * w.sine + s2 * w.cosine)
    share = 1.0 / (m11 * m22 - m12 * m12)
    ddq[0], ddq[1] = (m22 * f1 - m12 * f2) * share, (m11 * f2 - m12 * f1) * share


def load(linkage: Any, w: Any, q: Any, dq: Any) -> None:
    """Write the equations of the free angles: M, and the forces in `w.ddq` with gravity and what the rates make."""
    fold(linkage, w)
    free, mass, radius, gravity = w.free, linkage.mass, linkage.radius, linkage.gravity
    sines, cosines, ddq, right = (
        numbers(w.sines, ROOM),
        numbers(w.cosines, ROOM),
        numbers(w.ddq, ROOM),
        numbers(w.right, SYSTEM),
    )
    along, ahead = row(w.pull, 0, ROOM), row(w.pull, 1, ROOM)
    w.size, w.held = free, 0
    swept = 0.0
    for i in range(free):
        sines[i], cosines[i] = sine_cosine(q[i])
    for i in range(free):
        even, odd, matrix = row(w.even, i, ROOM), row(w.odd, i, ROOM), row(w.matrix, i, SYSTEM)
        force = 0.0
        for j in range(free):
            sine = sines[i] * cosines[j] - cosines[i] * sines[j]
            cosine = cosines[i] * cosines[j] + sines[i] * sines[j]
            matrix[j] = even[j] * cosine + odd[j] * sine
            force += (even[j] * sine - odd[j] * cosine) * dq[j] * dq[j]
        forward = along[i] * cosines[i] - ahead[i] * sines[i]
        upward = -along[i] * sines[i] - ahead[i] * cosines[i]
        right[i] = ddq[i] + gravity * (w.sine * forward - w.cosine * upward) - force
        if radius != 0.0:
            matrix[0] += radius * forward
            row(w.matrix, 0, SYSTEM)[i] += radius * forward
            swept += upward * dq[i] * dq[i]
    if radius != 0.0:
        row(w.matrix, 0, SYSTEM)[0] += radius * radius * mass
        right[0] += radius * (gravity * w.sine * mass - swept)


def settle(linkage: Any, w: Any) -> None:
    """Solve the equations of the free angles; all accelerations then stand in `w.ddq`."""
    solve(w)
    ddq, right = numbers(w.ddq, ROOM), numbers(w.right, SYSTEM)
    for i in range(w.free):
        ddq[i] = right[i]
    unfold(linkage, w)


def hold(w: Any, rest: float) -> None:
    """Let the row that stands behind the equations hold the motion from now on: row . motion = rest."""
    place = w.size + w.held
    added, right = row(w.matrix, place, SYSTEM), numbers(w.right, SYSTEM)
    for i in range(w.size):
        row(w.matrix, i, SYSTEM)[place] = -added[i]
    for i in range(w.size, place + 1):
        added[i] = row(w.matrix, i, SYSTEM)[place] = 0.0
    right[place] = rest
    w.held += 1


def solve(w: Any) -> None:
    """Solve [[M, -J'], [J, 0]] (motion, forces) = right in place; the matrix is lost.

    M is positive definite, and so is J M^-1 J' of rows that do not depend on each other: no pivot is needed.
    """
    n = w.size + w.held
    for j in range(n):
        _eliminate(w, j, n)
    _substitute(w, n)


def _eliminate(w: Any, j: int, n: int) -> None:
    """Take unknown j out of the equations behind the j-th of n."""
    pivot, right = row(w.matrix, j, SYSTEM), numbers(w.right, SYSTEM)
    for i in range(j + 1, n):
        below = row(w.matrix, i, SYSTEM)
        if below[j] != 0.0:
            share = below[j] / pivot[j]
            for k in range(j + 1, n):
                below[k] -= share * pivot[k]
            right[i] -= share * right[j]


def solve_impact(w: Any) -> None:
    """`solve` an impact, with pivots: M may be singular there, as of a point mass on a massless leg."""
    n, right = w.size + w.held, numbers(w.right, SYSTEM)
    for j in range(n):
        greatest = j
        for i in range(j + 1, n):
            if abs(row(w.matrix, i, SYSTEM)[j]) > abs(row(w.matrix, greatest, SYSTEM)[j]):
                greatest = i
        if greatest != j:
            first, second = row(w.matrix, j, SYSTEM), row(w.matrix, greatest, SYSTEM)
            for k in range(j, n):
                first[k], second[k] = second[k], first[k]
            right[j], right[greatest] = right[greatest], right[j]
        _eliminate(w, j, n)
    _substitute(w, n)


def _substitute(w: Any, n: int) -> None:
    """Find n unknowns, the last one first, from equations whose earlier ones are taken out.

    A row that no rate moves takes no force.
    """
    right = numbers(w.right, SYSTEM)
    for j in range(n - 1, -1, -1):
        pivot = row(w.matrix, j, SYSTEM)
        for k in range(j + 1, n):
            right[j] -= pivot[k] * right[k]
        right[j] = right[j] / pivot[j] if pivot[j] != 0.0 else 0.0


def load_impact(linkage: Any, w: Any, y: Any) -> None:
    """Write the equations of an impact in a state: coordinates are the pivot's place and the angles of all segments.

    Args:
        linkage: The linkage.
        w: Its motion; the momentum before the impact stands in `right`.
        y: Angles, rad, and rates, rad/s.
    """
    n, size = linkage.segments, PIVOT + linkage.segments
    sines, cosines, rates = numbers(w.sines, ROOM), numbers(w.cosines, ROOM), numbers(w.ddq, ROOM)
    offsets, right = numbers(w.offsets, ROOM), numbers(w.right, SYSTEM)
    along, ahead = row(linkage.levers, MASS, n), row(linkage.levers, MASS + 1, n)
    first, second, rolls = row(w.matrix, 0, SYSTEM), row(w.matrix, 1, SYSTEM), linkage.radius * y[linkage.angles]
    w.size, w.held = size, 0
    first[0], first[1], second[0], second[1] = linkage.mass, 0.0, 0.0, linkage.mass
    for i in range(n):
        angle = i if i < linkage.angles else 0
        sines[i], cosines[i] = sine_cosine(y[angle] + offsets[i])
        rates[i] = y[linkage.angles + angle]
    right[0], right[1] = linkage.mass * rolls, 0.0
    for i in range(n):
        even, odd, matrix = row(linkage.even, i, n), row(linkage.odd, i, n), row(w.matrix, PIVOT + i, SYSTEM)
        forward = along[i] * cosines[i] - ahead[i] * sines[i]
        upward = -along[i] * sines[i] - ahead[i] * cosines[i]
        matrix[0] = first[PIVOT + i] = forward
        matrix[1] = second[PIVOT + i] = upward
        right[0] += forward * rates[i]
        right[1] += upward * rates[i]
        right[PIVOT + i] = forward * rolls
        for j in range(n):
            sine = sines[i] * cosines[j] - cosines[i] * sines[j]
            cosine = cosines[i] * cosines[j] + sines[i] * sines[j]
            matrix[PIVOT + j] = even[j] * cosine + odd[j] * sine
            right[PIVOT + i] += matrix[PIVOT + j] * rates[j]


def ground_force(linkage: Any, w: Any, q: Any, dq: Any, ddq: Any) -> tuple[float, float]:
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


def point(linkage: Any, w: Any, q: Any, which: int) -> tuple[float, float]:
    """A point of the robot from the pivot, along the ground and normal to it, m: `HIP`, `END` or `BASE`."""
    along, ahead, x, z = row(w.levers, which, ROOM), row(w.levers, which + 1, ROOM), 0.0, 0.0
    for j in range(linkage.angles):
        sine, cosine = sine_cosine(q[j])
        x += along[j] * sine + ahead[j] * cosine
        z += along[j] * cosine - ahead[j] * sine
    return x, z


def speed(linkage: Any, w: Any, q: Any, dq: Any, which: int) -> tuple[float, float]:
    """Rates of such a point's place, along the ground and normal to it, m/s; the pivot of a round foot rolls."""
    along, ahead, x, z = row(w.levers, which, ROOM), row(w.levers, which + 1, ROOM), linkage.radius * dq[0], 0.0
    for j in range(linkage.angles):
        sine, cosine = sine_cosine(q[j])
        x += (along[j] * cosine - ahead[j] * sine) * dq[j]
        z -= (along[j] * sine + ahead[j] * cosine) * dq[j]
    return x, z
