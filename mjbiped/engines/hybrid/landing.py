"""How a swing foot that is a body lands on ground of another slope: on its heel or toe, and turns until it lies flat.

The edge slides on the ground with Coulomb's friction, while the servo of the ankle holds the sole back.
"""

from __future__ import annotations

import math

from mjbiped.dynamics.linkage import END, speed
from mjbiped.dynamics.modes import FLAT, HEEL, TOE, hold_angle, hold_contact, push_contact
from mjbiped.engines.hybrid.state import Constants, State, ground_of, linkage_of, pushed, swing_foot
from mjbiped.numerics.blocks import Floats, Numbers, numbers
from mjbiped.rules.sole import servo_torque
from mjbiped.terrain.profile import GROUND_FRICTION, height_of

MISSED = 1e-6
"""Of the leg's length: a foot that lands so far off the ground has not been followed."""

SLOW = 1e-3
"""Slip, m/s, below which friction grows with it: edges slide with some 0.1 m/s."""


def level_angle(c: Constants, w: State, segment: int) -> float:
    """Angle of the swing foot's sole that lies flat on a segment of the terrain, from the stance foot's ground, rad."""
    return float(numbers(c.angle, c.segments)[segment] - w.slope)


def clearance_of(c: Constants, w: State, y: Floats, segment: int, x: float, z: float) -> float:
    """Height of the swing foot at (x, z) over a segment of the terrain, m; of one that is a body, of its lower edge."""
    clearance = z - height_of(ground_of(c), segment, x)
    if c.foot >= 0:
        rise, _ = _edge_below(c, y[c.foot + 1] - level_angle(c, w, segment))
        clearance -= rise / math.cos(numbers(c.angle, c.segments)[segment])
    return float(clearance)


def clearance_rate(c: Constants, w: State, y: Floats, segment: int, speed_x: float, speed_z: float) -> float:
    """Rate of that clearance, m/s, of a swing foot with a velocity, m/s."""
    rate = speed_z - numbers(c.gradient, c.segments)[segment] * speed_x
    if c.foot >= 0:
        _, lever = _edge_below(c, y[c.foot + 1] - level_angle(c, w, segment))
        rate -= lever * y[c.angles + c.foot + 1] / math.cos(numbers(c.angle, c.segments)[segment])
    return float(rate)


def _edge_below(c: Constants, tilt: float) -> tuple[float, float]:
    """How far a tilted sole's lower edge is below its flat one, m, and the derivative by the tilt (rad), m.

    A sole that is so short that friction would jam it (Painleve's paradox) comes down flat at once.
    """
    reach, sign = (c.toe, 1.0) if tilt > 0.0 else (c.heel, -1.0)
    if reach <= GROUND_FRICTION * c.height:
        return 0.0, 0.0
    sine, cosine = math.sin(sign * tilt), math.cos(tilt)
    return reach * sine - c.height * (1.0 - cosine), sign * (reach * cosine - c.height * sine)


def set_edge(c: Constants, w: State) -> float:
    """Turn a swing foot that has come down to where its edge is on the ground; returns how high its ankle stands, m.

    An ankle that comes over a change of slope may be lower than the edge of its foot lets it: the foot then turns.
    """
    y, segment = numbers(w.y, c.size), w.landing
    x, z = swing_foot(c, w, y)
    slope = numbers(c.angle, c.segments)[segment]
    above, level = (z - height_of(ground_of(c), segment, x)) * math.cos(slope), level_angle(c, w, segment)
    w.down = TOE if y[c.foot + 1] > level else HEEL
    reach = c.toe if w.down == TOE else c.heel
    share = min((c.height + above) / math.sqrt(reach * reach + c.height * c.height), 1.0)
    y[c.foot + 1] = level + w.down * (math.asin(share) - math.atan2(c.height, reach))
    return float(above)


def hold_edge(c: Constants, w: State, q: Numbers, dq: Numbers) -> None:
    """Hold the edge of the swing foot that is down, which slides with friction, and a stance foot that lies flat."""
    linkage, level = linkage_of(c, w), level_angle(c, w, w.landing)
    sine, cosine = math.sin(level), math.cos(level)
    along, normal = speed(linkage, w, q, dq, END)
    slip = along * cosine - normal * sine
    push_from_ground(c, w, GROUND_FRICTION * slip / math.sqrt(slip * slip + SLOW * SLOW))
    hold_contact(linkage, w, dq, sine, cosine)
    along, normal = pushed(w)
    push_contact(linkage, w, along, normal)
    if w.edge == FLAT:
        hold_angle(w, c.foot)


def push_from_ground(c: Constants, w: State, ratio: float) -> None:
    """Let the ground push the swing foot along its normal, and against the slip by a share of the normal force."""
    slope = numbers(c.angle, c.segments)[w.landing]
    w.pushed_x = math.sin(slope) - ratio * math.cos(slope)
    w.pushed_z = math.cos(slope) + ratio * math.sin(slope)


def servo(c: Constants, w: State) -> float:
    """Torque of the swing ankle's servo on its leg, N m."""
    q, dq, foot = numbers(w.q, c.angles), numbers(w.dq, c.angles), c.foot
    return servo_torque(c.foot_stiffness, c.foot_damping, q[foot + 1] - q[foot], dq[foot + 1] - dq[foot])
