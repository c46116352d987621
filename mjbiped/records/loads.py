"""What feet and the stance knee bear: centre of pressure, the shortest foot that would contain it, the knee's torque.

The feet of the models are points, which cannot transmit a torque. A flat, massless foot at the ankle stands still only
while the ground's force, with the normal component F_n, acts at x = -τ₁ / F_n, measured from the ankle along the
ground, positive forward: this is the balance of moments about the ankle. Where x lies beyond the end of the foot, the
foot tips.

Engines keep the greatest distances of each step in the rows of touchdowns, and a histogram of the time spent at each
x: `BINS` bins of `WIDTH` leg lengths, half of them behind the ankle. The first and the last bin include all that lies
farther away, and torques without a normal force. Time without a torque is in no bin.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.robots.kneed import stance_knee_torque
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.sole import moment_about_ankle
from mjbiped.rules.termination import LIGHT_CONTACT
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

WIDTH = 0.01  # leg lengths
BINS = 130
HALF = BINS // 2
USUAL = 0.99
"""Default share of the time for which a foot must contain the centre of pressure."""

BENT = 1e-4  # rad: a knee that bends less rests against its stop


def bin_of(place: float) -> int:
    """Index of the bin of a centre of pressure, given in leg lengths from the ankle; the last one for NaN."""
    scaled = place / WIDTH
    return math.floor(max(scaled, -float(HALF))) + HALF if scaled < HALF - 1.0 else BINS - 1


def note_pressure(
    noted: MutableSequence[float], torque: float, normal: float, light: float, leg_length: float, time: float
) -> None:
    """Add an interval of time to the record of the centre of pressure.

    Args:
        noted: Greatest distances ahead of the ankle and behind it, m, then the `BINS` times, s.
        torque: Torque of the ankle, N m.
        normal: Normal force of the ground, N.
        light: Normal force, N, up to which the centre of pressure counts as infinitely far away.
        leg_length: Length of a leg, m.
        time: Length of the interval, s.
    """
    if normal > light:
        place = -torque / normal
        noted[0], noted[1] = max(noted[0], place), max(noted[1], -place)
    else:
        place = -math.copysign(math.inf, torque)
    if torque != 0.0:
        noted[2 + bin_of(place / leg_length)] += time


def unknown() -> Array:
    """Return the times of a record that does not hold them: NaN."""
    return np.full(BINS, np.nan)


def pressure_place(robot: Robot, torque: float, force: tuple[float, float], slope: float) -> float:
    """Centre of pressure that a torque of the ankle requires, m ahead of the point below the ankle.

    Args:
        robot: The robot; its ankle may be higher than the sole.
        torque: Of the ankle, N m.
        force: Of the ground, forward and upward, N.
        slope: Of the ground, rad.

    Returns:
        NaN where the ground does not press.
    """
    forward, upward = force
    normal = forward * math.sin(slope) + upward * math.cos(slope)
    if not normal > LIGHT_CONTACT * robot.weight:
        return math.nan
    foot = robot.bodies.foot
    along = forward * math.cos(slope) - upward * math.sin(slope)
    return -moment_about_ankle(torque, 0.0 if foot is None else foot.height, along) / normal


def flexion(walk: Walk) -> Array:
    """Flexion of the stance knee at each sample, shape (samples,), rad; zero for straight legs."""
    return walk.robot.flexion(walk.samples["qpos"], walk.samples["stance"])


def is_sound(walk: Walk) -> NDArray[np.bool_]:
    """Whether each sample is a state that the equations of motion accept; the last one of a diverged walk is not."""
    angles, dq = np.column_stack([walk.samples["q"], walk.samples["slope"]]), walk.samples["dq"]
    sound = (np.abs(angles) <= domains.ANGLE.high).all(axis=1) & (np.abs(dq) <= domains.RATE.high).all(axis=1)
    return np.asarray(sound)


def centre_of_pressure(walk: Walk) -> Array:
    """Centre of pressure that the ankle's torque requires at each sample, shape (samples,), m ahead of the ankle.

    The normal force follows from the equations of motion under the recorded torques, without pushes. The result is NaN
    where the walk has diverged, and where the ground would have to pull.
    """
    robot, samples = walk.robot, walk.samples
    bent, locked = flexion(walk), samples.get("locked", np.ones_like(samples["stance"]))
    places = np.full(len(samples["time"]), math.nan)
    for k in np.flatnonzero(is_sound(walk)):
        q, dq, torque, slope = (samples[name][k] for name in ("q", "dq", "torque", "slope"))
        force = robot.ground_force(q, dq, torque, slope, locked=locked[k], stance_flexion=bent[k])
        places[k] = pressure_place(robot, torque[0], force, slope)
    return places


def shortest_foot(
    times: Array, total: float, ahead: float, behind: float, leg_length: float, share: float = USUAL
) -> float:
    """Length of the shortest flat foot that contains the centre of pressure for a share of the time, m.

    Time is taken to be spread evenly within a bin. The length is infinite if the torque acts without a normal force for
    longer than may be left out, and NaN if the times are unknown.

    Args:
        times: Time in each bin of the centre of pressure, s.
        total: Duration of the walk, s.
        ahead: Greatest distance of the centre of pressure ahead of the ankle, m.
        behind: Greatest distance of the centre of pressure behind the ankle, m.
        leg_length: Length of a leg, m.
        share: Share of the duration.
    """
    if np.isnan(times).any() or not total > 0.0:
        return math.nan
    left_out = (1.0 - share) * total
    edges = [np.minimum(np.arange(HALF) * WIDTH, max(most, 0.0) / leg_length) for most in (behind, ahead)]
    beyond = [np.cumsum(side[::-1])[::-1] for side in (times[HALF - 1 :: -1], times[HALF:])]
    if beyond[0][-1] + beyond[1][-1] > left_out:
        return math.inf
    length = math.inf
    for k in (0, 1):  # with one end at the edge of a bin, beyond which is some of the time that may be left out
        rest = left_out - beyond[k]
        ends = np.interp(-rest, -beyond[1 - k], edges[1 - k])  # the other end, beyond which exactly the rest lies
        length = np.min((edges[k] + ends)[rest >= beyond[1 - k][-1]], initial=length)
    return float(length * leg_length)


def knee_torque(walk: Walk) -> Array:
    """Torque that holds the stance knee at each sample, shape (samples,), N m.

    The torque of a motor is the recorded one. For a locked knee it is the torque that a motor in place of the lock
    would have to give, by the equations of motion; see `mjbiped.robots.kneed`. It is positive where the motor
    must keep the knee from bending, and negative where the load straightens the knee, which the stop of a straight knee
    bears without a motor. It is NaN where the walk has diverged, and of robots in space.

    Raises:
        InputError: The robot has no knees.
    """
    robot: Any = walk.robot
    samples, bent = walk.samples, flexion(walk)
    if "stance_knee_torque" not in samples:
        raise InputError(f"the robot of this walk is a {robot.kind} biped and has no knees; expected a kneed biped")
    recorded = samples["stance_knee_torque"]
    if np.isfinite(recorded).any():
        return np.asarray(recorded, dtype=np.float64)
    if "roll" in robot.angles:
        return np.full(len(recorded), math.nan)
    sound = is_sound(walk)
    state = (samples[name][sound] for name in ("q", "dq", "torque", "slope"))
    found = np.full(len(sound), np.nan)
    found[sound] = stance_knee_torque(robot, *state, locked=samples["locked"][sound], stance_flexion=bent[sound])
    return found


def peak_knee_torque(walk: Walk) -> float:
    """Greatest torque that a motor would need to hold a locked stance knee, over all samples, N m; NaN without samples.

    What the stop of a straight knee bears is left out. The peak of a real motor is recorded at the touchdowns.

    Raises:
        InputError: The robot has no knees.
    """
    held = knee_torque(walk)
    needed = np.where(flexion(walk) > BENT, np.abs(held), np.maximum(held, 0.0))
    return float(np.fmax.reduce(needed, initial=math.nan))
