"""What the ground does to the feet: a touchdown, the stance foot's load, its friction, and where it presses."""

from __future__ import annotations

import math

from mjbiped.engines.mujoco.constants import Constants, foot_of, stance_leg, swing_leg
from mjbiped.engines.mujoco.contacts import Felt, felt, friction_ratio
from mjbiped.engines.mujoco.feet import stands
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import Numbers
from mjbiped.records.loads import note_pressure
from mjbiped.rules.termination import LIGHT_CONTACT

FEWEST_AVERAGED = 5.0  # a normal force is averaged over at least so many physics steps: single ones are without contact
AIRBORNE = 0.06
"""A foot is airborne once it has had no contact for this time, in units of sqrt(leg length / gravity). The hops of a
sliding foot last half as long."""
CLEAR = 1e-4  # a swing foot has left the ground once it was higher over it, m


def weigh(c: Constants, u: State, moment: float) -> None:
    """Take the stance foot's force in the physics step before into its averages, and its friction.

    A standing foot loses contact for single physics steps, a sliding one for some milliseconds, and the force of the
    step after makes up for it. So the force is averaged, over stretches of time that end with a step in contact. A foot
    that stays off the ground for longer bears nothing. Of the friction the least counts that some time has: in a step
    of 10 µs, while an impact is being resolved, the foot slides by less than a micrometre at the limit of friction.
    """
    effective_step, force = u.effective_step, u.force
    u.impulse += effective_step * force
    u.shear_impulse += effective_step * u.shear
    u.ankle_impulse += effective_step * moment
    u.stretch += effective_step
    u.load += effective_step * u.pressing
    u.load_time += effective_step
    if u.load_time >= c.averaged:
        u.contact_force = max(u.contact_force, u.load / u.load_time)
        u.load = u.load_time = 0.0
    u.least_ratio = min(u.least_ratio, u.ratio)
    u.ratio_time += effective_step
    if u.ratio_time >= c.sustained:
        u.friction = max(u.friction, u.least_ratio)
        u.least_ratio, u.ratio_time = math.inf, 0.0
    u.without_contact = 0.0 if force > 0.0 else u.without_contact + effective_step
    if u.without_contact >= c.airborne:
        u.normal_force = 0.0
    elif force > 0.0 and u.stretch >= c.averaged:
        average = u.impulse / u.stretch
        if average < u.normal_force:
            u.normal_force = average
        torque, light = u.ankle_impulse / u.stretch, LIGHT_CONTACT * c.weight
        note_pressure(u.pressure, torque, average, light, c.leg_length, u.stretch)
        if u.impulse > 0.0:
            u.friction = max(u.friction, abs(u.shear_impulse) / u.impulse)
        u.impulse = u.ankle_impulse = u.shear_impulse = u.stretch = 0.0


def least_normal_force(u: State) -> float:
    """Of the step that ends, N; that of a step too short for an average is the mean of what there was, or NaN."""
    if u.normal_force < math.inf:
        return float(u.normal_force)
    return float(u.impulse / u.stretch) if u.stretch > 0.0 else math.nan


def read_contacts(c: Constants, u: State, readings: Numbers) -> Felt:
    """Note what the feet feel in the step just resolved; returns what the swing foot does."""
    leg = swing_leg(c, u)
    stance, swing = felt(c, u, readings, stance_leg(c, u)), felt(c, u, readings, leg)
    able = stands(c, u, swing) if c.feet else leg.knee < 0 or u.locked != 0.0 or u.bent != 0.0
    u.pressing = stance.pressure + swing.pressure
    note_contacts(c, u, stance, swing, able)
    if c.feet:
        if u.noted:
            u.support_behind, u.support_ahead = swing.behind, swing.ahead
        u.moment, u.shear = stance.moment, stance.shear
        u.flat = 1.0 if min(stance.behind, stance.ahead) > 0.0 else 0.0
        u.ratio = 0.0  # of single steps, in which one of two contacts may be lost; see `weigh`
    return swing


def note_contacts(c: Constants, u: State, stance: Felt, swing: Felt, able: bool) -> None:
    """Note what both feet feel; a swing foot that touches the ground and is `able` to stand makes a touchdown."""
    x, _ = foot_of(swing_leg(c, u), u.q)
    noted = u.enabled != 0.0 and able and x > u.foot_x and swing.ground
    u.noted, u.force, u.ratio = 1.0 if noted else 0.0, stance.pressure, 0.0
    if u.clear > CLEAR:
        u.touching = 0.0
    if u.enabled and swing.face:
        u.face_impacts = 1.0
    if noted:
        u.penetration = max(u.penetration, swing.depth)
    elif swing.ground and not u.touching:
        u.stubs += 1.0
        u.touching = 1.0
    if stance.ground and not noted:
        u.penetration = max(u.penetration, stance.depth)
        u.ratio = friction_ratio(stance, u.slope, LIGHT_CONTACT * c.weight)
