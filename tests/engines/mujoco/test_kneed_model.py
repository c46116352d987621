"""The kneed biped's MJCF against the robot's own equations, whatever its parameters."""

import math

import mujoco
import numpy as np
import pytest
from simulations import build_scene

import mjbiped
from mjbiped.engines.mujoco.scene import models_folder
from mjbiped.robots.kneed import KneedBiped


def test_file_is_the_default_robot() -> None:
    """With floor or without: filled with the defaults, the scene is the file."""
    model = mujoco.MjModel.from_xml_path(str(models_folder() / "kneed.xml"))
    filled = build_scene(KneedBiped(), mjbiped.Terrain.level(), timestep=1e-4, reach=2.0).model
    for name in ("body_mass", "body_ipos", "body_pos", "jnt_range", "jnt_solref", "eq_solref"):
        np.testing.assert_allclose(getattr(filled, name), getattr(model, name), rtol=1e-15, err_msg=name)
    np.testing.assert_allclose(filled.body_inertia[1:, 1], model.body_inertia[1:, 1], rtol=1e-15)
    for name in ("left_foot", "right_foot", "left_tip", "left_kneecap", "right_shank", "hip_visual"):
        for what in ("size", "pos", "solref", "friction"):
            expected = getattr(model.geom(name), what)
            np.testing.assert_allclose(getattr(filled.geom(name), what), expected, rtol=1e-12, err_msg=name)


def test_gait_keyframe_is_the_passive_gait() -> None:
    model = mujoco.MjModel.from_xml_path(str(models_folder() / "kneed.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("gait").id)
    gait = mjbiped.find_kneed_gait(KneedBiped(), math.radians(2.5))
    mujoco.mj_kinematics(model, data)
    # the file's numbers have 10 decimals
    assert data.geom("left_foot").xpos == pytest.approx([0, 0, 0], abs=1e-9)
    assert data.qpos[[2, 4]] - gait.slope == pytest.approx(gait.start[:2], abs=1e-9)
    assert data.qvel[[2, 4]] == pytest.approx(gait.start[3:5], abs=1e-9)


def test_a_locked_knee_holds_and_a_free_one_stops() -> None:
    """Under the robot's weight a locked knee bends by some 1e-6 rad; a knee that closes at 3 rad/s does not rebound."""
    model = build_scene(KneedBiped(), mjbiped.Terrain.level(), timestep=1e-3, reach=2.0).model
    data = mujoco.MjData(model)
    data.qpos[:] = [-0.18, math.cos(0.18), -0.18, 0.0, 0.2, 0.3]
    data.qvel[:] = [0.9, 0.0, 0.9, 0.0, 0.3, -3.0]
    data.ctrl[model.actuator("right_knee").id] = -0.5
    model.geom_contype[model.geom("right_foot").id] = 0  # it swings
    assert data.eq_active.tolist() == [1, 0]
    flexion = []
    for _ in range(200):
        mujoco.mj_step(model, data)
        assert abs(data.qpos[3]) < 1e-5
        flexion.append(float(data.qpos[5]))
    closed = int(np.argmin(np.array(flexion) > 0.0))
    assert 0 < closed < 150
    assert max(flexion[closed:]) < 1e-4
    assert min(flexion) > -5e-3  # the step in which it comes to its stop: 1 ms of 4 rad/s
    assert not data.warning.number.any()
