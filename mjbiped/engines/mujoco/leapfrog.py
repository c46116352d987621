r"""What MuJoCo's steps lack to be of second order: rates of now, and a stance foot that is held at a step's end.

MuJoCo's Euler step, with the accelerations a that the solver found at its beginning,

.. math:: v' = v + k \, a, \qquad x' = x + t \, v'

is a leapfrog: v' belongs to the middle of the step. Everything that MuJoCo finds from the rates would be half a step
late. Nothing of the analytic model is used to mend that, only the step itself and how a foot turns about the hip.

**Effective step.** In MuJoCo k = t, as it must be as long as all steps are of one length. Where the length changes, k
must be the mean of this step's length and of the one before, and half this step's after an impact, whose rates belong
to its end. Otherwise each gait step begins and ends with rates that are off by t a / 2. So there, and nowhere else,
`qacc` is scaled by k / t before the integrator takes it.

**Lag.** The rates of now are v + t a / 2, with t and a of the step before. These the controller is told, they are
recorded, and MuJoCo's Coriolis forces are of them. Where a foot that slides loses the ground and finds it again, a is
an impulse over t, of which v holds the whole already. So a is taken to differ from that of the step before it by no
more than that one's size and g / l, as slope limiters do.

**Held foot.** A contact's damping of 1 / k brings the foot's velocity J v' to rest, with J of the step's *beginning*:
MuJoCo's reference acceleration leaves the change of J out. Turned by t q̇, a foot at rest so leaves its place by
t² l q̇² / 2 in each step, upward, until its contact is lost, and backward. And what is brought to rest is the lowest
point of the foot's sphere, which so rolls on. Shown a velocity that is larger by just what turning will add in the
step, and by that of the centre of a sphere that rolls, the solver takes both away, and the foot ends the step where it
was.

MuJoCo reads `qvel` in its velocity stage, for the Coriolis forces and the contacts' damping, and again in the
integrator. So the velocity stage alone is *shown* other rates (`step.step`). They differ from the state's rates by the
lag of the legs, and by a velocity of the hip, of which no Coriolis force depends. An impact's step is MuJoCo's own.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from mjbiped.engines.mujoco.constants import Constants, stance_leg, turning_of
from mjbiped.engines.mujoco.state import State, X, Z
from mjbiped.rules.termination import STALL_TIME


def effective_step(plain: float, before: float, length: float) -> float:
    """Time for which accelerations act in a step, by its length and that of the one before, s."""
    return length if plain else 0.5 * (before + length)


def note_lag(c: Constants, u: State, length: float) -> None:
    """Note what the rates will lack after this step.

    Args:
        c: The walk's constants.
        u: State, after `bearing.read_contacts` of this time.
        length: Of the step, s.
    """
    impact = u.noted or u.struck or u.plain
    lag = 0.0 if impact else 0.5 * length  # rates after an impact are those of its end
    falling = (STALL_TIME / c.stall_time) * (STALL_TIME / c.stall_time)
    for index in range(2, c.nq):  # the hip's is not shown
        acceleration = u.qacc[index]
        if u.smooth:
            before = u.acceleration[index]
            room = abs(before) + falling
            acceleration = min(max(acceleration, before - room), before + room)
        u.lag[index] = lag * acceleration
    u.smooth = 0.0 if impact else 1.0
    if c.knee_stiffness > 0.0:
        # a stop that is shown a rate of now leaves a knee that lies against it swinging, and off it now and then
        u.lag[stance_leg(c, u).knee] = 0.0


def show(c: Constants, u: State, qvel: MutableSequence[float]) -> None:
    """Let rates be what MuJoCo's velocity stage is to see, so that the stance foot ends the step where it was.

    Args:
        c: The walk's constants.
        u: State, after the observation of this time.
        qvel: The robot's rates, to be changed.
    """
    if u.plain:
        return
    stance, slope, length = stance_leg(c, u), u.old_slope if c.scuffs else u.slope, u.planned
    turning, lag = turning_of(stance, qvel, u.share), turning_of(stance, u.lag, u.share)
    leg = u.q[stance.hip] + stance.offset + u.tilt
    if u.last_step > 0.0:
        turning += lag * (1.0 + length / u.last_step)  # in the middle of this step, by the acceleration before it
    sine, cosine = math.sin(leg), math.cos(leg)
    turned = leg + length * turning
    # what turning makes of the foot's velocity: in the mean of the step, less what it seems to make at its beginning
    mean_x, mean_z = (sine - math.sin(turned)) / length, (cosine - math.cos(turned)) / length
    # of the sphere beyond the foot, and of the foot by what it is shown more than it turns
    rolling = c.foot_radius * turning + c.rolling_radius * lag
    for index in range(2, c.nq):
        qvel[index] += u.lag[index]
    qvel[X] += u.reach * (mean_x + cosine * (turning + lag)) + rolling * math.cos(slope)
    qvel[Z] += u.reach * (mean_z - sine * (turning + lag)) - rolling * math.sin(slope)
