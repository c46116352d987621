"""What holds the stance knee of a robot with knees in a walk: its torque over time, and the greatest one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.stance_knee import stance_knee_torque
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

BENT = 1e-4  # rad: a knee that bends less rests against its stop


def flexion(walk: Walk) -> NDArray[np.float64]:
    """Flexion of the stance knee at each sample, shape (samples,), rad.

    Raises:
        InputError: The robot has no knees.
    """
    return _kneed(walk).flexion(walk.samples["qpos"], walk.samples["stance"])


def is_sound(walk: Walk) -> NDArray[np.bool_]:
    """For each sample whether equations take its state: a walk that diverged ends with one that none does."""
    angles, dq = np.column_stack([walk.samples["q"], walk.samples["slope"]]), walk.samples["dq"]
    sound = (np.abs(angles) <= domains.ANGLE.high).all(axis=1) & (np.abs(dq) <= domains.RATE.high).all(axis=1)
    return np.asarray(sound)


def torque(walk: Walk) -> NDArray[np.float64]:
    """Torque that holds the stance knee at each sample, shape (samples,), N m.

    A motor's is the one recorded. A locked knee's is what a motor in place of the lock would have to give, by the
    equations of motion; see `mjbiped.robots.stance_knee`. It is positive where the motor must keep the knee from
    bending, and negative where the load straightens it, which a straight knee's stop bears without a motor. NaN where
    the walk has diverged.

    Raises:
        InputError: The robot has no knees.
    """
    robot, samples, bent = _kneed(walk), walk.samples, flexion(walk)
    recorded = samples["stance_knee_torque"]
    if np.isfinite(recorded).any():
        return np.asarray(recorded, dtype=np.float64)
    q, dq, sound = samples["q"], samples["dq"], is_sound(walk)
    found = np.full(len(sound), np.nan)
    found[sound] = stance_knee_torque(
        robot,
        q[sound],
        dq[sound],
        samples["torque"][sound],
        samples["slope"][sound],
        locked=samples["locked"][sound],
        stance_flexion=bent[sound],
    )
    return found


def peak_torque(walk: Walk) -> float:
    """Greatest torque of a motor that holds a locked stance knee, of all samples, N m; NaN without samples.

    What the stop of a straight knee bears is left out. A motor's own is in the touchdowns.

    Raises:
        InputError: The robot has no knees.
    """
    held = torque(walk)
    needed = np.where(flexion(walk) > BENT, np.abs(held), np.maximum(held, 0.0))
    return float(np.fmax.reduce(needed, initial=math.nan))


def _kneed(walk: Walk) -> KneedBiped:
    robot = walk.robot
    if not isinstance(robot, KneedBiped):
        raise InputError(f"the robot of this walk is a {robot.kind} biped and has no knees; expected a kneed biped")
    return robot
