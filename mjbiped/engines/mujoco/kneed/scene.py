"""What the stepping with knees works on in a scene: where things are in it, and arrays that show MuJoCo's memory."""

from __future__ import annotations

import mujoco
import numpy as np

from mjbiped.engines.mujoco.callbacks import Places
from mjbiped.engines.mujoco.kneed.state import Motors, Scene


def shown(model: mujoco.MjModel, data: mujoco.MjData, places: Places) -> Scene:
    """The arrays of a model with knees, whose feet collide by a bit each from now on; see `Scene`."""
    model.body_conaffinity[0] = 3
    ground = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == 0 and model.geom_conaffinity[geom]]
    return Scene(
        qpos=data.qpos,
        qvel=data.qvel,
        qacc=data.qacc,
        ctrl=data.ctrl,
        qfrc_applied=data.qfrc_applied,
        sensordata=data.sensordata,
        eq_active=data.eq_active,
        eq_data=model.eq_data,
        eq_solref=model.eq_solref,
        jnt_solref=model.jnt_solref,
        geom_solref=model.geom_solref,
        geom_conaffinity=model.geom_conaffinity,
        ground=np.array(ground, dtype=np.int64),
        risers=np.array([geom for geom in ground if places.risers[geom] >= 0.0], dtype=np.int64),
        bits=np.zeros((2, len(ground)), dtype=np.int32),
    )


def motors_of(model: mujoco.MjModel) -> Motors:
    """Where the joints' parts are in a model with knees."""

    def both(kind: str, name: str) -> tuple[int, int]:
        left, right = (int(getattr(model, kind)(f"{side}_{name}").id) for side in ("left", "right"))
        return left, right

    return Motors(
        ankles=both("actuator", "ankle"),
        hip=int(model.actuator("hip").id),
        knees=both("actuator", "knee"),
        joints=both("joint", "knee"),
        locks=both("equality", "lock"),
    )
