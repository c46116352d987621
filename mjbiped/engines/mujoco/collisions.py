"""Collisions of feet with pieces of the ground in a physics step, and the softness of contacts, locks and stops.

A swing foot passes through everything until its contact is enabled (scuffing rule). From then on it collides as a
point: with the piece of ground below it and with a riser beside it (`profile.segment_met`), never with a corner.

The resting stance foot collides with all ground except risers and higher pieces beside it. A foot that is a box
collides with everything except risers, whose upper ends would bear it without friction. The feet of all other legs pass
through everything.

A foot that lifts off in this step passes through the ground: the solver's convex friction cone would drag a foot that
leaves obliquely, as the old stance foot does in the step that resolves the other foot's touchdown.
"""

from __future__ import annotations

from collections.abc import MutableSequence

from mjbiped.engines.mujoco.constants import (
    Constants,
    Leg,
    end_of_leg,
    foot_of,
    heel_and_toe,
    leg_at,
    stance_leg,
    swing_index,
    swing_leg,
)
from mjbiped.engines.mujoco.feet import lands_flat
from mjbiped.engines.mujoco.ground import SILL
from mjbiped.engines.mujoco.state import State, X, Z, effective_step
from mjbiped.numerics.blocks import Floats, numbers, octets, whole_numbers
from mjbiped.terrain.profile import height_of, height_over_ground, segment_met, segment_stood_on
from mjbiped.utils.mujoco import mujoco

SUNK = 5e-4  # greatest depth of a standing foot in the ground, m
STANCE, SWING = 1, 4  # contact bits of the two feet; that of a toe is twice as great
ALL = 15  # of a piece of ground that all feet collide with
NEAR = 0.5 * SILL  # m


def write_contact_bits(c: Constants, u: State) -> None:
    """Let the feet collide as they may in the step to come; the state is that of its beginning."""
    contype = whole_numbers(c.geom_contype, c.ngeom)
    contype[:] = 0
    if not c.box:  # which all ground meets
        whole_numbers(c.geom_conaffinity, c.ngeom)[:] = 0
    stance, swing = stance_leg(c, u), leg_at(c.legs, swing_index(c, u))
    if u.collides and u.lifted != swing_index(c, u):
        _let_collide(c, contype, swing, u.q, SWING, True)
    lands = u.time == u.transfer_time and u.count > 0.0  # the foot collides as when it landed
    if u.lifted != u.stance or (lands and not c.box):
        _let_collide(c, contype, stance, u.q, STANCE, lands)


def _let_collide(c: Constants, contype: MutableSequence[int], leg: Leg, q: Floats, bit: int, lands: bool) -> None:
    """Let a leg's foot collide: as one that lands, or as one that stands."""
    contype[leg.foot] = bit
    if c.box:
        return
    x, z = foot_of(leg, q)
    if leg.toe >= 0:
        contype[leg.toe] = 2 * bit
        x, z, toe_x, toe_z = heel_and_toe(leg, q)
        _mark_ground(c, toe_x, toe_z, 2 * bit, lands)
    _mark_ground(c, x, z, bit, lands)


def _mark_ground(c: Constants, x: float, z: float, bit: int, lands: bool) -> None:
    """Let the pieces of ground that a sphere at x, z (m) can meet collide with it."""
    if lands:
        segment = segment_met(c, x, z)
        _mark(c, _ground_of(c, segment, x), bit)
        _mark_risers(c, segment, bit)
        return
    if not c.scuffs:
        _mark_risers(c, segment_met(c, x, z), bit)
    segment = segment_stood_on(c, x, z, SUNK)
    _mark(c, _ground_of(c, segment, x), bit)
    before, behind = int(numbers(c.firsts, c.segments)[segment]) - 1, int(numbers(c.lasts, c.segments)[segment]) + 1
    if before >= 0 and height_of(c, before, x) <= z + SUNK:
        _mark(c, numbers(c.pieces, c.segments)[before], bit)
    if behind < c.segments and height_of(c, behind, x) <= z + SUNK:
        _mark(c, numbers(c.pieces, c.segments)[behind], bit)


def _ground_of(c: Constants, segment: int, x: float) -> float:
    """Geom of a segment's ground at x (m): its piece, but the sill near a riser's face."""
    starts, rises, sills = numbers(c.x, c.segments), numbers(c.rises, c.segments), numbers(c.sills, c.segments)
    if rises[segment] < 0.0 and abs(x - starts[segment]) < NEAR and sills[segment] >= 0.0:
        return float(sills[segment])
    after = segment + 1
    if after < c.segments and rises[after] > 0.0 and abs(x - starts[after]) < NEAR and sills[after] >= 0.0:
        return float(sills[after])
    return float(numbers(c.pieces, c.segments)[segment])


def _mark_risers(c: Constants, segment: int, bit: int) -> None:
    """Let the risers ahead of a segment and behind it collide, where they rise from it."""
    risers, rises = numbers(c.risers, c.segments), numbers(c.rises, c.segments)
    if rises[segment] < 0.0:
        _mark(c, risers[segment], bit)
    if segment + 1 < c.segments and rises[segment + 1] > 0.0:
        _mark(c, risers[segment + 1], bit)


def _mark(c: Constants, geom: float, bit: int) -> None:
    """Set a contact bit of a geom of the ground; -1: there is none."""
    if geom >= 0.0:
        whole_numbers(c.geom_conaffinity, c.ngeom)[int(geom)] |= bit


