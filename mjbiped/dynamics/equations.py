"""The equations of a linkage: accelerations, and plastic impacts of a robot whose stance foot stands.

In the angles that are free, with the rows of J that hold them (`mjbiped.dynamics.modes`), M ddq = f + J' force and
J ddq = rest hold at once. An impact is the same in momenta: M (dq - dq_before) = J' impulse and J dq = 0.
"""

from __future__ import annotations

from mjbiped.dynamics.linkage import ROOM, SYSTEM, Linkage, Motion
from mjbiped.numerics.blocks import Numbers, numbers, row
from mjbiped.numerics.trigonometry import sine_cosine


def accelerate(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers) -> None:
    """Turn the generalised forces in `w.ddq` into accelerations, rad/s^2, where nothing holds the free angles."""
    if w.closed:
        fold(linkage, w)
        _accelerate_legs(w, q, dq)
        unfold(linkage, w)
    else:
        load(linkage, w, q, dq)
        settle(linkage, w)


def fold(linkage: Linkage, w: Motion) -> None:
    """Let the forces in `w.ddq` on angles that are not free act on the one that they follow."""
    ddq = numbers(w.ddq, ROOM)
    for i in range(w.free, linkage.angles):
        ddq[w.free - 1] += w.follows * ddq[i]


def unfold(linkage: Linkage, w: Motion) -> None:
    """Let the accelerations in `w.ddq` of angles that are not free be those of the one that they follow."""
    ddq = numbers(w.ddq, ROOM)
    for i in range(w.free, linkage.angles):
        ddq[i] = w.follows * ddq[w.free - 1]


def _accelerate_legs(w: Motion, q: Numbers, dq: Numbers) -> None:
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


def load(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers) -> None:
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


def settle(linkage: Linkage, w: Motion) -> None:
    """Solve the equations of the free angles; all accelerations then stand in `w.ddq`."""
    solve(w)
    ddq, right = numbers(w.ddq, ROOM), numbers(w.right, SYSTEM)
    for i in range(w.free):
        ddq[i] = right[i]
    unfold(linkage, w)


def hold(w: Motion, rest: float) -> None:
    """Let the row that stands behind the equations hold the motion from now on: row . motion = rest."""
    place = w.size + w.held
    added, right = row(w.matrix, place, SYSTEM), numbers(w.right, SYSTEM)
    for i in range(w.size):
        row(w.matrix, i, SYSTEM)[place] = -added[i]
    for i in range(w.size, place + 1):
        added[i] = row(w.matrix, i, SYSTEM)[place] = 0.0
    right[place] = rest
    w.held += 1


def load_impact(linkage: Linkage, w: Motion, q: Numbers, dq: Numbers) -> None:
    """Write the equations of an impact in which the stance foot stands: M, and the momentum before it."""
    load(linkage, w, q, dq)
    right = numbers(w.right, SYSTEM)
    for i in range(w.free):
        matrix, right[i] = row(w.matrix, i, SYSTEM), 0.0
        for j in range(w.free):
            right[i] += matrix[j] * dq[j]


def solve(w: Motion) -> None:
    """Solve [[M, -J'], [J, 0]] (motion, forces) = right in place; the matrix is lost.

    M is positive definite, and so is J M^-1 J' of rows that do not depend on each other: no pivot is needed. A row that
    no rate moves takes no force.
    """
    n, right = w.size + w.held, numbers(w.right, SYSTEM)
    for j in range(n):
        pivot = row(w.matrix, j, SYSTEM)
        for i in range(j + 1, n):
            below = row(w.matrix, i, SYSTEM)
            if below[j] != 0.0:
                share = below[j] / pivot[j]
                for k in range(j + 1, n):
                    below[k] -= share * pivot[k]
                right[i] -= share * right[j]
    for j in range(n - 1, -1, -1):
        pivot = row(w.matrix, j, SYSTEM)
        for k in range(j + 1, n):
            right[j] -= pivot[k] * right[k]
        right[j] = right[j] / pivot[j] if pivot[j] != 0.0 else 0.0
