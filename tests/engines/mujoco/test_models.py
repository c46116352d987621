"""The MJCF files by themselves: they load, step without a warning, and every part is named."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjbiped
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS, models_folder

FILES = ("compass.xml", "kneed.xml", "scene.xml", "kneed_scene.xml")


@pytest.mark.parametrize("name", FILES)
def test_loads_and_steps_without_warning(name: str) -> None:
    model = mujoco.MjModel.from_xml_path(str(models_folder() / name))
    data = mujoco.MjData(model)
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_step(model, data, nstep=200)
        assert not data.warning.number.any()
        assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize("name", FILES)
def test_everything_is_named(name: str) -> None:
    model = mujoco.MjModel.from_xml_path(str(models_folder() / name))
    for kind, count in (
        (model.body, model.nbody),
        (model.geom, model.ngeom),
        (model.joint, model.njnt),
        (model.actuator, model.nu),
        (model.sensor, model.nsensor),
        (model.camera, model.ncam),
        (model.tendon, model.ntendon),
        (model.key, model.nkey),
        (model.equality, model.neq),
    ):
        assert all(kind(index).name for index in range(count))


def test_robot_file_is_table_one(robot: mjbiped.Compass) -> None:
    model = mujoco.MjModel.from_xml_path(str(models_folder() / "compass.xml"))
    for side in ("left", "right"):
        assert model.body(f"{side}_leg").mass == robot.leg_mass
        assert model.body(f"{side}_leg").inertia[1] == robot.leg_inertia
        assert model.body(f"{side}_leg").ipos[2] == -robot.upper_length
        assert model.geom(f"{side}_foot").pos[2] == -robot.leg_length
        assert model.geom(f"{side}_foot").size[0] == FOOT_RADIUS
        assert model.geom(f"{side}_foot").solref[1] == -1.0 / model.opt.timestep  # a plastic impact
    assert model.body("hip").mass == SMALLEST_HIP_MASS * robot.total_mass
    assert model.opt.gravity[2] == -robot.gravity


def test_keyframes_stand_on_their_ground(gait: mjbiped.Gait) -> None:
    """`rest` has both feet at the origin; `gait` is the cycle's post-impact state on 2 degrees, stance foot there."""
    model = mujoco.MjModel.from_xml_path(str(models_folder() / "compass.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id)
    mujoco.mj_kinematics(model, data)
    assert data.geom("left_foot").xpos == pytest.approx([0, 0, 0], abs=1e-15)
    mujoco.mj_resetDataKeyframe(model, data, model.key("gait").id)
    mujoco.mj_kinematics(model, data)
    # the file's numbers have 8 decimals
    assert data.geom("left_foot").xpos == pytest.approx([0, 0, 0], abs=1e-8)
    assert data.qpos[2:] - gait.slope == pytest.approx(gait.start[:2], abs=1e-8)
    assert data.qvel[2:] == pytest.approx(gait.start[2:], abs=1e-8)
    theta, rate = data.qpos[2], data.qvel[2]
    assert data.qvel[:2] == pytest.approx([np.cos(theta) * rate, -np.sin(theta) * rate], abs=1e-8)


def test_runs_in_dm_control() -> None:
    """The scene is an ordinary MJCF file for dm_control too: named access, stepping, no warning raised."""
    dm_mujoco = pytest.importorskip("dm_control.mujoco", reason="dm-control cannot be installed on Python 3.13")
    physics = dm_mujoco.Physics.from_xml_path(str(models_folder() / "scene.xml"))
    with physics.reset_context():
        physics.named.data.qpos["hip_z"] = 1.0
        physics.named.data.qpos["left"] = 0.1
    physics.step(nstep=50)
    assert np.isfinite(physics.named.data.qpos["left"]).all()
    assert physics.named.data.sensordata["clock"] == pytest.approx(50 * physics.timestep())


def test_models_are_found_beside_the_package() -> None:
    assert {path.name for path in models_folder().iterdir()} >= {*FILES, "README.md"}
    assert Path(models_folder()).is_dir()
