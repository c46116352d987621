"""A camera that follows a walker without bobbing at each of its steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjbiped.records.record import Walk

_CALM = 0.35  # standard deviation of the bell curve that smooths the path, s: half a step
_MOST_PLACES = 1_000_000  # at which the path is smoothed; in ten hours of walking the curve widens, and nobody sees it


def smooth_offsets(walk: Walk) -> NDArray[np.float64]:
    """What to add to the place of a camera that follows the centre of mass, so that it follows a smoothed path of it.

    Args:
        walk: The record.

    Returns:
        Offsets in x and z at each sample, m, shape (samples, 2).
    """
    time, qpos, robot = walk.samples["time"], walk.samples["qpos"], walk.robot
    share = robot.leg_mass * robot.upper_length / robot.total_mass
    legs = np.stack([np.sin(qpos[:, 2:]).sum(axis=1), np.cos(qpos[:, 2:]).sum(axis=1)], axis=1)
    centre = qpos[:, :2] - share * legs
    if len(time) < 2:
        return np.zeros_like(centre)
    pitch = max(_CALM / 10.0, (time[-1] - time[0]) / _MOST_PLACES)
    even = np.arange(time[0], time[-1] + pitch, pitch)
    lags = np.arange(-30, 31)
    bell = np.exp(-0.5 * (lags / 10.0) ** 2)
    smooth = np.empty_like(centre)
    for axis, path in enumerate(centre.T):
        resampled = np.interp(even, time, path)
        # continued beyond both ends by point reflection, so that the camera neither lags at the start nor stops early
        padded = (
            np.pad(resampled, 30, mode="reflect", reflect_type="odd") if len(even) > 1 else np.repeat(resampled, 61)
        )
        smooth[:, axis] = np.interp(time, even, np.convolve(padded, bell / bell.sum(), mode="valid"))
    return np.asarray(smooth - centre, dtype=np.float64)
