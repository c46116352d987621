"""Which foot leaves the ground in a physics step, and passes through it."""

from __future__ import annotations

from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.feet import lands_flat
from mjbiped.engines.mujoco.legs import Leg, end_of_leg, foot_of, swing_index, swing_leg
from mjbiped.engines.mujoco.state import State, X, Z
from mjbiped.terrain.profile import height_over_ground

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
