"""How soft contacts, locks and stops are in a physics step: plastic within it."""

from __future__ import annotations

from mjbiped.engines.mujoco.constants import Constants, Leg, leg_at
from mjbiped.engines.mujoco.leapfrog import effective_step
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import numbers, octets
from mjbiped.utils.mujoco import mujoco

STIFFNESS = 1e3
"""Of a contact over the mass it meets, 1/s². `solimp` leaves 1e-4 of the load unborne, so a standing foot sinks by
1e-4 g over it, 1 µm. A stiffer one rests at some 10 nm, where MuJoCo's collision detection misses it now and then."""
LOCK_STIFFNESS = 1e5
"""Of a locked or stopped knee over the inertia that it meets, 1/s². `solimp` leaves 1e-4 of the load unborne, and a
light shank under the robot's weight would be turned at some 1e3 rad/s²: so it bends by 1e-6 rad."""
PUSHED_OUT = 100.0
"""Share of its depth by which a foot comes out of a riser's face again, 1/s: in 10 ms, before it slides down to the
ground, whose edge it would miss by that depth."""
EQ_DATA = int(mujoco.mjNEQDATA)  # floats of an equality constraint


def soften(c: Constants, u: State) -> None:
    """Write how soft contacts, locks and stops are in the step to come: plastic within it. And which knees are locked.

    Args:
        c: The walk's constants.
        u: State, after the observation.
    """
    u.acted, u.softened = u.softened, u.strikes
    solref, damping = numbers(c.geom_solref, 2 * c.ngeom), -1.0 / effective_step(u.plain, u.last_step, u.planned)
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
    """Write whether a knee is locked in the step to come, at which flexion, and how soft lock and stop are.

    A stance knee with a servo is locked in the step alone in which the swing foot lands, and one that opens in a
    touchdown is held by its stop alone.

    Args:
        c: The walk's constants.
        u: State, after the observation.
        leg: With the knee.
        stands: Whether the leg is the stance leg.
        damping: Of constraints that are plastic within the step, as MuJoCo has it.
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
        active, flexion = lands, u.q[leg.knee] if lands else 0.0
    else:
        active, flexion = True, u.rest
    octets(c.eq_active, c.neq)[leg.lock] = 1 if active else 0
    numbers(c.eq_data, EQ_DATA * c.neq)[EQ_DATA * leg.lock] = flexion
