r"""Landing on the touchdown: how long each physics step is, how its contacts are damped, and how far it is kicked.

A touchdown falls between two steps of a fixed length: the foot sinks in before its contact counts, and the rates after
the impact are off by up to 11 %. Here a step ends where the foot meets the ground, and one short *contact step* makes
the impact. MuJoCo's Euler step is known before it is made: with the accelerations a that the solver found, it leads to

.. math:: v' = v + k \, a, \qquad x' = x + t \, v'

so the length t that leads to the ground is found exactly, in the sensor callback, where the integrator has not yet read
`opt.timestep` and `qacc`. What k is, and what else steps of changing length need, says `leapfrog`.

**Approach.** Before the touchdown, steps become shorter by a factor of 4 each: the impact is made of rates half a
step old, and a foot that happens to be out of contact falls meanwhile.

**Damping.** A contact's damping is 1 / k: plastic within the step. So the length that a step's contacts are made for is
*planned* one step ahead, in userdata. A step may become shorter than planned; the one that lands, half as long again.

**Faces.** Near a riser's face all steps are contact steps: the foot slides on it, or over its edge. They begin a step
or two before the face. Where the swing foot is let collide later than that, the long step that it is in is cut at once:
in the first short step after a long one accelerations act for half the long one, and an impact in it, damped for a
short one, would throw the foot back fifty times as fast as it came.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import TYPE_CHECKING

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.contact_events import State
from mjbiped.engines.mujoco.leapfrog import effective_step, note_lag, planned
from mjbiped.terrain.profile import height_over_ground, segment_under

if TYPE_CHECKING:
    from mjbiped.engines.mujoco.callbacks import Places, SimulationConstants

STIFFNESS = 1e3
"""Of a contact over the mass it meets, 1/s². `solimp` leaves 1e-4 of the load unborne, so a standing foot sinks by
1e-4 g over it, 1 µm. A stiffer one rests at some 10 nm, where MuJoCo's collision detection misses it now and then."""
DEPTH = 1e-6  # under the ground to which a step leads the swing foot, m; single precision of a heightfield is 3e-7
SHORTER = 4.0  # factor between the steps of the approach
MARGIN = 1e-3  # about a riser's face, m
HALVINGS = 50  # of a step, until only rounding is left
SHORTEST = 1e-9  # no step is shorter, s
LOOK_AHEAD = 1.5
"""Times the distance to the ground that a step and its approach may take: it is foreseen a step earlier."""


def softness(u: Sequence[float], time: float) -> tuple[float, float]:
    """The feet's `solref` for the step from now on; the same however often it is asked.

    Args:
        u: Userdata.
        time: Now, s.
    """
    step = planned(u, time)
    return -STIFFNESS, -1.0 / effective_step(step.plain, step.before, step.length)


def step_length(
    u: MutableSequence[float], constants: SimulationConstants, time: float, state: State, qacc: Sequence[float]
) -> float:
    """How long the step from now on is, s; notes its effective step, and plans the next one.

    Args:
        u: Userdata, after the control callback and `contact_events.read_contacts` of this time.
        constants: The walk's.
        time: Now, s.
        state: Now.
        qacc: The accelerations of the hip and of both legs.
    """
    length, following, plain = _approach(u, constants, state, qacc)
    # an impact is not cut in two; the tick waits for its end
    if constants.control_period > 0.0 and not u[events.NOTED]:
        due = u[events.NEXT_CONTROL] - time
        if due < length - SHORTEST:
            length, following, plain = due, u[events.PLANNED], 0.0
    collides = constants.stepped and u[events.CONTACT_ENABLED] and not u[events.NOTED]
    if collides and length > constants.contact_timestep and _reaches_face(constants, u, length, state, qacc):
        length = constants.contact_timestep
    if constants.stepped and u[events.CONTACT_ENABLED] and _near_face(constants, u, length, state, qacc):
        # the first of them still has half a long step's accelerations to come
        plain = 1.0 if plain or length <= constants.contact_timestep else 0.0
        following = constants.contact_timestep
    u[events.PLANNED_NEXT], u[events.PLAIN_NEXT] = following, plain
    u[events.EFFECTIVE_STEP] = effective_step(u[events.PLAIN], u[events.LAST_STEP], length)
    note_lag(u, constants, length, qacc)
    return length


