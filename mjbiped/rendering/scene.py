"""Scene of a recorded walk, in which the robot is set to recorded postures; its cameras, and their view in pixels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.engines.mujoco.callback import python_removed
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import MARGIN, GroundWindows
from mjbiped.records.record import Walk
from mjbiped.rendering.moments import Moment
from mjbiped.utils.mujoco import mujoco

_SIGHT = 6.0  # length of ground beyond what the record or a frame needs, in leg lengths
_TOUCHING = 2e-4  # distance of foot and ground within which MuJoCo finds contacts to show, in leg lengths
_SAME = 1e-9  # times that differ by less are the same, s

_CALM = 0.35  # standard deviation of the Gaussian that smooths the path, s: half a step
_REACH = 30  # samples of the path on either side that the Gaussian reaches
_MOST_PLACES = 1_000_000  # greatest number of samples of the path; in ten hours of walking the Gaussian widens


class PosedScene:
    """Scene of a walk; on a long terrain, one scene about each place.

    Attributes:
        model: Model with the visible ground.
        data: State of the model.
    """

    model: mujoco.MjModel
    data: mujoco.MjData

    def __init__(self, walk: Walk) -> None:
        """Cut the terrain of a record with samples; `go_to` builds the scene."""
        self._samples, self._length, self._robot = walk.samples, walk.robot.leg_length, walk.robot
        reach = float(np.max(self._samples["qpos"][:, 0])) + _SIGHT * self._length
        ground = Ground(walk.terrain, reach=reach, kind=walk.settings.get("ground", "auto"))
        margin, any_step = max(_SIGHT, MARGIN) * self._length, 1e-4  # nothing is stepped
        self._windows = GroundWindows(walk.robot, ground, any_step, margin, scenery=True)
        self._inside = (math.inf, -math.inf)

    def go_to(self, x: float) -> bool:
        """Build the ground about a hip at x (m) if there is none yet; return whether `model` and `data` are new."""
        low, high = self._inside
        if low < x < high or (not math.isfinite(x) and low < high):
            return False
        scene = self._windows.about(x)
        self.model, self._inside = scene.model, scene.inside
        fit_cameras(self.model, self._length)
        bodies = self._robot.bodies
        for name in (name for limb in bodies.limbs for name in bodies.feet(limb)):
            self.model.geom(name).margin[:] = _TOUCHING * self._length
        self.data = mujoco.MjData(self.model)
        return True

    def pose(self, moment: Moment, *, forces: bool) -> None:
        """Set the model to a posture.

        Args:
            moment: Instant of the record.
            forces: Whether contacts, forces and everything else that MuJoCo's visual flags show is needed.
        """
        model, data, samples, torque = self.model, self.data, self._samples, moment.torque
        for name, value in zip(self._robot.places, moment.qpos, strict=True):
            data.joint(name).qpos[:] = value
        if not forces:
            place(model, data)
            return
        latest = max(0, int(np.searchsorted(samples["time"], moment.time + _SAME, side="right")) - 1)
        robot, dq, lean = self._robot, samples["dq"][latest], self._robot.lean(moment.qpos, moment.stance)
        limbs = robot.bodies.limbs
        stance, swing = limbs[moment.stance], limbs[(moment.stance + 1) % len(limbs)]
        speed = self._length * dq[0]
        # postures depend linearly on the angles
        moved, still = (robot.posture((0.0, 0.0), moment.stance, angles) for angles in (dq, np.zeros_like(dq)))
        rates = speed * math.cos(lean), -speed * math.sin(lean), *np.subtract(moved, still)[2:]
        torques = {stance.ankle: torque[0]}
        if "hip" in robot.joints:
            torques["hip"] = -torque[1] if moment.stance else torque[1]
        if "knee" in robot.joints:
            torques[f"{swing.name}_knee"] = torque[2]
            data.eq_active[model.equality(f"{stance.name}_lock").id] = 1
            data.eq_active[model.equality(f"{swing.name}_lock").id] = samples["locked"][latest]
        for name, value in zip(robot.places, rates, strict=True):
            data.joint(name).qvel[:] = value
        data.ctrl[:] = 0.0
        for name, value in torques.items():
            data.actuator(name).ctrl[:] = value
        with python_removed():
            mujoco.mj_forward(model, data)


def place(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute the places of everything that is drawn from the positions, and nothing else."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)


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
    """Projection of places to pixels by a camera of a scene.

    Attributes:
        size: Width and height of the picture, pixels.
        place: Place of the camera, m.
        axes: Right, up and backward directions of the camera, as rows.
        half: Half height of the visible region at distance 1; in m for an orthographic camera.
        orthographic: Whether sizes are the same at all distances.
    """

    size: tuple[int, int]
    place: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: float
    orthographic: bool

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData, camera: int, size: tuple[int, int]) -> View:
        """Return the view of the camera with this number in a picture of the given width and height in pixels."""
        orthographic = bool(model.cam_projection[camera] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC)
        angle = float(model.cam_fovy[camera])
        half = 0.5 * angle if orthographic else math.tan(math.radians(0.5 * angle))
        return cls(size, data.cam_xpos[camera].copy(), data.cam_xmat[camera].reshape(3, 3).T.copy(), half, orthographic)

    def pixel(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Return column and row of a place (m)."""
        right, up, behind = (self.axes @ (np.array((x, y, z)) - self.place)).tolist()
        width, height = self.size
        share = 0.5 * height / self.half / (1.0 if self.orthographic else -behind)
        return 0.5 * width + share * right, 0.5 * height - share * up
