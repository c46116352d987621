"""Cameras: one that follows a walker without bobbing at each step, and the projection of places to pixels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.records.record import Walk
from mjbiped.utils.mujoco import mujoco

_CALM = 0.35  # standard deviation of the Gaussian that smooths the path, s: half a step
_REACH = 30  # samples of the path on either side that the Gaussian reaches
_MOST_PLACES = 1_000_000  # greatest number of samples of the path; in ten hours of walking the Gaussian widens


def smooth_offsets(walk: Walk) -> NDArray[np.float64]:
    """Return the offsets from the centre of mass to a smoothed path of it, which the camera follows.

    Args:
        walk: The record.

    Returns:
        Offsets in x and z at each sample, m, shape (samples, 2).
    """
    time, centre = walk.samples["time"], walk.robot.centre_of_mass(walk.samples["qpos"])
    if len(time) < 2 or time[-1] == time[0]:
        return np.zeros_like(centre)
    pitch = max(_CALM / 10.0, (time[-1] - time[0]) / _MOST_PLACES)
    even = np.arange(time[0], time[-1] + pitch, pitch)
    path = np.stack([np.interp(even, time, places) for places in centre.T], axis=1)
    # continued beyond both ends by point reflection, so that the camera neither lags at the start nor stops early
    padded = np.pad(path, ((_REACH, _REACH), (0, 0)), mode="reflect", reflect_type="odd")
    smoothed = scipy.ndimage.gaussian_filter1d(padded, 10.0, axis=0, radius=_REACH)[_REACH:-_REACH]
    smooth = np.stack([np.interp(time, even, places) for places in smoothed.T], axis=1)
    return np.asarray(smooth - centre, dtype=np.float64)


def fit_cameras(model: mujoco.MjModel, leg_length: float) -> None:
    """Move a scene's cameras, which are made for legs of 1 m, to see a robot with another leg length (m)."""
    model.cam_poscom0[:] += (leg_length - 1.0) * model.cam_pos
    flat = model.cam_projection == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC
    model.cam_fovy[flat] *= leg_length
    model.stat.extent *= leg_length


class View(NamedTuple):
    """Projection of places to pixels by the camera of an updated scene.

    Attributes:
        size: Width and height of the picture, pixels.
        place: Place of the camera, m.
        axes: Right, up and forward directions of the camera, as rows.
        frustum: Middle and half width, middle and half height of the visible region at distance 1; in m for an
            orthographic camera.
        orthographic: Whether sizes are the same at all distances.
    """

    size: tuple[int, int]
    place: NDArray[np.float64]
    axes: NDArray[np.float64]
    frustum: tuple[float, float, float, float]
    orthographic: bool

    @classmethod
    def of(cls, scene: mujoco.MjvScene, width: int, height: int) -> View:
        """Return the view of an `mujoco.MjvScene` in a picture of the given size in pixels."""
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
        """Return column and row of a place (m)."""
        right, up, distance = (self.axes @ (np.array((x, y, z)) - self.place)).tolist()
        if not self.orthographic:
            right, up = right / distance, up / distance
        centre, half_width, middle, half_height = self.frustum
        width, height = self.size
        return (
            0.5 * width * (1.0 + (right - centre) / half_width),
            0.5 * height * (1.0 - (up - middle) / half_height),
        )
