"""Cameras: one that follows a walker without bobbing at each of its steps, and where in the picture a place is."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
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
    time, centre = walk.samples["time"], walk.robot.centre_of_mass(walk.samples["qpos"])
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


def fit_cameras(model: mujoco.MjModel, leg_length: float) -> None:
    """Move a scene's cameras, which are made for legs of 1 m, so that they see a robot with legs of so many m."""
    model.cam_poscom0[:] += (leg_length - 1.0) * model.cam_pos
    flat = model.cam_projection == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC
    model.cam_fovy[flat] *= leg_length
    model.stat.extent *= leg_length


class View(NamedTuple):
    """Where places are in a picture: the camera of a scene that has been updated.

    Attributes:
        size: Width and height, pixels.
        place: Of the camera, m.
        axes: Its right, up and forward directions, rows.
        frustum: Middle and half width, middle and half height of what is seen, at a distance of 1; in m where
            it is orthographic.
        orthographic: Whether sizes are the same at all distances.
    """

    size: tuple[int, int]
    place: NDArray[np.float64]
    axes: NDArray[np.float64]
    frustum: tuple[float, float, float, float]
    orthographic: bool

    @classmethod
    def of(cls, scene: Any, width: int, height: int) -> View:
        """The view of an `mujoco.MjvScene` in a picture of so many pixels."""
        left, right = scene.camera  # eyes, between which MuJoCo takes the middle
        forward, up, place = (
            0.5 * (np.array(one, dtype=np.float64) + other)
            for one, other in ((left.forward, right.forward), (left.up, right.up), (left.pos, right.pos))
        )
        share = 1.0 if left.orthographic else 1.0 / left.frustum_near
        half = 0.5 * (left.frustum_top - left.frustum_bottom) * share
        middle = 0.5 * (left.frustum_top + left.frustum_bottom) * share
        centre = 0.5 * (left.frustum_center + right.frustum_center) * share
        axes = np.stack([np.cross(forward, up), up, forward])
        return cls((width, height), place, axes, (centre, half * width / height, middle, half), bool(left.orthographic))

    def pixel(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Column and row of a place (m)."""
        right, up, distance = (self.axes @ (np.array((x, y, z)) - self.place)).tolist()
        if not self.orthographic:
            right, up = right / distance, up / distance
        centre, half_width, middle, half_height = self.frustum
        width, height = self.size
        return (
            0.5 * width * (1.0 + (right - centre) / half_width),
            0.5 * height * (1.0 - (up - middle) / half_height),
        )
