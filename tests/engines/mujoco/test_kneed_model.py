"""The kneed biped's MJCF against the robot's own equations, whatever its parameters."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from simulations import build_scene

import mjbiped
from mjbiped.engines.mujoco.scene import models_folder
from mjbiped.robots.kneed import KneedBiped

RANDOM = np.random.default_rng(5)
LINKS = RANDOM.uniform(0.2, 0.9, (4, 2))
ROBOTS = [
    KneedBiped(),
    KneedBiped.halved_rods(),
    *(
        KneedBiped(
            **dict(zip(("thigh_mass", "shank_mass", "hip_mass"), RANDOM.uniform(0.5, 9.0, 3).tolist(), strict=True)),
            **dict(zip(("thigh_length", "shank_length"), links.tolist(), strict=True)),
            thigh_centre=0.6 * float(links[0]),
            shank_centre=0.3 * float(links[1]),
            thigh_inertia=float(RANDOM.uniform(0.01, 0.4)),
            shank_inertia=float(RANDOM.uniform(0.01, 0.4)),
            gravity=float(RANDOM.uniform(1.0, 20.0)),
        )
        for links in LINKS
    ),
]  # fmt: skip


@pytest.mark.parametrize("n", [3, 4])
@pytest.mark.parametrize("robot", ROBOTS)
def test_mass_matrix_and_bias(robot: KneedBiped, n: int) -> None:
    """The floating model's, taken along the motions in which its left foot stands still."""
    model = build_scene(robot, mjbiped.Terrain.level(), timestep=1e-4, reach=2.0).model
    robot = replace(robot, hip_mass=float(model.body("hip").mass[0]))  # a massless hip is not quite massless there
    data = mujoco.MjData(model)
    lower, upper = robot.shank_length, robot.thigh_length
    groups = np.eye(4) if n == 4 else np.eye(3)[[0, 0, 1, 2]]
    random = np.random.default_rng(n)
    for _ in range(10):
        q, dq = random.uniform(-1.2, 1.2, n), random.uniform(-6.0, 6.0, n)
        shank, thigh, swing, below = groups @ q
        rates = groups @ dq
        links = np.array([[lower, upper, 0.0, 0.0]]).T
        sine, cosine = np.diag(np.sin(groups @ q)), np.diag(np.cos(groups @ q))
        hip = np.vstack([(cosine @ links).T, -(sine @ links).T])  # of rates
        turned = np.array([[0, 1, 0, 0], [1, -1, 0, 0], [0, 0, 1, 0], [0, 0, -1, 1]])
        J = np.vstack([hip, turned]) @ groups
        curved = np.zeros(6)  # dJ/dt dq
        curved[:2] = -float(links[:, 0] @ sine @ rates**2), -float(links[:, 0] @ cosine @ rates**2)
        data.qpos[:] = [0.0, 5.0, thigh, shank - thigh, swing, below - swing]
        data.qvel[:] = J @ dq
        mujoco.mj_forward(model, data)
        M = np.empty((6, 6))
        mujoco.mj_fullM(model, data, M)
        scale = np.abs(robot.chains[4].weights).max()
        # rounding of a few dozen operations, of the largest entry
        np.testing.assert_allclose(J.T @ M @ J, robot.mass_matrix(q), rtol=0, atol=1e-12 * scale)
        bias = J.T @ (M @ curved + data.qfrc_bias)
        expected = robot.coriolis_matrix(q, dq) @ dq + robot.gravity_vector(q, 0.0)
        forces = scale * 36.0 * n + np.abs(robot.chains[4].moments).max()
        np.testing.assert_allclose(bias, expected, rtol=0, atol=1e-12 * forces)


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
