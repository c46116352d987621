"""The state of a walk in MuJoCo, which lasts from one physics step to the next.

`State` stands at the beginning of `mjData.userdata`, so that a walk can be copied, saved and resumed with MuJoCo's own
state functions. Behind it stand the last touchdown's row, the controller's memory, and the rates of its integrated
states. One source works on all of it in plain Python and as machine code, bit by bit the same
(`mjbiped.numerics.blocks`).
"""

from __future__ import annotations

import ctypes
from collections.abc import MutableSequence
from typing import Any

from mjbiped.numerics.blocks import Floats, reader
from mjbiped.records.loads import BINS

COORDINATES = 6
"""Room for as many coordinates of a robot: hip x and z, and the angles of its legs' joints."""
ANGLES = 3
"""Room for as many angles, and joints with motors."""

X, Z = 0, 1

MARK = 7.385102934e-305
"""Mark in the userdata of a walk; the userdata of other models lack this mark."""


class State(ctypes.Structure):
    """What is remembered from one physics step to the next: plain numbers, zeros before a walk begins.

    A field of coordinates is in the order of `qpos`, one of angles in the order of `Robot.angles`, or of
    `Robot.joints` where it is of torques.
    """

    mark: float  # `MARK`; 0 in zeroed userdata, where nothing acts
    time: float  # of the last observation, s
    asked: float  # time of the last control callback, s
    planned: float  # length for which the contacts of a physics step are made, s: from its end on that of the next
    plain: float  # 1: the effective step is as long as the step itself
    effective_step: float  # time for which the accelerations act in the step, s
    last_step: float  # length of the step before, s; 0 just after an impact
    smooth: float  # 1: the accelerations of the step before are those of a motion without an impact
    stance: float  # number of the leg that stands: the remainder of `count` by the number of legs
    transfer_time: float  # of the last support transfer, s
    next_control: float  # when the controller ticks next, s
    ticked: float  # when it ticked last, s
    next_sample: float  # when a sample is due, s
    samples: float  # number that waits to be taken from the recording
    rows: float  # number of touchdowns that waits there
    transferred: float  # 1: there was a support transfer that the controller does not know of yet
    enabled: float  # 1: the swing foot may collide, by the scuffing rule
    collides: float  # 1: it does in this step
    slope: float  # of the ground under the stance foot, rad
    old_slope: float  # that at the observation before
    foot_x: float  # stance foot at the support transfer, m
    foot_z: float
    foot_angle: float  # what stands on it at the support transfer, from the vertical, rad
    noted: float  # 1: a touchdown was resolved in the last step
    work_absolute: float  # since the start, J
    work_net: float
    work_positive: float
    bound_time: float  # in which the sole did not transmit the ankle torque asked for, since the start, s
    ankle: float  # torque that the law asks of the ankle, held, N m
    turns: float  # 1: motors have turned the joints since the observation before
    slip: float  # greatest distance that the stance foot slid along the ground in this gait step, m
    slides: float  # gait steps in which it slid farther than a standing foot does
    penetration: float  # greatest depth of a foot in this gait step, m
    friction: float  # greatest |F_t| / F_n in this gait step, of those that last
    ratio: float  # |F_t| / F_n in the physics step last resolved
    least_ratio: float  # least of those since a ratio was last taken
    ratio_time: float  # how long that is ago, s
    force: float  # normal force of the stance foot in the physics step last resolved, N
    impulse: float  # of that force since the last stretch ended over which it is averaged, N s
    stretch: float  # how long that is ago, s
    pressing: float  # normal forces of all contacts of both feet in the physics step last resolved, N
    load: float  # impulse of these since a stretch ended over which they are averaged, N s
    load_time: float  # how long that is ago, s
    contact_force: float  # greatest average of these in this gait step, N
    squeezes: float  # gait steps in which that was more than any motion asks for
    without_contact: float  # how long the stance foot has had none, s
    normal_force: float  # least average in this gait step, N
    ankle_impulse: float  # of the ankle's torque over the same stretch, N m s
    face_impacts: float  # 1: the swing foot struck a vertical face in this gait step
    next_push: float  # when the next push begins, or the present one has begun, s
    push_impulse: float  # of it, N s
    pushes: float  # number that has ended
    pushing: float  # 1: a push is under way
    push_left: float  # what is left of its impulse, N s
    push: float  # its force at the hip along x, N
    count: float  # touchdowns so far
    outcome: float
    over: float  # 1: the outcome was known at the last control callback
    # what a knee needs
    locked: float  # 1: the swing knee is, against its stop
    opened: float  # 1: it has been bent in this gait step
    strikes: float  # 1: it strikes its stop in the step under way; from that step's end on, in the next one
    softened: float  # 1: it is locked for that by what `softness.soften` has written last
    acted: float  # 1: by what that has written before
    struck: float  # 1: it did in the step last resolved
    strike_untold: float  # 1: the controller does not know of the strike yet
    strike_time: float  # of the knee strike, from the support transfer on, s; NaN: there was none
    flexion: float  # greatest in this gait step, rad
    lifted: float  # leg whose foot passes through the ground, as it leaves it in this step; -1: none
    clear: float  # height of the swing foot over the ground, m
    touching: float  # 1: the swing foot has not left the ground since it last touched it
    stubs: float  # in this gait step
    bent: float  # 1: the swing knee is locked as it is, for a touchdown in this step
    bend: float  # flexion at which it is, rad
    rest: float  # flexion at which the stance knee is locked, or held by its servo, rad
    tilt: float  # of the line from stance foot to hip, from the stance thigh, rad: 0 where that knee is straight
    old_tilt: float  # that at the observation before
    share: float  # of the stance knee's rate in the rate of that line, beside the thigh's: 0 where the knee is locked
    old_share: float
    reach: float  # length of that line, m
    hold: float  # torque of the servo at the stance knee, N m
    peak_hold: float  # greatest in this gait step, N m
    work_hold: float  # its absolute work since the start, J
    # what a foot that turns about an ankle needs
    stood: float  # angle of the stance foot when it came to stand, rad
    level: float  # what the feet take the ground's slope to be, rad
    flat: float  # 1: the ground bore the stance foot on both sides of the ankle in the step last resolved
    tipped: float  # greatest angle by which the stance foot has tipped in this gait step, rad
    one_sided: float  # time in this gait step in which the stance foot was borne on one side alone, or not at all, s
    touched: float  # when the swing foot touched the ground first, s; NaN: it is in the air
    down: float  # when it touched it last, s
    support_behind: float  # how far behind its ankle the ground bore the stance foot when it came to stand, m
    support_ahead: float  # how far ahead of it
    intrusion: float  # how high the ground stood over the line from its heel to its toe, m
    intrusions: float  # number of footholds where that was more than `observation.INTRUDES`
    moment: float  # of the stance foot's contacts about the ankle, as an ankle's torque, N m, in the step last resolved
    shear: float  # friction force of the stance foot in the step last resolved, N
    shear_impulse: float  # of it since the last stretch ended over which forces are averaged, N s
    foot_torque: float  # that holds the swing foot, N m

    q: Coordinates  # qpos at the last observation
    rates: Coordinates  # their rates then
    old_q: Coordinates  # qpos at the observation before
    old_rates: Coordinates
    rates_before: Coordinates  # rates when the swing foot was last not about to stand flat
    qvel: Coordinates  # `mjData.qvel` then, which shows the velocity stage other rates
    qacc: Coordinates  # accelerations in the step last resolved
    acceleration: Coordinates  # those of the step before it, where `smooth` says so
    lag: Coordinates  # what `qvel` lacks to be the rates of the observation's time; see `step`
    angles: Angles  # from the normal of the ground under the stance foot, rad
    turning: Angles  # their rates, rad/s
    torque: Angles  # held, N m
    peak: Angles  # greatest magnitudes since the start, N m
    told_before: Angles  # angles at the touchdown, in the roles of the gait step that ended, rad
    told_q: Angles  # those in the new roles
    told_dq: Angles  # their rates just after it, rad/s
    strike_q: Angles  # angles just before the knee strike, rad
    strike_rates: Angles  # their rates, rad/s
    struck_q: Angles  # angles just after it, rad
    struck_rates: Angles  # their rates, rad/s
    pressure: Pressure  # greatest distances of the centre of pressure ahead of the ankle and behind it, m, then times
    """Times by places of the centre of pressure, s; see `records.pressure`."""


_KINDS: dict[str, Any] = {
    "float": ctypes.c_double,
    "Coordinates": ctypes.c_double * COORDINATES,
    "Angles": ctypes.c_double * ANGLES,
    "Pressure": ctypes.c_double * (2 + BINS),
}
State._fields_ = [(name, _KINDS[kind]) for name, kind in State.__annotations__.items()]

SIZE = ctypes.sizeof(State) // ctypes.sizeof(ctypes.c_double)
"""Floats of `State`."""

Coordinates = MutableSequence[float]
Angles = MutableSequence[float]
Pressure = MutableSequence[float]

state_at = reader(State)


def put(into: Floats, three: tuple[float, float, float]) -> None:
    """Write three angles, or their rates."""
    into[0], into[1], into[2] = three


def effective_step(u: State, length: float) -> float:
    """Time for which accelerations act in a step of a length, s: see `step_size`."""
    return length if u.plain else 0.5 * (u.last_step + length)
