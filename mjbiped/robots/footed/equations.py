"""The biped on feet that are bodies in event-driven engines: flat, or turning about its toe or heel, as `Equations`.

The state has three angles: stance leg, swing leg, and the stance foot's, by which its sole has tipped off the ground,
positive with the toe down. While the foot lies flat this one is zero and the robot is the compass biped, pinned at its
ankle. A foot that turns about an edge is a segment of its own, the line from the edge to the ankle, at a constant angle
to its sole: the chain of `mjbiped.robots.chain` with three segments, under the ankle's torque between leg and foot.

The swing foot is held parallel to the sole of the other one, and its own inertia about its ankle, where its centre of
mass is, is left out: by some 1e-3 of the leg's. So are the impulses that turn it flat as it lands: it lies on the new
ground at once. The foot that leaves keeps its own turning, which by the same token moves no leg.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots import compass
from mjbiped.robots.bent_leg import straight_leg
from mjbiped.robots.chain import Chain, accelerate, hold_end, segment_force, stop_end, strike, with_room
from mjbiped.robots.equations import FLAT, TOE, Equations
from mjbiped.robots.straight_legs import lands, lock_knee

if TYPE_CHECKING:
    from mjbiped.robots.footed.biped import FootedCompass

HEIGHT, HEEL, TOES, INERTIA, LINE, LENGTH = range(6)  # indices of what tells how the stance foot turns

Angles: TypeAlias = tuple[float, float, float]
"""A number for the stance leg, the swing leg and the stance foot."""


def constants_of(robot: FootedCompass) -> SimpleNamespace:
    """The robot as a chain of its legs, and as one of its legs and the stance foot, with room to compute in."""
    foot, two, length = robot.foot, robot.chains[2], robot.leg_length
    weights, moments, reach = np.zeros((3, 3)), np.zeros(3), np.array([length, -length, 0.0])
    weights[:2, :2], moments[:2] = two.weights, two.moments
    three = Chain(weights, moments, reach, two.mass, two.gravity)
    return SimpleNamespace(
        flat=SimpleNamespace(lumped=robot.constants, chain=with_room(two)),
        turning=with_room(three),
        chain=SimpleNamespace(reach=reach.copy(), beside=np.zeros(3)),
        foot=np.array([foot.height, foot.behind, foot.ahead, foot.inertia, 0.0, 0.0]),
        mass=two.mass,
        leaves_after=two.about_end,
        leaves_before=three.onto_end,
        stance=straight_leg(length),
        thigh=1,
        shank=1,
    )


def stand_on_edge(c: Any, edge: int) -> None:
    """Let the constants be those of a foot that lies flat, or turns about its toe or heel.

    The ankle's levers from the pivot are `chain.reach[2]` along the sole's normal and `chain.beside[2]` along the sole;
    those of a flat foot are from the ankle itself.
    """
    if edge == FLAT:
        c.chain.reach[2] = c.chain.beside[2] = 0.0
        return
    foot, s = c.foot, c.turning
    height, beside = foot[HEIGHT], -foot[TOES] if edge == TOE else foot[HEEL]
    length = math.sqrt(height * height + beside * beside)
    foot[LINE], foot[LENGTH] = math.atan2(beside, height), length
    c.chain.reach[2], c.chain.beside[2] = height, beside
    for i in range(2):
        s.weights[i, 2] = s.weights[2, i] = length * s.moments[i] / s.gravity
        c.leaves_before[i, 2] = length * (s.moments[i] / s.gravity - c.mass * s.reach[i])
    s.weights[2, 2] = c.mass * length * length + foot[INERTIA]
    s.moments[2] = s.gravity * c.mass * length
    s.reach[2] = length


def accelerations(c: Any, w: Any, q: Angles, dq: Angles, torques: Any, push: float) -> Angles:
    """Accelerations of the legs and of the stance foot, rad/s^2; the latter is zero while it lies flat."""
    if w.edge == FLAT:
        ddq1, ddq2 = compass.accelerations(c.flat, w, (q[0], q[1]), (dq[0], dq[1]), torques, push)
        return ddq1, ddq2, 0.0
    s = c.turning
    _place(c, q[0], q[1], q[2])
    s.dq[0], s.dq[1], s.dq[2] = dq[0], dq[1], dq[2]
    _, cosine = sine_cosine(s.q[2] + w.slope)
    s.ddq[0], s.ddq[1] = torques[0] - torques[1] + push, torques[1]
    s.ddq[2] = w.push * c.foot[LENGTH] * cosine - torques[0]
    accelerate(s.weights, s.moments, w.slope, s.q, s.dq, s.even, s.odd, s.ddq)
    if w.face != 0.0:
        w.press = hold_end(s, w.slope, w.pushed_x, w.pushed_z)
    return s.ddq[0], s.ddq[1], s.ddq[2]


def _place(c: Any, stance: float, swing: float, foot: float) -> None:
    """Write the angles of the three segments, the last that of the line from the edge to the ankle."""
    c.turning.q[0], c.turning.q[1], c.turning.q[2] = stance, swing, foot + c.foot[LINE]


def stop_foot(c: Any, w: Any) -> float:
    """A plastic, frictionless impact of the swing foot on a face; the stance foot stays on its ground, or its edge."""
    y = w.y
    if w.edge == FLAT:
        impulse = stop_end(c.flat.chain, w, 3)
        y[3], y[4] = c.flat.chain.ddq[0], c.flat.chain.ddq[1]
        return impulse
    s = c.turning
    _place(c, y[0], y[1], y[2])
    for i in range(3):
        s.ddq[i], s.dq[i] = y[3 + i], 0.0
    impulse = hold_end(s, w.slope, w.pushed_x, w.pushed_z)
    for i in range(3):
        y[3 + i] = s.ddq[i]
    return impulse


def turn_foot(c: Any, w: Any, edge: int) -> None:
    """Let the stance foot turn about an edge from now on, or come down flat: a plastic impact of its sole.

    In that impact both edges stay on the ground: of the momentum, the chain of the legs on a pinned ankle keeps its
    share.
    """
    if edge == FLAT:
        y, s, legs = w.y, c.turning, c.flat.chain
        _place(c, y[0], y[1], 0.0)
        for i in range(3):
            s.dq[i] = y[3 + i]
        legs.q[0], legs.q[1] = y[0], y[1]
        strike(legs.weights, s.weights, legs.q, s.q, s.dq, s.even, s.odd)
        y[2], y[3], y[4], y[5] = 0.0, s.dq[0], s.dq[1], 0.0
    w.edge = edge
    stand_on_edge(c, edge)


def exchange(c: Any, w: Any, q: Angles, dq: Angles, slope: float) -> tuple[Angles, Angles]:
    """The landing foot's impact, with the legs exchanged; the ankle that leaves may move, where its foot has tipped."""
    turned = w.slope - slope
    new = q[1] + turned, q[0] + turned, 0.0
    if w.edge == FLAT:
        landed, left = compass.impact_rates(c.flat.lumped, q[0], q[1], dq[0], dq[1])
        return new, (landed, left, 0.0)
    s, legs = c.turning, c.flat.chain
    _place(c, q[0], q[1], q[2])
    s.dq[0], s.dq[1], s.dq[2], legs.q[0], legs.q[1] = dq[0], dq[1], dq[2], q[0], q[1]
    strike(c.leaves_after, c.leaves_before, legs.q, s.q, s.dq, s.even, s.odd)
    w.edge = FLAT
    stand_on_edge(c, FLAT)
    return new, (s.dq[1], s.dq[0], 0.0)


