"""Moments of a walk for drawing, the scene that shows the robot at a moment, and its cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.analysis.replay import TrackedReference, recorded_controller
from mjbiped.control.tracking import Tracking
from mjbiped.engines.mujoco.callback import python_removed
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import MARGIN, GroundWindows
from mjbiped.errors import MjbipedError
from mjbiped.records.loads import is_sound
from mjbiped.records.record import Walk
from mjbiped.robots.footing import Footing
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

TRACE = 2.0
"""Time for which the path of a foot is seen, s."""

APART = 0.04  # distance between the points of a foot's path, in leg lengths
_SAME = 1e-9  # times that differ by less are the same, s

_SIGHT = 6.0  # length of ground beyond what the record or a frame needs, in leg lengths
_TOUCHING = 2e-4  # distance of foot and ground within which MuJoCo finds contacts to show, in leg lengths
_CALM = 0.35  # standard deviation of the Gaussian that smooths the path, s: half a step
_REACH = 30  # samples of the path on either side that the Gaussian reaches
_MOST_PLACES = 1_000_000  # greatest number of samples of the path; in ten hours of walking the Gaussian widens

Pair = tuple[float, float]
Points = NDArray[np.float64]


class Moment(NamedTuple):
    """An instant of a walk.

    Attributes:
        time: Time since the start of the walk, s.
        step: Number of the current step, from 1 on; a touchdown belongs to the step that it ends.
        qpos: Posture, see `Robot.places`: hip x and z (m), left and right leg from the vertical, flexions (rad).
        stance: Number of the stance leg; of a biped 0 left, 1 right.
        slope: Slope of the ground under the stance foot, rad.
        slope_estimate: Slope that the controller estimates, rad; NaN if it makes no estimate.
        torque: Torques of the robot's joints, N m.
        force: Force of the ground on the stance foot, forward and upward, N; in space along x, y and z. NaN where the
            walk has diverged.
        reference: Posture that the controller tracks on the stance foot, as `qpos`; None without a reference.
        ground: Height (m) and slope (rad) of the ground under left and right foot.
        traces: Paths of left and right foot until now, points x, z in m, each of shape (n, 2); in space x, y, z.
        footing: Of a robot in space; None in the plane.
        lateral_estimate: Slope to the left that the controller estimates, rad; NaN if it makes no estimate.
    """

    time: float
    step: int
    qpos: tuple[float, ...]
    stance: int
    slope: float
    slope_estimate: float
    torque: tuple[float, ...]
    force: tuple[float, ...]
    reference: tuple[float, ...] | None
    ground: tuple[Pair, ...]
    traces: tuple[Points, ...]
    footing: Footing | None = None
    lateral_estimate: float = math.nan


def latest_sample(times: Points, time: float) -> int:
    """Index of the latest sample at a time (s); the first one before it."""
    return max(0, int(np.searchsorted(times, time + _SAME, side="right")) - 1)


class Moments:
    """Instants of a record."""

    def __init__(self, walk: Walk, *, ghost: bool = True) -> None:
        """Prepare the paths of the feet and the reference that the controller tracked.

        Args:
            walk: A record with samples.
            ghost: Whether the tracked reference is wanted.
        """
        self._walk, self._robot, self._times = walk, walk.robot, walk.samples["time"]
        self._sound, self._reference = is_sound(walk), None
        if ghost:
            with suppress(MjbipedError, ArithmeticError, ValueError):  # it tracks none, or cannot be rebuilt
                self._reference = TrackedReference(walk, recorded_controller(walk, kind=Tracking))
        self._ways, length = list[tuple[NDArray[np.int64], Points]](), self._robot.leg_length
        for feet in np.moveaxis(self._points(walk.samples["qpos"])[:, :, -1], 1, 0):
            way = np.append(0.0, np.cumsum(np.hypot.reduce(np.diff(feet, axis=0), axis=1)))
            marks = np.flatnonzero(np.diff(np.floor(way / (APART * length)), prepend=-1.0))
            self._ways.append((marks, feet[marks]))

    def _points(self, qpos: Points) -> Points:
        """Places that are drawn of each leg in postures, shape (..., legs, points, 2), m."""
        return self._robot.limbs(qpos)

    def greatest_torque(self, start: float, stop: float) -> float:
        """Greatest finite torque of all joints between two times (s), N m; 0 without one."""
        low, high = np.searchsorted(self._times, (start, stop), side="left")
        torque = np.abs(self._walk.samples["torque"][max(0, low - 1) : high + 1])
        return float(np.max(torque, initial=0.0, where=np.isfinite(torque)))

    def at(self, time: float) -> Moment:
        """Return the instant at a time (s) of the record.

        The posture is interpolated between samples; everything else is from the latest sample.
        """
        samples, times, touchdowns = self._walk.samples, self._times, self._walk.touchdowns["time"]
        latest = latest_sample(times, time)
        following = min(latest + 1, len(times) - 1)
        between = times[following] - times[latest]
        share = min(1.0, max(0.0, (time - times[latest]) / between)) if between > 0.0 else 0.0
        before = samples["qpos"][latest]
        qpos = before + share * (samples["qpos"][following] - before)
        slope, stance = float(samples["slope"][latest]), int(samples["stance"][latest])
        locked = bool(samples["locked"][latest]) if "locked" in samples else False
        tracked = None if self._reference is None else self._reference.at(time, locked=locked)
        feet, ground, reference = self._beside(qpos, stance, slope, tracked)
        return Moment(
            time=time,
            step=1 + int(np.searchsorted(touchdowns, time - _SAME)),
            qpos=tuple(qpos.tolist()),
            stance=stance,
            slope=slope,
            slope_estimate=float(samples["slope_estimate"][latest]),
            torque=tuple(samples["torque"][latest].tolist()),
            force=self._force(latest, stance, slope, locked=locked) if self._sound[latest] else (math.nan, math.nan),
            reference=reference,
            ground=ground,
            traces=tuple(self._trace(leg, time, foot) for leg, foot in enumerate(feet)),
        )

    def _force(self, latest: int, stance: int, slope: float, *, locked: bool) -> tuple[float, ...]:
        """Force of the ground on the stance foot at a sample, N."""
        samples = self._walk.samples
        q, dq, torque = (samples[name][latest] for name in ("q", "dq", "torque"))
        bent = float(self._robot.flexion(samples["qpos"][latest], stance))
        return self._robot.ground_force(q, dq, torque, slope, locked=locked, stance_flexion=bent)

    def _beside(self, qpos: Points, stance: int, slope: float, tracked: Sequence[float] | None) -> Any:
        """See `beside_posture`."""
        return beside_posture(self._robot, self._walk.terrain, qpos, stance, slope, tracked)

    def _trace(self, leg: int, time: float, foot: Sequence[float]) -> Points:
        """Path of a foot until a time (s), at which it is at a place (m)."""
        marks, points = self._ways[leg]
        low, high = np.searchsorted(marks, np.searchsorted(self._times, (time - TRACE, time + _SAME), side="right"))
        return np.vstack([points[low:high], foot])


def beside_posture(
    robot: Robot, terrain: Terrain, qpos: Points, stance: int, slope: float, tracked: Sequence[float] | None
) -> tuple[list[Pair], tuple[Pair, ...], tuple[float, ...] | None]:
    """Return the places of the feet, the ground under them, and the posture that a controller tracks on its foot.

    Args:
        robot: The robot.
        terrain: The ground.
        qpos: Posture, see `Robot.places`.
        stance: Number of the stance leg.
        slope: Slope of the ground, rad.
        tracked: Tracked angles from the ground's normal, stance leg first, rad; None without a reference.

    Returns:
        x and z of each foot, m; height (m) and slope (rad) under each; a posture, or None without finite angles.
    """
    feet: list[Pair] = [(x, z) for x, z in robot.limbs(qpos)[:, -1].tolist()]
    ground = tuple((terrain.height_at(x), terrain.slope_at(x)) for x, _ in feet)
    reference = None
    if tracked is not None and all(map(math.isfinite, tracked)):
        angles = [angle + slope for angle in tracked]
        reference = robot.posture(feet[stance], stance, angles, float(robot.flexion(qpos, stance)))
    return feet, ground, reference


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
        latest = latest_sample(samples["time"], moment.time)
        robot, rates = self._robot, self._rates(moment, samples["dq"][latest])
        limbs = robot.bodies.limbs
        stance, swing = limbs[moment.stance], limbs[(moment.stance + 1) % len(limbs)]
        torques = {stance.ankle: torque[0]}
        if "hip" in robot.joints:
            torques["hip"] = -torque[1] if moment.stance else torque[1]
        if "abduction" in robot.joints:
            torques["abduction"] = torque[2]
        if "ankle_roll" in robot.joints:
            torques["ankle_roll"] = torque[-1] if moment.stance else -torque[-1]
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

    def _rates(self, moment: Moment, dq: Points) -> Sequence[float]:
        """Rates of a posture, in the order of the robot's places."""
        robot, lean, speed = self._robot, self._robot.lean(moment.qpos, moment.stance), self._length * float(dq[0])
        # postures depend linearly on the angles
        moved, still = (robot.posture((0.0, 0.0), moment.stance, angles) for angles in (dq, np.zeros_like(dq)))
        return speed * math.cos(lean), -speed * math.sin(lean), *np.subtract(moved, still)[2:]


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
        Offsets in x and z at each sample, m, shape (samples, 2); in space in x, y and z.
    """
    time, robot, qpos = walk.samples["time"], walk.robot, walk.samples["qpos"]
    centre = robot.centre_in_space(qpos) if isinstance(robot, InSpace) else robot.centre_of_mass(qpos)
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
