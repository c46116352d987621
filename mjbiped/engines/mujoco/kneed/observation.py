"""Takes in the state of a biped with knees at a new time: impacts that were made, slip, and the walk's end."""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import Any

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.kneed import feet
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.servo import lean_on
from mjbiped.engines.mujoco.kneed.state import (
    COORDINATES,
    KNEES,
    THIGHS,
    Buffers,
    Constants,
    Parts,
    Scene,
    X,
    Z,
    angles_of,
    foot_of,
    rates_of,
    stance_of,
)
from mjbiped.records.rows import write_kneed_touchdown
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import height_of, segment_stood_on

OPENED = 1e-4  # rad: a knee that bends less rests against its stop, and does not strike it
_DIVERGED = float(Outcome.DIVERGED)


def look(u: MutableSequence[float], scene: Scene) -> bool:
    """Read the state from MuJoCo; whether all of it are numbers."""
    sound = True
    for index in range(COORDINATES):
        place, rate = float(scene.qpos[index]), float(scene.qvel[index])
        if not (math.isfinite(place) and math.isfinite(rate)):
            sound = False
        u[at.OLD_Q + index], u[at.OLD_RATES + index] = u[at.Q + index], u[at.RATES + index]
        u[at.Q + index], u[at.QVEL + index] = place, rate
        u[at.RATES + index] = rate + u[at.LAG + index]
    u[at.OLD_TILT], u[at.OLD_SHARE] = u[at.TILT], u[at.SHARE]
    return sound