def ground_force(c: Any, w: Any, weight: float, pose: Any, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Force of the ground, forward and upward, N; see `mjbiped.robots.equations.chain_force`."""
    moments, gravity = c.flat.chain.moments, c.turning.gravity
    forward, upward = 0.0, weight
    for i in range(2):
        ahead, above = segment_force(moments[i] / gravity, pose[2 * i], pose[2 * i + 1], state[3 + i], ddq[first + i])
        forward, upward = forward + ahead, upward + above
    if w.edge != FLAT:
        sine, cosine, rate, change = pose[4], pose[5], state[5], ddq[first + 2]
        ahead, above = segment_force(c.mass * c.chain.reach[2], sine, cosine, rate, change)
        forward, upward = forward + ahead, upward + above
        ahead, above = segment_force(c.mass * c.chain.beside[2], cosine, -sine, rate, change)
        forward, upward = forward + ahead, upward + above
    return forward, upward


def limbs(_: Any, w: Any, q: Angles) -> tuple[float, float, float, float]:
    """Left and right leg from the vertical, then left and right ankle's angle, rad."""
    stance, swing, sole = q[0] + w.slope, q[1] + w.slope, q[2] + w.slope
    ankle, other = sole - stance, sole + w.swing_sole - swing
    return (stance, swing, ankle, other) if w.stance == 0 else (swing, stance, other, ankle)


EQUATIONS = Equations(
    constants_of, accelerations, stop_foot, lands, exchange, lock_knee, limbs, ground_force, turn_foot
)
