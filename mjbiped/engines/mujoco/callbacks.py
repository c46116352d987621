"""What MuJoCo's callbacks do in a walk, as functions of plain numbers: the same source as Python and compiled.

`mjbiped.engines.mujoco.simulation` calls them with lists from Python callbacks,
`mjbiped.engines.mujoco.compiled.callbacks` compiles them into C callbacks that work on MuJoCo's own arrays. They
allocate nothing and know neither MuJoCo's objects nor a controller's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any, NamedTuple

import numpy as np

from mjbiped.disturbances.pushes import Pushes, following
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco import leapfrog, step_size
from mjbiped.engines.mujoco.contact_events import State
from mjbiped.engines.mujoco.contact_forces import felt
from mjbiped.records.rows import SAMPLED, TOUCHED, write_sample
from mjbiped.rules.scuffing import swing_foot_is_drawn_in
from mjbiped.rules.termination import Limits
from mjbiped.terrain.profile import Floats, Profile, height_of, height_over_ground, segment_met, segment_stood_on

SUNK = 5e-4  # no standing foot lies deeper in the ground, m
NOTHING_LEFT = 1e-12  # of a push's impulse: rounding
NOW = 1e-9  # times so close are the same, s


class Recording(NamedTuple):
    """Where a walk is written down; `userdata` counts what waits there, and whoever takes it sets the counts to zero.

    Where it is full, nothing more is written.

    Attributes:
        sample_period: Time between two samples, s; each is taken at the first physics step from then on.
        samples: Shape (room, columns of `columns.SAMPLES` and the controller's states).
        rows: Of touchdowns, shape (room, columns of `columns.TOUCHDOWNS`).
    """

    sample_period: float
    samples: Any
    rows: Any


class Places(NamedTuple):
    """Where things are in a scene.

    Attributes:
        profile: The ground, as far as it was built.
        rises: Steps up at the starts of its segments, m.
        feet: Geoms of the left and the right foot.
        contacts: Indices in the sensor data where the left and the right foot's contacts begin.
        slots: Floats of one foot's contacts.
        risers: For each geom the segment at whose start it is the riser; -1 for the others.
        first: For each geom the first of the segments that it is the ground of; all are where it is none.
        last: The last of them.
    """

    profile: Profile
    rises: Floats
    feet: tuple[int, int]
    contacts: tuple[int, int]
    slots: int
    risers: Floats
    first: Floats
    last: Floats


def in_arrays(places: Places) -> Places:
    """The same as compiled code reads it; plain Python reads tuples faster."""
    return places._replace(
        profile=Profile(*(np.array(values, dtype=np.float64) for values in places.profile)),
        rises=np.array(places.rises),
        risers=np.array(places.risers),
        first=np.array(places.first),
        last=np.array(places.last),
    )


class SimulationConstants(NamedTuple):
    """What does not change in a walk, beside the controller's parameters.

    Attributes:
        limits: What the walk is judged by.
        places: In the scene.
        stepped: Whether there are steps in the ground.
        deepest: No foot is deeper in the ground than this in the first step of a contact, m.
        timestep: Longest physics step, s.
        contact_timestep: Of the step that makes an impact, s.
        lands: Whether steps end at touchdowns; else they all are of one length.
        control_period: Time between two ticks of the controller, s; 0: it ticks at every physics step.
        memory_size: Floats of the controller's memory.
        states: Number of its integrated states.
        sampled: Whether its law has a tick.
        pushes: At the hip.
    """

    limits: Limits
    places: Places
    stepped: bool
    deepest: float
    timestep: float
    contact_timestep: float
    lands: bool
    control_period: float
    memory_size: int
    states: int
    sampled: bool
    pushes: Pushes


class Laws(NamedTuple):
    """A controller's functions; see `controllers.Law` and `mjbiped.control.adapters`."""

    torque: Callable[..., Sequence[float]]
    touchdown: Callable[..., None]
    slope_estimate: Callable[..., float]
    tick: Callable[..., None]


class Setting(NamedTuple):
    """All that a walk's callbacks work with and do not change, but for what they write into the recording.

    Attributes:
        laws: The controller's.
        parameters: Theirs.
        constants: The walk's.
        recording: To be written.
    """

    laws: Laws
    parameters: Any
    constants: SimulationConstants
    recording: Recording


class Userdata(NamedTuple):
    """The parts of `mjData.userdata`.

    Attributes:
        events: Up to the controller's memory; see `mjbiped.engines.mujoco.contact_events`.
        memory: The controller's memory.
        rates: Held, of its integrated states.
    """

    events: MutableSequence[float]
    memory: MutableSequence[float]
    rates: MutableSequence[float]


def control(
    setting: Setting,
    userdata: Userdata,
    ctrl: MutableSequence[float],
    applied: MutableSequence[float],
    time: float,
    state: State,
) -> bool:
    """`mjcb_control`: one tick per new time; a second call at the same time changes nothing.

    Args:
        setting: The walk's.
        userdata: To be changed.
        ctrl: To be filled: left ankle, right ankle, hip, N m.
        applied: Forces at the degrees of freedom: that at hip x is a push's, N.
        time: Now, s.
        state: Now.

    Returns:
        Whether anything was changed.
    """
    constants, recording = setting.constants, setting.recording
    u, memory, rates = userdata
    if not (u[events.RUNNING] and time > u[events.TIME]):
        return False
    over = u[events.OUTCOME] != 0.0
    if u[events.TIME] >= 0.0:
        for index in range(constants.states):
            memory[index] += (time - u[events.TIME]) * rates[index]
    u[events.PLANNED], u[events.PLAIN] = u[events.PLANNED_NEXT], u[events.PLAIN_NEXT]
    if u[events.TRANSFERRED] and u[events.NOTED]:
        _write_row(recording, u)  # of a touchdown that the controller is never told of
    u[events.LAST_STEP] = leapfrog.step_before(u, time)
    turns = not u[events.NOTED]  # the contact step counts for no work: its halves belong to two steps' roles
    legs, torque = (u[events.LEFT], u[events.RIGHT]), (u[events.ANKLE], u[events.HIP])
    take_in(constants, u, time, state)
    if u[events.PUSHING] or time > u[events.NEXT_PUSH] - NOW:
        push(constants.pushes, u, time)
        applied[0] = u[events.PUSH]
    due = time > u[events.NEXT_CONTROL] - NOW
    if due:
        u[events.NEXT_CONTROL] += constants.control_period
    if due or (u[events.TRANSFERRED] and u[events.OUTCOME]):  # the last touchdown is told at once: its row is whole
        _tick(setting, userdata, time)
    if turns:
        events.count_work(u, legs, torque, constants.sampled)
    right = bool(u[events.STANCE])
    ctrl[0] = 0.0 if right else u[events.ANKLE]
    ctrl[1] = u[events.ANKLE] if right else 0.0
    ctrl[2] = -u[events.HIP] if right else u[events.HIP]
    if not over and (time > u[events.NEXT_SAMPLE] - NOW or u[events.OUTCOME]):
        u[events.NEXT_SAMPLE] = (math.floor(time / recording.sample_period + NOW) + 1.0) * recording.sample_period
        take_sample(setting, userdata, time, state.qpos)
    return True


def push(pushes: Pushes, u: MutableSequence[float], time: float) -> None:
    """The force of a push in the step from now on: constant, until its impulse has been given to the last bit.

    A force of a time acts from the middle of the step before to the middle of the step after (`leapfrog`): so the first
    one from the push's time on is the smaller, the later the push begins before it. The last one is what is left; where
    its step becomes another than planned, one more makes up for it.
    """
    if u[events.PUSHING]:
        u[events.PUSH_LEFT] -= u[events.PUSH] * u[events.EFFECTIVE_STEP]
        if abs(u[events.PUSH_LEFT]) <= NOTHING_LEFT * abs(u[events.PUSH_IMPULSE]):
            u[events.PUSHING] = u[events.PUSH] = 0.0
            u[events.PUSHES] += 1.0
            over = u[events.NEXT_PUSH] + pushes.duration
            u[events.NEXT_PUSH], u[events.PUSH_IMPULSE] = following(pushes, int(u[events.PUSHES]), over)
    if not u[events.PUSHING] and time > u[events.NEXT_PUSH] - NOW:
        u[events.PUSHING] = 1.0
        u[events.PUSH_LEFT] = u[events.PUSH_IMPULSE]
        begun = time - u[events.NEXT_PUSH]
    else:
        begun = math.inf
    if u[events.PUSHING]:
        force = u[events.PUSH_IMPULSE] / pushes.duration
        step = leapfrog.effective_step(u[events.PLAIN], u[events.LAST_STEP], u[events.PLANNED])
        if begun < step:
            force *= 0.5 + begun / step
        enough = abs(u[events.PUSH_LEFT]) <= abs(force) * step
        u[events.PUSH] = u[events.PUSH_LEFT] / step if enough else force


def take_in(constants: SimulationConstants, u: MutableSequence[float], time: float, state: State) -> None:
    """Take in the state at a new time: what `control` does before the controller ticks.

    On a copy of the userdata it says what the controller will be told when it ticks, and whether the walk is over.

    Args:
        constants: The walk's.
        u: Userdata, up to the controller's memory.
        time: Now, s; later than the last observation.
        state: Now.
    """
    u[events.LEFT_LAG], u[events.RIGHT_LAG] = u[events.LEFT_LAG_NEXT], u[events.RIGHT_LAG_NEXT]
    events.observe(u, constants.limits, constants.places.profile, time, leapfrog.rates_now(u, state))


def posture(u: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Stance and swing leg from the ground's normal, and their rates, as last observed."""
    slope = u[events.SLOPE]
    stance, swing = events.by_role(u, u[events.LEFT], u[events.RIGHT])
    stance_rate, swing_rate = events.by_role(u, u[events.LEFT_RATE], u[events.RIGHT_RATE])
    return (stance - slope, swing - slope), (stance_rate, swing_rate)


def _tick(setting: Setting, userdata: Userdata, time: float) -> None:
    """One tick of the digital controller: its events and its law, whose torques and rates are held from now on."""
    laws, parameters, _, recording = setting
    u, memory, rates = userdata
    q, dq = posture(u)
    if u[events.TRANSFERRED]:
        u[events.TRANSFERRED] = 0.0
        u[events.ESTIMATE_BEFORE] = laws.slope_estimate(parameters, memory)
        # the contact switch holds the touchdown's posture and time for a controller that ticks later
        laws.touchdown(
            parameters,
            memory,
            (u[events.TOLD_Q_BEFORE], u[events.TOLD_Q_BEFORE + 1]),
            (u[events.TOLD_Q], u[events.TOLD_Q + 1]),
            (u[events.TOLD_DQ], u[events.TOLD_DQ + 1]),
        )
        u[events.ESTIMATE_AFTER] = laws.slope_estimate(parameters, memory)
        _write_row(recording, u)
    t = time - u[events.TRANSFER_TIME]
    if setting.constants.sampled:
        laws.tick(parameters, memory, t, q, dq)
    values = laws.torque(parameters, memory, t, q, dq)
    for index in range(setting.constants.states):
        rates[index] = values[2 + index]
    ankle, hip = values[0], values[1]
    u[events.ANKLE], u[events.HIP] = ankle, hip
    if not u[events.OUTCOME]:
        if abs(ankle) > u[events.PEAK_ANKLE]:
            u[events.PEAK_ANKLE] = abs(ankle)
        if abs(hip) > u[events.PEAK_HIP]:
            u[events.PEAK_HIP] = abs(hip)


def _write_row(recording: Recording, u: MutableSequence[float]) -> None:
    """Write down the last touchdown."""
    row = int(u[events.ROWS])
    if 0 <= row < len(recording.rows):
        for index in range(TOUCHED):
            recording.rows[row, index] = u[events.LAST_TOUCHDOWN + index]
        u[events.ROWS] += 1.0


def take_sample(setting: Setting, userdata: Userdata, time: float, qpos: Sequence[float]) -> None:
    """Write down the state now, with the torque that is held from now on."""
    laws, parameters, constants, recording = setting
    u, memory, _ = userdata
    row = int(u[events.SAMPLES])
    if not 0 <= row < len(recording.samples):
        return
    q, dq = posture(u)
    estimate = laws.slope_estimate(parameters, memory)
    write_sample(
        recording.samples[row],
        0,
        time=time,
        q=q,
        dq=dq,
        torque=(u[events.ANKLE], u[events.HIP]),
        slope=u[events.SLOPE],
        slope_estimate=estimate,
        stance=u[events.STANCE],
        qpos=(qpos[0], qpos[1], qpos[2], qpos[3]),
    )
    for index in range(constants.states):
        recording.samples[row, SAMPLED + index] = memory[index]
    u[events.SAMPLES] += 1.0


def sense(
    constants: SimulationConstants,
    u: MutableSequence[float],
    readings: Sequence[float],
    time: float,
    state: State,
    qacc: Sequence[float],
) -> tuple[float, float]:
    """`mjcb_sensor` at the acceleration stage, after MuJoCo has filled its own contact sensors.

    Args:
        constants: The walk's.
        u: Userdata.
        readings: Sensor data.
        time: Now, s.
        state: Now.
        qacc: The accelerations of the hip and of both legs.

    Returns:
        Length of the physics step from now on, s, 0 where it is not for this walk to say; and by what factor its
        accelerations count.
    """
    if not u[events.RUNNING]:
        return 0.0, 1.0
    stance = 1 if u[events.STANCE] else 0
    own, other, slots = constants.places.contacts[stance], constants.places.contacts[1 - stance], constants.places.slots
    events.read_contacts(u, constants.limits, felt(readings, own, slots), felt(readings, other, slots))
    if not constants.lands:
        u[events.EFFECTIVE_STEP] = constants.timestep
        return 0.0, 1.0
    length = step_size.step_length(u, constants, time, state, qacc)
    return length, u[events.EFFECTIVE_STEP] / length


def softness(constants: SimulationConstants, u: Sequence[float], time: float) -> tuple[float, float]:
    """`mjcb_contactfilter`, first: the feet's `solref` in this step; zeros: as the model has it.

    Args:
        constants: The walk's.
        u: Userdata.
        time: Now, s.
    """
    return step_size.softness(u, time) if u[events.RUNNING] and constants.lands else (0.0, 0.0)


def refuses(constants: SimulationConstants, u: Sequence[float], centres: Any, first: int, second: int) -> bool:
    """`mjcb_contactfilter`: whether a pair of geoms does not collide.

    The swing foot passes through everything until its contact is enabled (scuffing rule). From then on it is a point:
    it meets the piece of the ground that it is over, and a riser if it is beside that (`profile.segment_met`). It
    cannot meet a piece's corner.

    The stance foot, which stands still, meets all ground but what stands beside it: not the risers, nor a higher piece.
    And it passes through the ground from the step on that resolves the other foot's touchdown, as it does after the
    support transfer: a solver with a convex friction cone would drag a foot that leaves the ground obliquely.

    Args:
        constants: The walk's.
        u: Userdata.
        centres: Of all geoms, an array of shape (geoms, 3), m.
        first: One geom.
        second: The other.
    """
    if not u[events.RUNNING]:
        return False
    right = 1 if u[events.STANCE] else 0
    places = constants.places
    stance, swing = places.feet[right], places.feet[1 - right]
    ahead = centres[swing, 0] - centres[stance, 0]
    contact_enabled = bool(u[events.CONTACT_ENABLED]) and not swing_foot_is_drawn_in(constants.limits.reach, ahead)
    if swing in (first, second):
        other = second if first == swing else first
        return not contact_enabled or not meets(places, centres[swing, 0], centres[swing, 2], other)
    if stance not in (first, second):
        return False
    if (
        contact_enabled
        and -constants.deepest < height_over_ground(places.profile, centres[swing, 0], centres[swing, 2]) < 0.0
    ):
        return True
    return beside(places, centres[stance, 0], centres[stance, 2], second if first == stance else first)


def meets(places: Places, x: float, z: float, geom: int) -> bool:
    """Whether a foot at x, z can meet a geom of the ground."""
    segment = segment_met(places.profile, x, z)
    riser = int(places.risers[geom])
    if riser >= 0:
        return (segment < riser) == (places.rises[riser] > 0.0)
    return bool(places.first[geom] <= segment <= places.last[geom])


def beside(places: Places, x: float, z: float, geom: int) -> bool:
    """Whether a standing foot at x, z, which may have sunk a little, has a geom of the ground beside it."""
    if places.risers[geom] >= 0.0:
        return True
    segment = segment_stood_on(places.profile, x, z, SUNK)
    if places.first[geom] <= segment <= places.last[geom]:
        return False
    nearest = int(places.first[geom]) if segment < places.first[geom] else int(places.last[geom])
    return height_of(places.profile, nearest, x) > z + SUNK
