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
from typing import Any, NamedTuple

from mjbiped.engines.mujoco.legs import stance_leg, turning_of
from mjbiped.engines.mujoco.state import X, Z
from mjbiped.rules.termination import STALL_TIME


def effective_step(plain: float, before: float, length: float) -> float:
    """Time for which accelerations act in a step, by its length and that of the one before, s."""
    return length if plain else 0.5 * (before + length)


def note_lag(c: Any, u: Any, length: float) -> None:
    """Note what the rates will lack after this step.

    Args:
        c: The walk's constants.
        u: State, after `bearing.read_contacts` of this time.
        length: Of the step, s.
    """
    impact = u.noted or u.struck or u.plain
    lag = 0.0 if impact else 0.5 * length  # rates after an impact are those of its end
    falling = STALL_TIME / c.stall_time
    for index in range(2, c.nq):  # the hip's is not shown
        acceleration = u.qacc[index]
        if u.smooth:
            acceleration = limited(acceleration, u.acceleration[index], falling * falling)
        u.lag[index] = lag * acceleration
    u.smooth = 0.0 if impact else 1.0
    if c.knee_stiffness > 0.0:
        # a stop that is shown a rate of now leaves a knee that lies against it swinging, and off it now and then
        u.lag[stance_leg(c, u).knee] = 0.0


def limited(acceleration: float, before: float, least: float) -> float:
    """An acceleration that differs from the one before by no more than that one's size and `least`, in rad/s²."""
    room = abs(before) + least
    return min(max(acceleration, before - room), before + room)


def show(c: Any, u: Any, qvel: MutableSequence[float]) -> None:
    """Let rates be what MuJoCo's velocity stage is to see.

    Args:
        c: The walk's constants.
        u: State, after the observation of this time.
        qvel: The robot's rates, to be changed.
    """
    if u.plain:
        return
    stance = stance_leg(c, u)
    foot = Foot(u.reach, c.foot_radius, c.rolling_radius, u.old_slope if c.scuffs else u.slope)
    turning, lag = turning_of(stance, qvel, u.share), turning_of(stance, u.lag, u.share)
    shown_x, shown_z = held(foot, u.q[stance.hip] + stance.offset + u.tilt, turning, lag, u.planned, u.last_step)
    for index in range(2, c.nq):
        qvel[index] += u.lag[index]
    qvel[X] += shown_x
    qvel[Z] += shown_z


class Foot(NamedTuple):
    """What stands on the ground.

    Attributes:
        reach: Distance of the hip from it, m.
        radius: Of the sphere that makes its contact, m, by which it is larger than the foot.
        rolling: Of the foot, m: of a round one the centre moves as it rolls, a point stays.
        slope: Of its ground, rad.
    """

    reach: float
    radius: float
    rolling: float
    slope: float


def held(foot: Foot, leg: float, rate: float, lag: float, length: float, before: float) -> tuple[float, float]:
    """What is added to the hip's velocity, so that the stance foot ends the step where it was: along x and z, m/s.

    Args:
        foot: What stands.
        leg: Angle of the line from it to the hip, rad.
        rate: Its rate in `qvel`, rad/s.
        lag: What that lacks to be the rate of now, rad/s.
        length: Of the step, s.
        before: Length of the step that led to it, s; 0 where the motion begins anew.
    """
    turning = rate
    if before > 0.0:
        turning += lag * (1.0 + length / before)  # in the middle of this step, by the acceleration before it
    sine, cosine = math.sin(leg), math.cos(leg)
    turned = leg + length * turning
    # what turning makes of the foot's velocity: in the mean of the step, less what it seems to make at its beginning
    mean_x, mean_z = (sine - math.sin(turned)) / length, (cosine - math.cos(turned)) / length
    # of the sphere beyond the foot, and of the foot by what it is shown more than it turns
    rolling = foot.radius * turning + foot.rolling * lag
    return (
        foot.reach * (mean_x + cosine * (turning + lag)) + rolling * math.cos(foot.slope),
        foot.reach * (mean_z - sine * (turning + lag)) - rolling * math.sin(foot.slope),
    )