def _approach(
    u: Sequence[float], constants: SimulationConstants, state: State, qacc: Sequence[float]
) -> tuple[float, float, float]:
    """Length of this step, and of the next one as planned, and whether that one is plain.

    As the distance of the swing foot to the ground asks for it.
    """
    length, shortest = u[events.PLANNED], constants.contact_timestep
    if u[events.NOTED] or not u[events.CONTACT_ENABLED]:
        return length, constants.timestep, 0.0
    if _clearance(constants, u, 0.0, state, qacc) <= 0.0:
        return length, shortest, 1.0  # it lies lower than where its contact should have been felt
    shorter = max(length / SHORTER, shortest)
    rest, part = 0.0, length  # of the approach
    while part > shortest:
        part = max(part / SHORTER, shortest)
        rest += part
    above, below = 0.0, length
    if _clearance(constants, u, below, state, qacc) > -DEPTH:
        below = LOOK_AHEAD * (length + rest)  # which may be behind an edge already
        if _clearance(constants, u, below, state, qacc) > -DEPTH:
            return length, constants.timestep, 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        if _clearance(constants, u, middle, state, qacc) > -DEPTH:
            above = middle
        else:
            below = middle
    if rest == 0.0:
        return max(below, SHORTEST), shortest, 1.0  # it lands; the next step is the contact step
    if below > length + rest:
        return length, length, 0.0
    if below > rest:
        return max(below - rest, SHORTEST), shorter, 0.0
    return max(0.5 * below, SHORTEST), shorter, 0.0  # seen late, behind an edge


def _foot(
    constants: SimulationConstants, u: Sequence[float], t: float, state: State, qacc: Sequence[float]
) -> tuple[float, float]:
    """Place of the swing foot after a step of length t, x and z in m."""
    qpos, qvel = state
    k = effective_step(u[events.PLAIN], u[events.LAST_STEP], t)
    x = qpos[0] + t * (qvel[0] + k * qacc[0])
    z = qpos[1] + t * (qvel[1] + k * qacc[1])
    swing = 2 if u[events.STANCE] else 3
    leg = qpos[swing] + t * (qvel[swing] + k * qacc[swing])
    length = constants.limits.leg_length
    return x - length * math.sin(leg), z - length * math.cos(leg)


def _clearance(
    constants: SimulationConstants, u: Sequence[float], t: float, state: State, qacc: Sequence[float]
) -> float:
    """Height of the swing foot over the ground after a step of length t, m."""
    x, z = _foot(constants, u, t, state, qacc)
    return height_over_ground(constants.places.profile, x, z)


def _near_face(
    constants: SimulationConstants, u: Sequence[float], t: float, state: State, qacc: Sequence[float]
) -> bool:
    """Whether the swing foot could touch a riser in the step after this one, which is of length t."""
    x, z = _foot(constants, u, t, state, qacc)
    further, _ = _foot(constants, u, t + 2.0 * constants.timestep, state, qacc)
    margin = MARGIN + abs(further - x)
    return face_between(constants.places, x, z, x - margin, x + margin, margin)


def _reaches_face(
    constants: SimulationConstants, u: Sequence[float], t: float, state: State, qacc: Sequence[float]
) -> bool:
    """Whether the swing foot comes to a riser within this step of length t."""
    here, _ = _foot(constants, u, 0.0, state, qacc)
    x, z = _foot(constants, u, t, state, qacc)
    return face_between(constants.places, x, z, min(here, x) - MARGIN, max(here, x) + MARGIN, MARGIN)


def face_between(places: Places, x: float, z: float, low: float, high: float, margin: float) -> bool:
    """Whether the face behind or ahead of a foot at x, z lies between two places, and the foot no higher than that."""
    profile, rises = places.profile, places.rises
    segment = segment_under(profile, x)
    for index in range(segment, min(segment + 2, len(profile.x))):
        rise, top = rises[index], profile.z[index]
        if rise != 0.0 and low < profile.x[index] < high and z < max(top, top - rise) + margin:
            return True
    return False