def observe(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """Take in the state at a new time, after `look`."""
    u, limits, profile = buffers.u, constants.limits, constants.places.profile
    if constants.servo.stiffness > 0.0:
        lean_on(constants, u, stance_of(u))
    time = u[at.CLOCK]
    step = time - u[events.TIME]
    begun = u[events.TIME] < 0.0
    if not begun:
        for index in range(constants.states):
            buffers.memory[index] += step * buffers.rates[index]
    impact = u[events.NOTED] != 0.0 or u[at.STRUCK] != 0.0
    u[at.TURNS] = 0.0 if impact or begun else 1.0
    u[events.LAST_STEP] = 0.0 if impact or begun else step
    u[events.TIME] = time
    if u[at.STRUCK] != 0.0:
        _note_strike(parts, parameters, buffers)
    if u[at.STRUCK] != 0.0 or u[events.NOTED] == 0.0:
        events.weigh(u, limits)
    flexion = u[at.Q + KNEES[1 - stance_of(u)]]
    u[at.FLEXION] = max(u[at.FLEXION], flexion)
    if flexion > OPENED and u[at.LOCKED] == 0.0:
        u[at.OPENED] = 1.0
    if u[events.NOTED] != 0.0:
        _transfer(parts, parameters, constants, buffers)
        if u[events.OUTCOME] == _DIVERGED:
            return
    stance = stance_of(u)
    hip, foot = (u[at.Q + X], u[at.Q + Z]), foot_of(constants.links, at.Q, u, stance)
    events.judge(u, limits, profile, time, hip, foot, u[at.Q + THIGHS[stance]])


def begin_step(constants: Constants, u: MutableSequence[float], scene: Scene) -> None:
    """Begin anew what is told of one step alone; the new swing foot leaves the ground."""
    events.forget_step(u)
    u[at.LOCKED] = u[at.BENT] = u[at.OPENED] = u[at.CLEAR] = u[at.FLEXION] = u[at.STUBS] = 0.0
    u[at.TOUCHING], u[at.PEAK_HOLD] = 1.0, 0.0
    for index in range(at.STRIKE_TIME, at.SCALARS):
        u[index] = math.nan
    stand(constants, u, scene)


def stand(constants: Constants, u: MutableSequence[float], scene: Scene) -> None:
    """Say what the stance foot meets where it stands."""
    stance = stance_of(u)
    x, z = foot_of(constants.links, at.Q, u, stance)
    feet.stand(constants.places, scene, stance, x, z)
    u[at.MET] = -1.0


def _note_strike(parts: Parts, parameters: Any, buffers: Buffers) -> None:
    """The knee has struck its stop in the step before: it is locked, and the controller is told."""
    u = buffers.u
    stance, slope = stance_of(u), u[events.SLOPE]
    t = u[events.TIME] - u[events.TRANSFER_TIME]
    q, dq = angles_of(u, at.Q, stance, slope), rates_of(u, at.RATES, stance)
    u[at.STRIKE_TIME] = t
    _put(u, at.STRIKE_Q, angles_of(u, at.OLD_Q, stance, slope))
    _put(u, at.STRIKE_RATES, rates_of(u, at.OLD_RATES, stance))
    _put(u, at.STRUCK_RATES, dq)
    parts.knee_strike(parameters, buffers.memory, t, q, dq)


def _put(u: MutableSequence[float], first: int, three: tuple[float, float, float]) -> None:
    u[first], u[first + 1], u[first + 2] = three


def _three(u: Sequence[float], first: int) -> tuple[float, float, float]:
    return u[first], u[first + 1], u[first + 2]


def _transfer(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """Exchange the legs' roles; the knee of the new swing leg is free, and the controller is told.

    The new stance knee stays locked as it is, straight or bent, or is held so by its servo from now on.

    No row tells of a foot that is not on the ground: the walk has then diverged.
    """
    u, memory, scene = buffers.u, buffers.memory, buffers.scene
    limits, profile = constants.limits, constants.places.profile
    old = stance_of(u)
    q_before = angles_of(u, at.OLD_Q, old, u[events.SLOPE])
    dq_before = rates_of(u, at.OLD_RATES, old)
    leg = 1 - old
    x, z = foot_of(constants.links, at.Q, u, leg)
    segment = segment_stood_on(profile, x, z)
    if not abs(z - height_of(profile, segment, x)) <= events.MISSED * limits.leg_length:
        if u[events.OUTCOME] == 0.0:
            u[events.OUTCOME] = _DIVERGED
        return
    slope = -math.atan(profile.gradient[segment])
    servo = constants.servo.stiffness > 0.0
    if servo:
        lean_on(constants, u, leg)
        u[at.REST] = u[at.BEND] if u[at.BENT] != 0.0 else 0.0
    elif u[at.BENT] != 0.0:
        u[at.REACH], lean = bent_leg(constants.links.thigh_length, constants.links.shank_length, u[at.BEND])
        u[at.TILT] = u[at.BEND] - lean
    else:
        u[at.REACH], u[at.TILT] = limits.leg_length, 0.0
    q, dq = angles_of(u, at.Q, leg, slope), rates_of(u, at.RATES, leg)
    hold, hold_work = (u[at.PEAK_HOLD], u[at.WORK_HOLD]) if servo else (math.nan, math.nan)
    before = parts.slope_estimate(parameters, memory)
    parts.touchdown(parameters, memory, q_before, q, dq)
    write_kneed_touchdown(
        buffers.rows[int(u[events.ROWS])],
        0,
        time=u[events.TIME],
        qpos=(u[at.Q], u[at.Q + 1], u[at.Q + 2], u[at.Q + 4], u[at.Q + 3], u[at.Q + 5]),
        x=x,
        z=z,
        stance=float(leg),
        slope=slope,
        q_before=q_before,
        dq_before=dq_before,
        q=q,
        dq=dq,
        work_absolute=u[events.WORK_ABSOLUTE],
        work_net=u[events.WORK_NET],
        work_positive=u[events.WORK_POSITIVE],
        slip=u[events.SLIP],
        penetration=u[events.PENETRATION],
        friction=u[events.FRICTION],
        strikes=u[events.FACE_IMPACTS],
        slope_estimate_before=before,
        slope_estimate=parts.slope_estimate(parameters, memory),
        normal_force=events.least_normal_force(u),
        pressure_ahead=u[events.PRESSURE_AHEAD],
        pressure_behind=u[events.PRESSURE_BEHIND],
        knee_strike=u[at.STRIKE_TIME],
        knee_q=_three(u, at.STRIKE_Q),
        knee_dq_before=_three(u, at.STRIKE_RATES),
        knee_dq=_three(u, at.STRUCK_RATES),
        flexion=u[at.FLEXION],
        stubs=u[at.STUBS],
        stance_knee_torque=hold,
        stance_knee_work=hold_work,
    )
    u[events.ROWS] += 1.0
    u[events.STANCE], u[events.SLOPE], u[events.TRANSFER_TIME] = float(leg), slope, u[events.TIME]
    u[events.FOOT_X], u[events.FOOT_Z], u[events.FOOT_ANGLE] = x, z, u[at.Q + THIGHS[leg]]
    u[events.COUNT] += 1.0
    # until the controller ticks: the motors that drive other joints now are off, the hip's goes on
    u[events.ANKLE], u[events.HIP], u[at.KNEE] = 0.0, -u[events.HIP], 0.0
    scene.eq_active[constants.motors.locks[old]] = False
    if servo:
        scene.eq_active[constants.motors.locks[leg]] = False
        scene.eq_data[constants.motors.locks[leg], 0] = 0.0
    scene.eq_data[constants.motors.locks[old], 0] = 0.0  # where its stop is
    begin_step(constants, u, scene)
    events.judge_touchdown(u, limits)
