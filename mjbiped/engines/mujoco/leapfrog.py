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
integrator. So in `mjcb_sensor`'s position stage `qvel` is *shown* other rates, and in `mjcb_control`, which comes
between the two, it is put back. What is shown differs from the state's rates by the lag of the legs, and by a velocity
of the hip, of which no Coriolis force depends. A step that makes an impact is MuJoCo's own.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import TYPE_CHECKING, NamedTuple

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.contact_events import State
from mjbiped.rules.termination import STALL_TIME

if TYPE_CHECKING:
    from mjbiped.engines.mujoco.callbacks import SimulationConstants


class Planned(NamedTuple):
    """What is known of a step when it begins.

    Attributes:
        length: That its contacts are made for, s.
        plain: Whether accelerations act in it for as long as it is, as in MuJoCo: 0 or 1.
        before: Length of the step that led to it, s; 0 where the motion begins anew.
        right: Whether the right leg stands: 0 or 1.
        left_lag: What the left leg's rate in `qvel` lacks to be that of now, rad/s.
        right_lag: The same of the right leg.
    """

    length: float
    plain: float
    before: float
    right: float
    left_lag: float
    right_lag: float


def planned(u: Sequence[float], time: float) -> Planned:
    """Of the step from now on; the same however often it is asked.

    Args:
        u: Userdata.
        time: Now, s.
    """
    if time > u[events.TIME]:  # not observed yet
        right = 1.0 - u[events.STANCE] if u[events.NOTED] else u[events.STANCE]
        length, plain, before = u[events.PLANNED_NEXT], u[events.PLAIN_NEXT], step_before(u, time)
        return Planned(length, plain, before, right, u[events.LEFT_LAG_NEXT], u[events.RIGHT_LAG_NEXT])
    length, plain, before = u[events.PLANNED], u[events.PLAIN], u[events.LAST_STEP]
    return Planned(length, plain, before, u[events.STANCE], u[events.LEFT_LAG], u[events.RIGHT_LAG])


def step_before(u: Sequence[float], time: float) -> float:
    """How long the step was that led to a time (s) not observed yet; 0 where the motion begins anew with it, s."""
    return 0.0 if u[events.NOTED] or u[events.TIME] < 0.0 else time - u[events.TIME]


def effective_step(plain: float, before: float, length: float) -> float:
    """Time for which accelerations act in a step, by its length and that of the one before, s."""
    return length if plain else 0.5 * (before + length)


def note_lag(u: MutableSequence[float], constants: SimulationConstants, length: float, qacc: Sequence[float]) -> None:
    """Note what the rates will lack after this step.

    Args:
        u: Userdata, after `contact_events.read_contacts` of this time.
        constants: The walk's.
        length: Of the step, s.
        qacc: The accelerations of the hip and of both legs.
    """
    impact = u[events.NOTED] or u[events.PLAIN]
    lag = 0.0 if impact else 0.5 * length  # rates after an impact are those of its end
    left, right = qacc[2], qacc[3]
    if u[events.SMOOTH]:
        falling = STALL_TIME / constants.limits.stall_time
        left = limited(left, u[events.LEFT_ACCELERATION], falling * falling)
        right = limited(right, u[events.RIGHT_ACCELERATION], falling * falling)
    u[events.LEFT_LAG_NEXT], u[events.RIGHT_LAG_NEXT] = lag * left, lag * right
    u[events.SMOOTH] = 0.0 if impact else 1.0
    u[events.LEFT_ACCELERATION], u[events.RIGHT_ACCELERATION] = qacc[2], qacc[3]


def limited(acceleration: float, before: float, least: float) -> float:
    """An acceleration that differs from the one before by no more than that one's size and `least`, in rad/s²."""
    room = abs(before) + least
    return min(max(acceleration, before - room), before + room)


def rates_now(u: Sequence[float], state: State) -> State:
    """The state with the legs' rates of now; u is userdata with the lag of this time."""
    hip_x, hip_z, left, right = state.qvel
    return State(state.qpos, (hip_x, hip_z, left + u[events.LEFT_LAG], right + u[events.RIGHT_LAG]))


def show(
    u: MutableSequence[float],
    constants: SimulationConstants,
    qpos: Sequence[float],
    qvel: MutableSequence[float],
    time: float,
) -> None:
    """`mjcb_sensor` at the position stage: let `qvel` be what the velocity stage is to see.

    Args:
        u: Userdata, where the state's rates are kept meanwhile.
        constants: The walk's.
        qpos: Hip x, hip z (m), left and right leg (rad).
        qvel: Their rates, to be changed.
        time: Now, s.
    """
    if not (u[events.RUNNING] and constants.lands):
        return
    put_back(u, qvel)
    for index in range(4):
        u[events.QVEL + index] = qvel[index]
    u[events.SHOWN] = 1.0
    step = planned(u, time)
    if step.plain:
        return
    leg, rate, lag = (qpos[3], qvel[3], step.right_lag) if step.right else (qpos[2], qvel[2], step.left_lag)
    limits = constants.limits
    foot = Foot(limits.leg_length, limits.foot_radius, u[events.SLOPE])
    shown_x, shown_z = held(foot, leg, rate, lag, step.length, step.before)
    qvel[0] += shown_x
    qvel[1] += shown_z
    qvel[2] += step.left_lag
    qvel[3] += step.right_lag


class Foot(NamedTuple):
    """What stands on the ground.

    Attributes:
        reach: Distance of the hip from it, m.
        radius: Of the sphere that makes its contact, m.
        slope: Of its ground, rad.
    """

    reach: float
    radius: float
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
    rolling = foot.radius * turning  # of the sphere, whose centre is what stands
    return (
        foot.reach * (mean_x + cosine * (turning + lag)) + rolling * math.cos(foot.slope),
        foot.reach * (mean_z - sine * (turning + lag)) - rolling * math.sin(foot.slope),
    )


def put_back(u: MutableSequence[float], qvel: MutableSequence[float]) -> None:
    """`mjcb_control`, first: let `qvel` be the state's rates again."""
    if u[events.SHOWN]:
        for index in range(4):
            qvel[index] = u[events.QVEL + index]
        u[events.SHOWN] = 0.0
