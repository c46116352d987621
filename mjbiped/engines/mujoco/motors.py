"""The controller's ticks: torques that motors hold, their work, pushes, and the rows and samples of the record."""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any, NamedTuple

from mjbiped.disturbances.pushes import Pushes, following
from mjbiped.engines.mujoco import leapfrog, servo
from mjbiped.engines.mujoco.feet import swing_foot_torque
from mjbiped.engines.mujoco.observation import observe, see_places
from mjbiped.engines.mujoco.state import Constants, Userdata, angles_of, stance_of, swing_of
from mjbiped.rules.sole import bounded

NOTHING_LEFT = 1e-12  # of a push's impulse: rounding
NOW = 1e-9  # times so close are the same, s


class Recording(NamedTuple):
    """Where a walk is written down; `State` counts what waits there, and whoever takes it sets the counts to zero.

    Where it is full, nothing more is written.

    Attributes:
        sample_period: Time between two samples, s; each is taken at the first physics step from then on.
        samples: Shape (room, columns of a sample and the controller's states).
        rows: Of touchdowns, shape (room, columns).
    """

    sample_period: float
    samples: Any
    rows: Any


class Parts(NamedTuple):
    """A controller's functions, as in `controllers.Law` and `mjbiped.control.adapters`, and what writes the record.

    Attributes:
        torque: See there.
        touchdown: See there.
        slope_estimate: See there.
        tick: See there.
        knee_strike: See there.
        told: (array, zeros) -> tuple of the array's first numbers, as long as `zeros`.
        write_sample: See `mjbiped.records.rows.Rows`.
        write_touchdown: See there.
    """

    torque: Callable[..., Sequence[float]]
    touchdown: Callable[..., None]
    slope_estimate: Callable[..., float]
    tick: Callable[..., None]
    knee_strike: Callable[..., None]
    told: Callable[..., tuple[float, ...]]
    write_sample: Callable[..., None]
    write_touchdown: Callable[..., None]


def told(numbers: Any, zeros: tuple[float, ...]) -> tuple[float, ...]:
    """The first numbers of an array as a tuple, as long as `zeros`."""
    return tuple(numbers[: len(zeros)])


class Setting(NamedTuple):
    """All that a walk's callbacks work with and do not change, but for what they write into the recording.

    Attributes:
        parts: The controller's functions, and the record's.
        parameters: The controller's.
        constants: The walk's.
        recording: To be written.
    """

    parts: Parts
    parameters: Any
    constants: Constants
    recording: Recording


def arrive(
    setting: Setting, userdata: Userdata, time: float, qpos: Sequence[float], qvel: MutableSequence[float]
) -> None:
    """Put MuJoCo's rates back, and observe the state where the time is new: each callback begins with this.

    Args:
        setting: The walk's.
        userdata: To be changed.
        time: Now, s.
        qpos: The robot's coordinates now.
        qvel: Their rates in MuJoCo. Rates that `leapfrog.show` has put there are replaced by the state's own.
    """
    u, row, memory, rates = userdata
    if not u.running:
        return
    leapfrog.put_back(u, qvel)
    if not time > u.time:
        return
    constants = setting.constants
    if u.time >= 0.0:
        for index in range(constants.states):
            memory[index] += (time - u.time) * rates[index]
    if u.transferred and u.noted:
        _write_row(setting, u, row)  # of a touchdown that the controller is never told of
    observe(setting.parts, constants, u, row, time, qpos, qvel)


def control(
    setting: Setting, userdata: Userdata, ctrl: MutableSequence[float], applied: MutableSequence[float], time: float
) -> None:
    """`mjcb_control`, after `arrive`: one tick per new time; a second call at the same time changes nothing.

    Args:
        setting: The walk's.
        userdata: To be changed.
        ctrl: To be filled: torques of the actuators, N m.
        applied: Forces at the degrees of freedom: that at hip x is a push's, N.
        time: Now, s.
    """
    constants, recording, u = setting.constants, setting.recording, userdata.u
    if not (u.running and time > u.asked):
        return
    u.asked = time
    before, hold, foot = (u.torque[0], u.torque[1], u.torque[2]), u.hold, u.foot_torque
    if u.pushing or time > u.next_push - NOW:
        push(constants.pushes, u)
        applied[0] = u.push
    due = time > u.next_control - NOW
    if due:
        u.next_control += constants.control_period
    if u.torque[0] != u.ankle:
        u.bound_time += u.effective_step
    if due or (u.transferred and u.outcome):  # the last touchdown is told at once: its row is whole
        _tick(setting, userdata)
    # the force of the step before; that of an impact tells nothing of the step to come
    u.torque[0] = bounded(u.ankle, u.force if u.turns else 0.0, constants.behind, constants.ahead)
    if not u.outcome:
        _note_peaks(u, len(constants.joints))
    drive(constants, u, ctrl)
    if u.turns:
        count_work(constants, u, before, hold)
        if constants.feet:
            count_foot_work(constants, u, foot)
    if not u.over and (time > u.next_sample - NOW or u.outcome):
        u.next_sample = (math.floor(time / recording.sample_period + NOW) + 1.0) * recording.sample_period
        take_sample(setting, userdata)
    u.over = 1.0 if u.outcome else 0.0


