"""Torque that holds the stance knee of a robot with knees during a walk."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.robots.stance_knee import stance_knee_torque
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

BENT = 1e-4  # rad: a knee that bends less rests against its stop


def flexion(walk: Walk) -> NDArray[np.float64]:
    """Flexion of the stance knee at each sample, shape (samples,), rad; zero for straight legs."""
    return walk.robot.flexion(walk.samples["qpos"], walk.samples["stance"])


def is_sound(walk: Walk) -> NDArray[np.bool_]:
    """Whether each sample is a state that the equations of motion accept; the last one of a diverged walk is not."""
    angles, dq = np.column_stack([walk.samples["q"], walk.samples["slope"]]), walk.samples["dq"]
    sound = (np.abs(angles) <= domains.ANGLE.high).all(axis=1) & (np.abs(dq) <= domains.RATE.high).all(axis=1)
    return np.asarray(sound)


def torque(walk: Walk) -> NDArray[np.float64]:
    """Torque that holds the stance knee at each sample, shape (samples,), N m.

    The torque of a motor is the recorded one. For a locked knee it is the torque that a motor in place of the lock
    would have to give, by the equations of motion; see `mjbiped.robots.stance_knee`. It is positive where the motor
    must keep the knee from bending, and negative where the load straightens the knee, which the stop of a straight knee
    bears without a motor. It is NaN where the walk has diverged.

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
    sound = is_sound(walk)
    state = (samples[name][sound] for name in ("q", "dq", "torque", "slope"))
    found = np.full(len(sound), np.nan)
    found[sound] = stance_knee_torque(robot, *state, locked=samples["locked"][sound], stance_flexion=bent[sound])
    return found


def peak_torque(walk: Walk) -> float:
    """Greatest torque that a motor would need to hold a locked stance knee, over all samples, N m; NaN without samples.

    What the stop of a straight knee bears is left out. The peak of a real motor is recorded at the touchdowns.

    Raises:
        InputError: The robot has no knees.
    """
    held = torque(walk)
    needed = np.where(flexion(walk) > BENT, np.abs(held), np.maximum(held, 0.0))
    return float(np.fmax.reduce(needed, initial=math.nan))
