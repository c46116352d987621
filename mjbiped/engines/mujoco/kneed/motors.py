"""The controller's ticks for a biped with knees in MuJoCo: torques that are held, their work, and the samples."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import NOW
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.servo import torque
from mjbiped.engines.mujoco.kneed.state import (
    JOINTS,
    KNEES,
    THIGHS,
    Buffers,
    Constants,
    Parts,
    angles_of,
    rates_of,
    stance_of,
)
from mjbiped.records.rows import KNEED_SAMPLED, write_kneed_sample
from mjbiped.rules.termination import Outcome

DIVERGED = float(Outcome.DIVERGED)


def tick(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """The controller's tick, where it is due; its torques are held until the next one. And the work of the step before.

    A leapfrog step's work is that of the mean of the torques at its ends, or of the torque that motors hold; see
    `contact_events.count_work`.
    """
    u, motors, ctrl = buffers.u, constants.motors, buffers.scene.ctrl
    stance = stance_of(u)
    ankle_before, hip_before, knee_before = u[events.ANKLE], u[events.HIP], u[at.KNEE]
    hold_before = u[at.HOLD]
    if u[events.TIME] > u[events.NEXT_CONTROL] - NOW:
        u[events.NEXT_CONTROL] += constants.control_period
        _ask(parts, parameters, constants, buffers)
    if u[at.LOCKED] != 0.0:
        u[at.KNEE] = 0.0  # the motor of a locked knee does nothing
    ankle, hip, knee = u[events.ANKLE], u[events.HIP], u[at.KNEE]
    for index in range(len(ctrl)):
        ctrl[index] = 0.0
    ctrl[motors.ankles[stance]] = ankle
    ctrl[motors.hip] = hip if stance == 0 else -hip
    ctrl[motors.knees[1 - stance]] = knee
    if constants.servo.stiffness > 0.0:
        _hold(constants, buffers, ankle)
    if u[at.TURNS] != 0.0:
        old1, old2, old3 = angles_of(u, at.OLD_Q, stance, 0.0)
        new1, new2, new3 = angles_of(u, at.Q, stance, 0.0)
        turned1, turned2, turned3 = new1 - old1, new2 - old2, new3 - old3
        thigh = turned1
        if constants.servo.stiffness > 0.0:  # ankle and hip turn against shank and thigh
            thigh, bent = _turned(u, THIGHS[stance]), _turned(u, KNEES[stance])
            turned1 = thigh + bent
            _count_hold(u, -0.5 * (hold_before + u[at.HOLD]) * bent)
        if not constants.sampled:
            ankle_before = 0.5 * (ankle_before + ankle)
            hip_before, knee_before = 0.5 * (hip_before + hip), 0.5 * (knee_before + knee)
        _count_work(u, ankle_before * turned1, hip_before * (turned2 - thigh), knee_before * (turned3 - turned2))


def _hold(constants: Constants, buffers: Buffers, ankle: float) -> None:
    """The servo's torque at the stance knee, through which the ankle's goes as well, as it acts on the shank."""
    u = buffers.u
    u[at.HOLD] = hold = torque(constants, u)
    buffers.scene.ctrl[constants.motors.knees[stance_of(u)]] = ankle - hold
    u[at.PEAK_HOLD] = max(u[at.PEAK_HOLD], abs(hold))


def _turned(u: Any, index: int) -> float:
    """How far a joint has turned since the observation before, rad."""
    return float(u[at.Q + index] - u[at.OLD_Q + index])


def _count_hold(u: Any, work: float) -> None:
    """Work of the servo in the step before, J: one of the joints', and told apart."""
    u[at.WORK_HOLD] += abs(work)
    u[events.WORK_ABSOLUTE] += abs(work)
    u[events.WORK_NET] += work
    u[events.WORK_POSITIVE] += max(work, 0.0)


def _ask(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """Ask the controller's law."""
    u = buffers.u
    stance = stance_of(u)
    q, dq = angles_of(u, at.Q, stance, u[events.SLOPE]), rates_of(u, at.RATES, stance)
    t = u[events.TIME] - u[events.TRANSFER_TIME]
    if constants.sampled:
        parts.tick(parameters, buffers.memory, t, q, dq)
    values = parts.torque(parameters, buffers.memory, t, q, dq)
    for index in range(constants.states):
        buffers.rates[index] = values[JOINTS + index]
    ankle, hip, knee = float(values[0]), float(values[1]), float(values[2])
    if u[at.LOCKED] != 0.0:
        knee = 0.0
    u[events.ANKLE], u[events.HIP], u[at.KNEE] = ankle, hip, knee
    if not (math.isfinite(ankle) and math.isfinite(hip) and math.isfinite(knee)):
        u[events.OUTCOME] = DIVERGED  # MuJoCo would take it for 0
    elif u[events.OUTCOME] == 0.0:
        if abs(ankle) > u[events.PEAK_ANKLE]:
            u[events.PEAK_ANKLE] = abs(ankle)
        if abs(hip) > u[events.PEAK_HIP]:
            u[events.PEAK_HIP] = abs(hip)
        if abs(knee) > u[at.PEAK_KNEE]:
            u[at.PEAK_KNEE] = abs(knee)


def _count_work(u: Any, ankle: float, hip: float, knee: float) -> None:
    """Work of the joints in the step before, J."""
    u[events.WORK_ABSOLUTE] += abs(ankle) + abs(hip) + abs(knee)
    u[events.WORK_NET] += ankle + hip + knee
    u[events.WORK_POSITIVE] += max(ankle, 0.0) + max(hip, 0.0) + max(knee, 0.0)


def take_sample(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """Write the state down, where it is time to, with the torque that is held from now on."""
    u, period = buffers.u, constants.sample_period
    time = u[events.TIME]
    if not (time > u[events.NEXT_SAMPLE] - NOW or u[events.OUTCOME] != 0.0):
        return
    u[events.NEXT_SAMPLE] = (math.floor(time / period + NOW) + 1.0) * period
    stance, row = stance_of(u), buffers.samples[int(u[events.SAMPLES])]
    hold = u[at.HOLD] if constants.servo.stiffness > 0.0 else math.nan
    write_kneed_sample(
        row,
        0,
        time=time,
        q=angles_of(u, at.Q, stance, u[events.SLOPE]),
        dq=rates_of(u, at.RATES, stance),
        torque=(u[events.ANKLE], u[events.HIP], u[at.KNEE]),
        slope=u[events.SLOPE],
        slope_estimate=parts.slope_estimate(parameters, buffers.memory),
        stance=float(stance),
        qpos=(u[at.Q], u[at.Q + 1], u[at.Q + 2], u[at.Q + 4], u[at.Q + 3], u[at.Q + 5]),
        locked=u[at.LOCKED],
        stance_knee_torque=hold,
    )
    for index in range(constants.states):
        row[KNEED_SAMPLED + index] = buffers.memory[index]
    u[events.SAMPLES] += 1.0