def push(pushes: Pushes, u: Any) -> None:
    """The force of a push in the step from now on: constant, until its impulse has been given to the last bit.

    A force of a time acts from the middle of the step before to the middle of the step after (`leapfrog`): so the first
    one from the push's time on is the smaller, the later the push begins before it. The last one is what is left; where
    its step becomes another than planned, one more makes up for it.
    """
    if u.pushing:
        u.push_left -= u.push * u.effective_step
        if abs(u.push_left) <= NOTHING_LEFT * abs(u.push_impulse):
            u.pushing = u.push = 0.0
            u.pushes += 1.0
            u.next_push, u.push_impulse = following(pushes, int(u.pushes), u.next_push + pushes.duration)
    begun = math.inf
    if not u.pushing and u.time > u.next_push - NOW:
        u.pushing, u.push_left = 1.0, u.push_impulse
        begun = u.time - u.next_push
    if u.pushing:
        force = u.push_impulse / pushes.duration
        step = leapfrog.effective_step(u.plain, u.last_step, u.planned)
        if begun < step:
            force *= 0.5 + begun / step
        enough = abs(u.push_left) <= abs(force) * step
        u.push = u.push_left / step if enough else force


def _tick(setting: Setting, userdata: Userdata) -> None:
    """One tick of the digital controller: its events and its law, whose torques and rates are held from now on."""
    parts, parameters, constants, _ = setting
    u, row, memory, rates = userdata
    zeros = constants.joints
    if u.strike_untold:
        u.strike_untold = 0.0
        q, dq = parts.told(u.struck_q, zeros), parts.told(u.struck_rates, zeros)
        parts.knee_strike(parameters, memory, u.strike_time, q, dq)
    if u.transferred:
        u.transferred = 0.0
        before, after = constants.estimates
        row[before] = parts.slope_estimate(parameters, memory)
        # the contact switch holds the touchdown's posture and time for a controller that ticks later
        q_before, q, dq = (
            parts.told(u.told_before, zeros),
            parts.told(u.told_q, zeros),
            parts.told(u.told_dq, zeros),
        )
        if constants.support >= 0:
            memory[constants.support], memory[constants.support + 1] = u.support_behind, u.support_ahead
        parts.touchdown(parameters, memory, q_before, q, dq)
        row[after] = parts.slope_estimate(parameters, memory)
        _write_row(setting, u, row)
    q, dq, t = parts.told(u.angles, zeros), parts.told(u.turning, zeros), u.time - u.transfer_time
    if constants.sampled:
        parts.tick(parameters, memory, t, q, dq)
    values = parts.torque(parameters, memory, t, q, dq)
    for index in range(constants.states):
        rates[index] = values[len(zeros) + index]
    for joint in range(len(zeros)):
        u.torque[joint] = values[joint]
    if u.locked:
        u.torque[2] = 0.0
    u.ankle = u.torque[0]


def _note_peaks(u: Any, joints: int) -> None:
    """Keep the greatest magnitudes of the torques held from now on."""
    for joint in range(joints):
        if abs(u.torque[joint]) > u.peak[joint]:
            u.peak[joint] = abs(u.torque[joint])


def drive(constants: Constants, u: Any, ctrl: MutableSequence[float]) -> None:
    """Set the motors: of the stance leg's ankle, of the hip, and of the swing knee, which does nothing while locked."""
    places = constants.places
    stance, swing = places.legs[stance_of(u)], places.legs[swing_of(u, places.legs)]
    if u.locked:
        u.torque[2] = 0.0
    for index in range(places.actuators):
        ctrl[index] = 0.0
    ctrl[stance.ankle] = u.torque[0]
    if constants.feet:
        u.foot_torque = swing_foot_torque(constants, u)
        ctrl[swing.ankle] = u.foot_torque
    if places.hip >= 0:
        ctrl[places.hip] = -u.torque[1] if u.stance else u.torque[1]
    if swing.knee >= 0:
        ctrl[swing.motor] = u.torque[2]
    if constants.servo.stiffness > 0.0:
        # the ankle's torque goes through the knee as well, as it acts on the shank
        u.hold = servo.torque(constants.servo, stance, u)
        ctrl[stance.motor] = u.torque[0] - u.hold
        u.peak_hold = max(u.peak_hold, abs(u.hold))


