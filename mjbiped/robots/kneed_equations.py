"""The biped with knees in event-driven engines: its modes, guards and reset maps, as `Equations`.

The state has three angles also while the swing knee is locked: thigh and shank then move as one. A stance leg that has
come down bent stays so, and is told by the angle of the line from its foot to the hip (`mjbiped.robots.bent_leg`).
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots import bent_leg
from mjbiped.robots.bent_leg import ACROSS, FLEXION, LEAN, gravity_beside
from mjbiped.robots.chain import accelerate, hold_end, stop_end, strike, strike_stiff, with_room
from mjbiped.robots.equations import FREE, LOCKED, RESTING, Equations
from mjbiped.robots.kneed_legs import SWING_LOCKED

if TYPE_CHECKING:
    from mjbiped.robots.kneed import KneedBiped

LEGS = np.array([0, 0, 1, 1])  # of four segments

Angles: TypeAlias = tuple[float, float, float]
"""A number for the stance leg, the swing thigh and the swing shank."""


def constants_of(robot: KneedBiped) -> SimpleNamespace:
    """The robot as chains of four, three and two segments, with room to compute in.

    Those of three and of two stand on the stance leg as it is, straight or bent: `stand` writes them.
    """
    four, three, two = (robot.chains[n] for n in (4, 3, 2))
    return SimpleNamespace(
        whole=with_room(four),
        chain=with_room(three),
        straight=with_room(two),
        stance=bent_leg.straight_leg(robot.leg_length),
        legs=LEGS,
        about_end=four.about_end,
        onto_end=four.onto_end,
        knee_before=np.ascontiguousarray(SWING_LOCKED.T @ three.weights),
        heel_after=two.about_end,
        heel_before=two.onto_end,
        thigh=1,
        shank=2,
    )


def stand(c: Any, flexion: float) -> None:
    """Let the constants be those of a stance leg whose knee is locked at a flexion, rad."""
    if flexion == c.stance[FLEXION]:
        return
    bent_leg.stand(c.stance, flexion, c.whole, c.chain, c.straight)
    for j in range(3):
        c.knee_before[0, j] = c.chain.weights[0, j]
    c.knee_before[1, 0] = c.chain.weights[1, 0] + c.chain.weights[2, 0]


def accelerations(c: Any, w: Any, q: Angles, dq: Angles, torques: Any, push: float) -> Angles:
    """Accelerations of the segments, rad/s^2: of three, or of two where the knee is locked or rests on its stop."""
    ankle, hip, knee = torques[0], torques[1], torques[2]
    stand(c, w.stance_flexion)
    stance = ankle - hip + push
    if c.stance[ACROSS] != 0.0:
        stance -= gravity_beside(c.stance[ACROSS], q[0] + w.slope, 0.0, 1.0)  # of the angle from the vertical
    free, locked = c.chain, c.straight
    if w.locked != LOCKED:
        for i in range(3):
            free.q[i], free.dq[i] = q[i], dq[i]
        free.ddq[0], free.ddq[1], free.ddq[2] = stance, hip - knee, knee
        _accelerate(free, w)
        if w.locked == FREE:
            return free.ddq[0], free.ddq[1], free.ddq[2]
        w.stop_press = free.ddq[1] - free.ddq[2]
    locked.q[0], locked.q[1], locked.dq[0], locked.dq[1] = q[0], q[1], dq[0], dq[1]
    locked.ddq[0], locked.ddq[1] = stance, hip
    _accelerate(locked, w)
    return locked.ddq[0], locked.ddq[1], locked.ddq[1]


def _accelerate(s: Any, w: Any) -> None:
    """Turn the forces in `s.ddq` into accelerations, on a surface where the swing foot touches one."""
    accelerate(s.weights, s.moments, w.slope, s.q, s.dq, s.even, s.odd, s.ddq)
    if w.face != 0.0 or w.sliding:
        w.press = hold_end(s, w.slope, w.pushed_x, w.pushed_z)


def stop_foot(c: Any, w: Any) -> float:
    """A plastic, frictionless impact of the swing foot, along its normal; the stance foot stays.

    A locked knee stays locked, and one that rests on its stop does so if the impact presses it on.
    """
    y, free, locked = w.y, c.chain, c.straight
    if w.locked != LOCKED:
        impulse = stop_end(free, w, 3)
        if w.locked == FREE or free.ddq[2] > free.ddq[1]:
            w.locked = FREE
            y[3], y[4], y[5] = free.ddq[0], free.ddq[1], free.ddq[2]
            return impulse
    impulse = stop_end(locked, w, 3)
    y[3], y[4], y[5] = locked.ddq[0], locked.ddq[1], locked.ddq[1]
    return impulse


def lands(c: Any, w: Any, ahead: float) -> bool:
    """A foot that comes down ahead becomes the stance foot if the other one then leaves the ground.

    With straight legs it does; with bent ones the impact tells.
    """
    if ahead <= 0.0:
        return False
    if w.locked == LOCKED and w.stance_flexion == 0.0:
        return True
    y, whole = w.y, c.whole
    new, old = _strike_bent(c, (y[0], y[1], y[2]), (y[3], y[4], y[5]))
    rise = 0.0
    for i in range(4):
        sine, _ = sine_cosine(whole.q[i])
        rise += whole.reach[i] * sine * (old if c.legs[i] == 0 else new)
    return rise > 0.0


def _strike_bent(c: Any, q: Angles, dq: Angles) -> tuple[float, float]:
    """Rates, after an impact with bent knees, of the leg that strikes the ground and of the one that leaves it."""
    s, shank = c.whole, q[0] + c.stance[LEAN]
    s.q[0], s.q[1], s.q[2], s.q[3] = shank, shank - c.stance[FLEXION], q[1], q[2]
    s.dq[0], s.dq[1], s.dq[2], s.dq[3] = dq[0], dq[0], dq[1], dq[2]
    strike_stiff(c.about_end, c.onto_end, c.legs, s.q, s.dq, s.even, s.odd)
    return s.dq[1], s.dq[0]


def exchange(c: Any, w: Any, q: Angles, dq: Angles, slope: float) -> tuple[Angles, Angles]:
    """The heel's impact, with the legs exchanged; the new swing knee rests on its stop, or is free if it is bent."""
    turned, bent = w.slope - slope, w.stance_flexion
    standing = 0.0 if w.locked == LOCKED else q[2] - q[1]
    w.locked = RESTING if bent == 0.0 else FREE
    if standing == 0.0 and bent == 0.0:
        s = c.straight
        s.q[0], s.q[1], s.dq[0], s.dq[1] = q[0], q[1], dq[0], dq[1]
        strike(c.heel_after, c.heel_before, s.q, s.q, s.dq, s.even, s.odd)
        return (q[1] + turned, q[0] + turned, q[0] + turned), (s.dq[1], s.dq[0], s.dq[0])
    landed, left = _strike_bent(c, q, dq)
    shank = q[0] + c.stance[LEAN]
    w.stance_flexion = standing
    stand(c, standing)
    return (q[2] - c.stance[LEAN] + turned, shank - bent + turned, shank + turned), (landed, left, left)


def lock_knee(c: Any, w: Any) -> None:
    """The knee strikes its stop, plastically, and locks."""
    y, free, locked = w.y, c.chain, c.straight
    y[2] = y[1]
    for i in range(3):
        free.q[i], free.dq[i] = y[i], y[3 + i]
    locked.q[0], locked.q[1] = y[0], y[1]
    strike(locked.weights, c.knee_before, locked.q, free.q, free.dq, free.even, free.odd)
    y[3], y[4], y[5] = free.dq[0], free.dq[1], free.dq[1]
    w.locked = LOCKED


def limbs(c: Any, w: Any, q: Angles) -> tuple[float, float, float, float]:
    """Left and right thigh from the vertical, and flexion of left and right knee, rad."""
    bent = c.stance[FLEXION]
    standing, swinging, flexion = q[0] + w.slope, q[1] + w.slope, q[2] - q[1]
    if bent != 0.0:
        standing += c.stance[LEAN] - bent
    if w.stance == 0:
        return standing, swinging, bent, flexion
    return swinging, standing, flexion, bent


EQUATIONS = Equations(constants_of, accelerations, stop_foot, lands, exchange, lock_knee, limbs)
