"""MuJoCo's stages one after the other, of which the engine's steps are made, are `mj_step`."""

import mujoco
import numpy as np
import pytest

from mjbiped.engines.mujoco import step
from mjbiped.engines.mujoco.scene import models_folder

STAGES = [name for name in step.step.__code__.co_names if name.startswith("mj_")]


@pytest.mark.parametrize("name", ["scene.xml", "kneed_scene.xml", "footed_scene.xml"])
def test_stages_are_bitwise_a_step_and_ask_for_control_once(name: str) -> None:
    """While it stumbles and falls: with contacts, limits and locks."""
    model = mujoco.MjModel.from_xml_path(str(models_folder() / name))
    whole, staged = mujoco.MjData(model), mujoco.MjData(model)
    rates = 0.3 * np.random.default_rng(0).standard_normal(model.nv)
    calls: list[mujoco.MjData] = []

    def control(_: mujoco.MjModel, data: mujoco.MjData) -> None:
        calls.append(data)
        data.ctrl[:] = np.sin(7.0 * data.time + np.arange(model.nu))

    mujoco.set_mjcb_control(control)
    try:
        for data in (whole, staged):
            mujoco.mj_resetDataKeyframe(model, data, 0)
            data.qvel[:] += rates
        touched = 0
        for _ in range(3000):
            mujoco.mj_step(model, whole)
            for stage in STAGES:
                getattr(mujoco, stage)(model, staged, *((step.VELOCITY, 0) if stage == "mj_forwardSkip" else ()))
            touched += staged.ncon > 0
    finally:
        mujoco.set_mjcb_control(None)
    assert touched > 500
    assert [calls.count(data) for data in (whole, staged)] == [3000, 3000]
    for field in ("time", "qpos", "qvel", "qacc", "qacc_warmstart", "sensordata"):
        np.testing.assert_array_equal(getattr(staged, field), getattr(whole, field), err_msg=field)