def count_work(constants: Constants, u: Any, before: tuple[float, float, float], hold: float) -> None:
    """Work of the motors in the step that has led here: the mean of the torques at its ends times what was turned.

    In a leapfrog step's motion that is the work done: the torque of a time acts from the middle of the step before
    to the middle of the step after. The paper's power is τ1 q̇1 + τ2 (q̇2 - q̇1); the ground's slope does not change.

    Motors of a sampled controller hold their torque until the next tick, however much it changes there: that of a noisy
    one would lose half of its work in the mean.

    Args:
        constants: The walk's.
        u: State, after the controller's tick.
        before: Torques that were held before it, N m.
        hold: Of the servo before it, N m.
    """
    legs, stance, count = constants.places.legs, stance_of(u), int(u.count)
    old1, old2, old3 = angles_of(legs, u.old_q, count, u.old_tilt, 0.0)
    new1, new2, new3 = angles_of(legs, u.q, count, u.tilt, 0.0)
    leg, swing, shank = new1 - old1, new2 - old2, new3 - old3
    thigh = leg
    if constants.feet:
        leg -= u.slope - u.old_slope  # against the foot, which may tip
    if constants.servo.stiffness > 0.0:  # ankle and hip turn against shank and thigh
        hip, knee = legs[stance].hip, legs[stance].knee
        thigh, flexed = u.q[hip] - u.old_q[hip], u.q[knee] - u.old_q[knee]
        leg = thigh + flexed
        work = -0.5 * (hold + u.hold) * flexed
        u.work_hold += abs(work)
        _add_work(u, work, 0.0, 0.0)
    ankle, hip_torque, knee_torque = before
    if not constants.sampled:
        ankle, hip_torque = 0.5 * (ankle + u.torque[0]), 0.5 * (hip_torque + u.torque[1])
        knee_torque = 0.5 * (knee_torque + u.torque[2])
    _add_work(u, ankle * leg, hip_torque * (swing - thigh), knee_torque * (shank - swing))


def count_foot_work(constants: Constants, u: Any, before: float) -> None:
    """Work of the swing foot's servo in the step that has led here; see `count_work`.

    Args:
        constants: The walk's.
        u: State, after the controller's tick.
        before: Torque that it held, N m.
    """
    legs = constants.places.legs
    ankle = legs[swing_of(u, legs)].sole
    _add_work(u, -0.5 * (before + u.foot_torque) * (u.q[ankle] - u.old_q[ankle]), 0.0, 0.0)


def _add_work(u: Any, ankle: float, hip: float, knee: float) -> None:
    u.work_absolute += abs(ankle) + abs(hip) + abs(knee)
    u.work_net += ankle + hip + knee
    u.work_positive += max(ankle, 0.0) + max(hip, 0.0) + max(knee, 0.0)


def _write_row(setting: Setting, u: Any, row: Sequence[float]) -> None:
    """Write down the last touchdown."""
    rows, index = setting.recording.rows, int(u.rows)
    if 0 <= index < len(rows):
        for column in range(setting.constants.touched):
            rows[index, column] = row[column]
        u.rows += 1.0


def take_sample(setting: Setting, userdata: Userdata) -> None:
    """Write down the state now, with the torque that is held from now on."""
    parts, parameters, constants, recording = setting
    u, memory = userdata.u, userdata.memory
    index = int(u.samples)
    if not 0 <= index < len(recording.samples):
        return
    sample = recording.samples[index]
    hold = u.hold if constants.servo.stiffness > 0.0 else math.nan
    see_places(constants, u)
    parts.write_sample(
        sample,
        0,
        time=u.time,
        q=u.angles,
        dq=u.turning,
        torque=u.torque,
        ankle_asked=u.ankle,
        slope=u.slope,
        slope_estimate=parts.slope_estimate(parameters, memory),
        stance=u.stance,
        qpos=u.posture,
        locked=u.locked,
        stance_knee_torque=hold,
    )
    for column in range(constants.states):
        sample[constants.sampled_columns + column] = memory[column]
    u.samples += 1.0
