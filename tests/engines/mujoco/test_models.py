"""The MJCF files by themselves: every part is named, and they are the default robots."""

from typing import Any, cast

import mujoco
import numpy as np
import pytest
from simulations import build_scene

import mjbiped
from mjbiped.engines.mujoco.scene import models_folder
from mjbiped.robots.robot import Robot

OBJECTS = {"body": "body", "geom": "geom", "jnt": "joint", "sensor": "sensor", "cam": "camera", "tendon": "tendon"}
OBJECTS |= {"key": "key", "eq": "equality"}
FILES = ("compass.xml", "kneed.xml", "scene.xml", "kneed_scene.xml")


@pytest.mark.parametrize("name", FILES)
def test_loads_and_steps_without_warning_and_everything_is_named(name: str) -> None:
    model = mujoco.MjModel.from_xml_path(str(models_folder() / name))
    data = mujoco.MjData(model)
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_step(model, data, nstep=200)
        assert not data.warning.number.any()
        assert np.isfinite(data.qpos).all()
    for short, kind in OBJECTS.items():
        object_kind = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
        assert all(mujoco.mj_id2name(model, object_kind, k) for k in range(getattr(model, f"n{short}"))), kind


FIELDS = ("body_mass", "body_ipos", "body_pos", "jnt_range", "jnt_solref", "eq_solref")
"""Of the model; and of the geoms of the robot's feet and joints "size", "pos", "solref" and "friction"."""


@pytest.mark.parametrize(("file", "robot"), [("compass", mjbiped.Compass()), ("kneed", mjbiped.KneedBiped())], ids=str)
def test_a_file_is_the_default_robot(file: str, robot: Robot) -> None:
    """Filled with the defaults, the scene is the file, but for what MuJoCo's compiler rounds."""
    model = mujoco.MjModel.from_xml_path(str(models_folder() / f"{file}.xml"))
    filled = build_scene(robot, mjbiped.Terrain.level(), timestep=1e-4, reach=2.0).model
    for name in FIELDS:
        mine, theirs = (getattr(each, name) for each in (filled, model))
        np.testing.assert_allclose(mine, theirs, rtol=1e-15, atol=1e-18, err_msg=name)
    np.testing.assert_allclose(filled.body_inertia[1:, 1], model.body_inertia[1:, 1], rtol=1e-15)
    for name in ("left_foot", "right_foot"):
        for what in ("size", "pos", "solref", "friction"):
            mine, theirs = (getattr(each.geom(name), what) for each in (filled, model))
            np.testing.assert_allclose(mine, theirs, rtol=1e-12, err_msg=name)
    assert model.opt.gravity[2] == -robot.gravity
    assert model.geom("left_foot").solref[1] == -1.0 / model.opt.timestep  # a plastic impact


@pytest.mark.parametrize("file", ["compass", "kneed"])
def test_keyframes_stand_on_their_ground(file: str, gait: mjbiped.Gait) -> None:
    """`gait` is the cycle's post-impact state, its stance foot at the origin; the files' numbers have 8 decimals."""
    model = mujoco.MjModel.from_xml_path(str(models_folder() / f"{file}.xml"))
    data, found, legs, rates = mujoco.MjData(model), cast(Any, gait), [2, 3], [2, 3]
    if file == "kneed":
        found, legs, rates = mjbiped.find_kneed_gait(mjbiped.KneedBiped(), np.radians(2.5)), [2, 4], [3, 4]
    mujoco.mj_resetDataKeyframe(model, data, model.key("gait").id)
    mujoco.mj_kinematics(model, data)
    assert data.geom("left_foot").xpos == pytest.approx([0, 0, 0], abs=1e-8)
    assert data.qpos[legs] - found.slope == pytest.approx(found.start[:2], abs=1e-8)
    assert data.qvel[legs] == pytest.approx(found.start[rates], abs=1e-8)
    theta, rate = data.qpos[2], data.qvel[2]
    assert data.qvel[:2] == pytest.approx([np.cos(theta) * rate, -np.sin(theta) * rate], abs=1e-8)
