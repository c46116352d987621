"""A recorded walk's scene, in which the robot is set to the record's postures; nothing is stepped."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from mjbiped.engines.mujoco.compiled.registry import python_callbacks_removed
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows
from mjbiped.records.record import Walk
from mjbiped.rendering.camera import fit_cameras
from mjbiped.rendering.moments import Moment

_SIGHT = 6.0  # ground built beyond what the record or a frame needs, in leg lengths
_TOUCHING = 2e-4  # of a foot and the ground, between which MuJoCo looks for contacts to show, in leg lengths
_SAME = 1e-9  # times that differ by less are the same, s


class PosedScene:
    """The scene of a walk; on a long terrain, one about each place.

    Attributes:
        model: With the ground as it is seen.
        data: Its state.
    """

    model: mujoco.MjModel
    data: mujoco.MjData

    def __init__(self, walk: Walk) -> None:
        """Cut the terrain of a record with samples; `go_to` builds."""
        self._samples, self._length, self._robot = walk.samples, walk.robot.leg_length, walk.robot
        self._windows = GroundWindows(
            walk.robot,
            walk.terrain,
            timestep=1e-4,  # any: nothing is stepped
            reach=float(np.max(self._samples["qpos"][:, 0])) + _SIGHT * self._length,
            ground=walk.settings.get("ground", "auto"),
            scenery=True,
            margin=max(_SIGHT, MARGIN) * self._length,
        )
        self._inside = (math.inf, -math.inf)

    def go_to(self, x: float) -> bool:
        """Build the ground about a hip at x (m) where there is none yet; whether `model` and `data` are others now."""
        low, high = self._inside
        if low < x < high or (not math.isfinite(x) and low < high):
            return False
        scene = self._windows.about(x)
        self.model, self._inside = scene.model, self._windows.inside(scene)
        fit_cameras(self.model, self._length)
        for side in ("left", "right"):
            self.model.geom(f"{side}_foot").margin[:] = _TOUCHING * self._length
        self.data = mujoco.MjData(self.model)
        return True

    def pose(self, moment: Moment, *, forces: bool) -> None:
        """Give the model a posture.

        Args:
            moment: Of the record.
            forces: Whether contacts, forces and what else MuJoCo's visual flags show is wanted, too.
        """
        model, data, samples = self.model, self.data, self._samples
        for name, value in zip(self._robot.places, moment.qpos, strict=True):
            data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
        if forces and self._robot.knees:
            self._move(moment)
        elif forces:
            dq = samples["dq"][max(0, int(np.searchsorted(samples["time"], moment.time + _SAME, side="right")) - 1)]
            rates = dq[::-1] if moment.stance else dq
            stance, length = moment.qpos[2 + moment.stance], self._length
            data.qvel[:] = (length * dq[0] * math.cos(stance), -length * dq[0] * math.sin(stance), *rates)
            data.ctrl[:] = 0.0
            data.ctrl[moment.stance] = moment.torque[0]
            data.ctrl[2] = moment.torque[1] * (1.0 if moment.stance == 0 else -1.0)
            with python_callbacks_removed():
                mujoco.mj_forward(model, data)
        else:
            place(model, data)

    def _move(self, moment: Moment) -> None:
        """Give a robot with knees rates, torques and locks, too, and let MuJoCo find forces."""
        model, data, samples = self.model, self.data, self._samples
        latest = max(0, int(np.searchsorted(samples["time"], moment.time + _SAME, side="right")) - 1)
        dq, length, stance = samples["dq"][latest], self._length, moment.stance
        standing, swinging = ("left", "right") if stance == 0 else ("right", "left")
        lean = moment.qpos[2 + stance]
        rates = {
            "hip_x": length * dq[0] * math.cos(lean),
            "hip_z": -length * dq[0] * math.sin(lean),
            standing: dq[0],
            swinging: dq[1],
            f"{standing}_knee": 0.0,
            f"{swinging}_knee": dq[2] - dq[1],
        }
        for name, rate in rates.items():
            data.qvel[model.jnt_dofadr[model.joint(name).id]] = rate
        data.ctrl[:] = 0.0
        data.ctrl[model.actuator(f"{standing}_ankle").id] = moment.torque[0]
        data.ctrl[model.actuator("hip").id] = moment.torque[1] * (1.0 if stance == 0 else -1.0)
        data.ctrl[model.actuator(f"{swinging}_knee").id] = moment.torque[2]
        data.eq_active[model.equality(f"{standing}_lock").id] = 1
        data.eq_active[model.equality(f"{swinging}_lock").id] = samples["locked"][latest]
        with python_callbacks_removed():
            mujoco.mj_forward(model, data)


def place(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Bring all that is drawn where the positions say, and nothing else."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