NOBODY = -1.0  # in `State.lifted`: no foot leaves the ground in this step
SHORTEST = 1e-9  # no step is shorter, s


def lift(c: Constants, u: State, ahead: float) -> None:
    """Say which foot leaves the ground in the step to come, and passes through it; see `collisions`.

    That of the stance leg does where the other one lands. A swing knee that is free is then locked as it is: with the
    touchdown, the leg becomes one body. Not so where the stop alone holds knees: no bent leg lands there.

    Args:
        c: The walk's constants.
        u: State.
        ahead: When the step begins, s from now on.
    """
    u.lifted, leg = NOBODY, swing_leg(c, u)
    x, z = foot_after(u, leg, ahead)
    if c.feet:
        if lands_flat(c, u, x):
            u.lifted = u.stance
        else:
            for index in range(c.nq):
                u.rates_before[index] = u.rates[index]
        return
    clear = height_over_ground(c, x, z)
    if not (u.collides and -c.deepest < clear < 0.0):
        return
    straight = leg.knee < 0 or u.locked != 0.0
    later_x, later_z = foot_after(u, leg, ahead + SHORTEST)
    if height_over_ground(c, later_x, later_z) > clear:
        u.lifted = float(swing_index(c, u))
    elif x > u.foot_x and (straight or not (u.touching or c.knee_opens)):
        # a foot that drags along with its knee bent goes on so
        u.lifted = u.stance
        if not straight:
            u.bent, u.bend = 1.0, u.q[leg.knee]


def foot_after(u: State, leg: Leg, t: float) -> tuple[float, float]:
    """Place of a leg's foot a short time from now on (s), by the present rates: x and z in m."""
    if t == 0.0:
        return foot_of(leg, u.q)
    flexion = u.q[leg.knee] + t * u.rates[leg.knee] if leg.knee >= 0 else 0.0
    angle = u.q[leg.hip] + t * u.rates[leg.hip]
    return end_of_leg(leg, u.q[X] + t * u.rates[X], u.q[Z] + t * u.rates[Z], angle, flexion)


STIFFNESS = 1e3
"""Of a contact over the mass it meets, 1/s². `solimp` leaves 1e-4 of the load unborne, so a standing foot sinks by
1e-4 g over it, 1 µm. A stiffer one rests at some 10 nm, where MuJoCo's collision detection misses it now and then."""
LOCK_STIFFNESS = 1e5
"""Stiffness of a locked or stopped knee over the inertia that it meets, 1/s². `solimp` leaves 1e-4 of the load unborne,
and the robot's weight would turn a light shank at some 1e3 rad/s²: so the knee bends by 1e-6 rad."""
PUSHED_OUT = 100.0
"""Share of its depth by which a foot comes out of a riser's face again, 1/s: in 10 ms, before it slides down to the
ground, whose edge it would miss by that depth."""
EQ_DATA = int(mujoco.mjNEQDATA)  # floats of an equality constraint


def soften(c: Constants, u: State) -> None:
    """Write which knees are locked, and how soft contacts, locks and stops are, so that the next step is plastic.

    Args:
        c: The walk's constants.
        u: State, after the observation.
    """
    u.acted, u.softened = u.softened, u.strikes
    solref, damping = numbers(c.geom_solref, 2 * c.ngeom), -1.0 / effective_step(u, u.planned)
    if solref[2 * leg_at(c.legs, 0).foot + 1] != damping:
        for index in range(c.leg_count):
            leg = leg_at(c.legs, index)
            solref[2 * leg.foot], solref[2 * leg.foot + 1] = -STIFFNESS, damping
        if not c.scuffs:  # risers decide about their contacts
            risers = numbers(c.risers, c.segments)
            for segment in range(c.segments):
                geom = int(risers[segment])
                if geom >= 0:
                    solref[2 * geom], solref[2 * geom + 1] = PUSHED_OUT * damping, damping
    for index in range(c.leg_count):
        leg = leg_at(c.legs, index)
        if leg.knee >= 0:
            _hold_knee(c, u, leg, index == int(u.stance), damping)


def _hold_knee(c: Constants, u: State, leg: Leg, stands: bool, damping: float) -> None:
    """Write whether a knee is locked in the next step, at which flexion, and how soft lock and stop are.

    A stance knee with a servo is locked only in the step in which the swing foot lands. A stance knee that opens in a
    touchdown is held only by its stop.

    Args:
        c: The walk's constants.
        u: State, after the observation.
        leg: Leg with the knee.
        stands: Whether the leg is the stance leg.
        damping: Damping with which constraints are plastic within the step, in MuJoCo's terms.
    """
    stop, lock = numbers(c.jnt_solref, 2 * c.njnt), numbers(c.eq_solref, 2 * c.neq)
    stop[2 * leg.stop], stop[2 * leg.stop + 1] = -LOCK_STIFFNESS, damping
    lock[2 * leg.lock], lock[2 * leg.lock + 1] = -LOCK_STIFFNESS, damping
    lands = u.lifted == u.stance
    if not stands:
        active, flexion = u.locked != 0.0 or u.bent != 0.0, u.bend if u.bent else 0.0
    elif c.knee_opens and lands:
        active, flexion = False, 0.0
    elif c.knee_stiffness > 0.0:
        active, flexion = lands, u.q[leg.knee]
    else:
        active, flexion = True, u.rest
    octets(c.eq_active, c.neq)[leg.lock] = 1 if active else 0
    numbers(c.eq_data, EQ_DATA * c.neq)[EQ_DATA * leg.lock] = flexion
