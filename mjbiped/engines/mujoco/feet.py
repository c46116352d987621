"""Feet that are bodies: where their soles are, when they stand flat, and the servo that holds the swing foot.

A foot stands once the ground bears it behind the ankle and ahead of it: then the legs exchange their roles. Until then
both ankles go on as in the step before. The slope is the angle of the foot that stands; no contact's normal and nothing
of the terrain is in it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from mjbiped.engines.mujoco.contacts import Borne, borne
from mjbiped.engines.mujoco.options import AUTO, BOXES, Options
from mjbiped.engines.mujoco.state import Constants, Leg, Servo, foot_of, stance_of, swing_of
from mjbiped.robots.bodies import Foot
from mjbiped.terrain.profile import height_over_ground

LONGEST = 1e-4  # physics step, s
RESPONSE = 60.0
"""Natural frequency of the servo of the swing foot, in sqrt(gravity / leg length): a foot that lands with an error of 5
degrees presses with a fifth of the weight before it lies flat."""
NEAR = 1e-4
"""Of heel and toe, the second one counts as landing this high over the ground, m: the first one, which bears load
already, is out of contact for single physics steps."""
PLAUSIBLE = 0.08
"""Difference of a foothold's angle from that of the ground so far up to which it is believed at once, rad: a foot of 24
cm on an edge of 2 cm is tilted by more."""


def for_feet(options: Options, foot: Foot) -> Options:
    """The engine's settings for feet that turn about ankles: short steps of one length, since no touchdown ends one.

    A box would meet heightfields in single points.
    """
    ground = BOXES if foot.box and options.ground == AUTO else options.ground
    return replace(options, timestep=min(options.timestep, LONGEST), lands=False, ground=ground)


def foot_servo(foot: Foot, leg_length: float, gravity: float) -> Servo:
    """The servo that holds a swing foot, critically damped."""
    frequency = RESPONSE * math.sqrt(gravity / leg_length)
    return Servo(foot.inertia * frequency**2, 2.0 * foot.inertia * frequency)


def sole_angle(leg: Leg, q: Any) -> float:
    """Angle of a foot's sole, as a slope, rad."""
    return float(q[leg.hip] + leg.offset + q[leg.sole])


def sole_rate(leg: Leg, rates: Any) -> float:
    """Rate of that angle, rad/s."""
    return float(rates[leg.hip] + rates[leg.sole])


def gaps(constants: Constants, leg: Leg, q: Any) -> tuple[float, float]:
    """Heights of heel and toe over the ground, m."""
    x, z = foot_of(leg, q)
    angle = sole_angle(leg, q)
    sine, cosine = math.sin(angle), math.cos(angle)
    profile = constants.places.profile
    heel = height_over_ground(profile, x - leg.behind * cosine, z + leg.behind * sine)
    return heel, height_over_ground(profile, x + leg.ahead * cosine, z - leg.ahead * sine)


def begin_flat(u: Any) -> None:
    """Let a walk begin on ground as it is under the first foot."""
    u.stood = u.level = u.slope


def see_stance_foot(constants: Constants, u: Any) -> None:
    """Take the slope from the foot that stands, and note how long it stood on one side alone, and how far it tipped."""
    tip = sole_angle(constants.places.legs[stance_of(u)], u.q) - u.stood
    u.slope = u.level + tip
    u.tipped = max(u.tipped, abs(tip))
    if not (u.flat or u.noted):
        u.one_sided += u.effective_step


def stand_flat(u: Any, new: float) -> None:
    """Note the angle of a new foothold, rad, and what the feet take the ground's to be.

    An angle far from that of the ground so far is that of a foot on an edge, unless the foothold before was like it.
    """
    if min(abs(new - u.level), abs(new - u.stood)) < PLAUSIBLE:
        u.level = new
    u.stood = new


def felt_by(constants: Constants, u: Any, readings: Any, leg: Leg) -> Borne:
    """How the ground bears a leg's foot, by its contact sensors."""
    return borne(readings, leg.contacts, constants.places.slots, foot_of(leg, u.q), sole_angle(leg, u.q))


def lands_flat(constants: Constants, u: Any, x: float) -> bool:
    """Whether the swing foot, below whose ankle the sole is at x (m), comes to stand in this step."""
    if not (u.collides and x > u.foot_x):
        return False
    legs = constants.places.legs
    heel, toe = gaps(constants, legs[swing_of(u, legs)], u.q)
    return -constants.deepest < min(heel, toe) < 0.0 and max(heel, toe) < NEAR


def stands(constants: Constants, u: Any, readings: Any) -> bool:
    """Whether the ground bears the swing foot on both sides of its ankle, by its sensors; notes its first contact."""
    legs = constants.places.legs
    felt = felt_by(constants, u, readings, legs[swing_of(u, legs)])
    if max(felt.behind, felt.ahead) > 0.0:
        u.down = u.time
        if math.isnan(u.touched):
            u.touched = u.time
    elif u.time - u.down > constants.limits.airborne:
        u.touched = math.nan
    return bool(min(felt.behind, felt.ahead) > 0.0)


def bear(constants: Constants, u: Any, readings: Any) -> None:
    """Note how the ground bears the stance foot in the step just resolved, and a foot that comes to stand in it."""
    legs = constants.places.legs
    if u.noted:
        new = felt_by(constants, u, readings, legs[swing_of(u, legs)])
        u.support_behind, u.support_ahead = new.behind, new.ahead
    felt = felt_by(constants, u, readings, legs[stance_of(u)])
    u.moment, u.shear, u.flat = felt.moment, felt.shear, 1.0 if min(felt.behind, felt.ahead) > 0.0 else 0.0
    u.ratio = 0.0  # of single steps, in which one of two contacts may be lost; see `weigh_shear`


def weigh_shear(u: Any) -> None:
    """Take the ratio of friction to normal force in a stretch over which forces are averaged."""
    if u.impulse > 0.0:
        u.friction = max(u.friction, abs(u.shear_impulse) / u.impulse)
    u.shear_impulse = 0.0


def swing_foot_torque(constants: Constants, u: Any) -> float:
    """Torque of the ankle's motor that holds the swing foot, N m, on the leg as that of the stance ankle.

    It is that of an error of `PLAUSIBLE` at most: a foot that lands across an edge must be able to turn to lie on it.
    """
    legs = constants.places.legs
    stance, swing = legs[stance_of(u)], legs[swing_of(u, legs)]
    # joints tell angles from the foot that stands, which may tip
    error = min(max(sole_angle(swing, u.q) - u.slope, -PLAUSIBLE), PLAUSIBLE)
    rate = sole_rate(swing, u.rates) - sole_rate(stance, u.rates)
    return float(constants.foot_servo.stiffness * error + constants.foot_servo.damping * rate)
