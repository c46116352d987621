"""Feet that are bodies: where their soles are, when they stand flat, and the servo that holds the swing foot.

A foot stands once the ground bears it behind the ankle and ahead of it: then the legs exchange their roles. Until then
both ankles go on as in the step before. The slope is the angle of the foot that stands; no contact's normal and nothing
of the terrain is in it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from mjbiped.engines.mujoco.constants import Constants, Leg, foot_of, heel_and_toe, sole_angle, stance_leg, swing_leg
from mjbiped.engines.mujoco.contacts import Felt
from mjbiped.engines.mujoco.options import AUTO, BOXES, Options
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import Floats, numbers
from mjbiped.robots.bodies import Foot
from mjbiped.rules.sole import GREATEST_ERROR, servo_torque
from mjbiped.terrain.profile import height_over_ground, segment_under

LONGEST = 1e-4  # physics step, s
NEAR = 1e-4
"""Of heel and toe, the second one counts as landing this high over the ground, m: the first one, which bears load
already, is out of contact for single physics steps."""
MOST = 0.5  # of the weight that a foot bears which stands alone
PLAUSIBLE = GREATEST_ERROR
"""Difference of a foothold's angle from that of the ground so far up to which it is believed at once, rad: a foot of 24
cm on an edge of 2 cm is tilted by more."""


def for_feet(options: Options, foot: Foot) -> Options:
    """The engine's settings for feet that turn about ankles: short steps of one length, since no touchdown ends one.

    A box would meet heightfields in single points.
    """
    ground = BOXES if foot.box and options.ground == AUTO else options.ground
    return replace(options, timestep=min(options.timestep, LONGEST), lands=False, ground=ground)


def gaps(c: Constants, leg: Leg, q: Floats) -> tuple[float, float]:
    """Heights of heel and toe over the ground, m."""
    heel_x, heel_z, toe_x, toe_z = heel_and_toe(leg, q)
    return height_over_ground(c, heel_x, heel_z), height_over_ground(c, toe_x, toe_z)


def see_stance_foot(c: Constants, u: State) -> None:
    """Take the slope from the foot that stands, and note how long it stood on one side alone, and how far it tipped."""
    tip = sole_angle(stance_leg(c, u), u.q) - u.stood
    u.slope = u.level + tip
    u.tipped = max(u.tipped, abs(tip))
    if not (u.flat or u.noted):
        u.one_sided += u.effective_step


def stand_flat(u: State, new: float) -> None:
    """Note the angle of a new foothold, rad, and what the feet take the ground's to be.

    An angle far from that of the ground so far is that of a foot on an edge, unless the foothold before was like it.
    """
    if min(abs(new - u.level), abs(new - u.stood)) < PLAUSIBLE:
        u.level = new
    u.stood = new


def intrusion(c: Constants, leg: Leg, q: Floats) -> float:
    """How high edges of the ground stand over the line from a foot's heel to its toe, m; 0: none does."""
    (x, z), angle = foot_of(leg, q), sole_angle(leg, q)
    starts, heights, rises = numbers(c.x, c.segments), numbers(c.z, c.segments), numbers(c.rises, c.segments)
    heel, _, toe, _ = heel_and_toe(leg, q)
    segment, fall, highest = segment_under(c, heel) + 1, math.tan(angle), 0.0
    while segment < c.segments and starts[segment] < toe:
        edge = max(heights[segment], heights[segment] - rises[segment])
        highest = max(highest, edge - (z - fall * (starts[segment] - x)))
        segment += 1
    return highest


def lands_flat(c: Constants, u: State, x: float) -> bool:
    """Whether the swing foot, below whose ankle the sole is at x (m), comes to stand in this step."""
    if not (u.collides and x > u.foot_x):
        return False
    heel, toe = gaps(c, swing_leg(c, u), u.q)
    return -c.deepest < min(heel, toe) < 0.0 and max(heel, toe) < NEAR


def stands(c: Constants, u: State, foot: Felt) -> bool:
    """Whether the swing foot has come to stand; notes its first contact.

    It has where the ground bears the foot on both sides of its ankle. A foot with an edge close to its ankle may never
    be borne so: it stands once it bears most of the weight and the other foot has borne none for a while.
    """
    if max(foot.behind, foot.ahead) > 0.0:
        u.down = u.time
        if math.isnan(u.touched):
            u.touched = u.time
    elif u.time - u.down > c.airborne:
        u.touched = math.nan
    alone = u.without_contact >= c.airborne and foot.pressure > MOST * c.weight
    return bool(alone or min(foot.behind, foot.ahead) > 0.0)


def swing_foot_torque(c: Constants, u: State) -> float:
    """Torque of the ankle's motor that holds the swing foot, N m, on the leg as that of the stance ankle."""
    stance, swing = stance_leg(c, u), swing_leg(c, u)
    rate = (u.rates[swing.hip] + u.rates[swing.sole]) - (u.rates[stance.hip] + u.rates[stance.sole])
    # joints tell angles from the foot that stands, which may tip
    return servo_torque(c.foot_stiffness, c.foot_damping, sole_angle(swing, u.q) - u.slope, rate)
