"""Pictures of robots in space: bodies, marks and ground stand where the record says."""

import math

import mujoco
import numpy as np
import pytest

import mjbiped
from mjbiped import Walk, render_frame
from mjbiped.records.signals import SIGNALS
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.marks import FORCE_COLOUR, MOST_GEOMS, Scales
from mjbiped.rendering.space import draw_marks, moments_of, scene_of
from mjbiped.robots.in_space import InSpace
from mjbiped.utils.palette import rgb

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


@pytest.fixture(scope="module", params=[mjbiped.Compass3D(), mjbiped.Kneed3D()])
def robot(request: pytest.FixtureRequest) -> InSpace:
    return request.param  # type: ignore[no-any-return]


def test_limbs_and_centre_of_mass_are_those_of_mujoco_s_bodies(robot: InSpace) -> None:
    rng, model = np.random.default_rng(3), mujoco.MjModel.from_xml_path(f"models/{robot.bodies.scene}")
    data, qpos = mujoco.MjData(model), rng.normal(0.0, 0.3, len(robot.places))
    for name, value in zip(robot.places, qpos, strict=True):
        data.joint(name).qpos[:] = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    feet = [data.geom(f"{limb.name}_foot").xpos for limb in robot.bodies.limbs]
    np.testing.assert_allclose(robot.points(qpos)[:, -1], feet, atol=1e-12)
    np.testing.assert_allclose(robot.centre_in_space(qpos), data.subtree_com[0], atol=1e-6)


def test_a_footing_is_told_by_its_posture(in_space: Walk) -> None:
    robot, touchdowns = in_space.robot, in_space.touchdowns
    assert isinstance(robot, InSpace)
    for k in range(in_space.steps):
        place, stance = np.array([touchdowns[name][k] for name in "xyz"]), int(touchdowns["stance"][k])
        footing = robot.footing(touchdowns["qpos"][k], stance, in_space.terrain.normal_at(*place[:2]))
        assert footing.place == pytest.approx(place, abs=1e-9)
        told = footing.slope, footing.lateral
        assert told == pytest.approx((touchdowns["slope"][k], touchdowns["lateral_slope"][k]), abs=1e-9)
        assert footing.posture(robot, touchdowns["q"][k]) == pytest.approx(touchdowns["qpos"][k], abs=1e-9)


def test_force_and_estimate_are_drawn_where_they_are(in_space: Walk) -> None:
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), maxgeom=MOST_GEOMS)
    robot, moment = in_space.robot, moments_of(in_space).at(float(in_space.touchdowns["time"][1]) + 0.3)
    draw_marks(scene, moment, robot, Scales(10.0, robot.weight), {"force", "estimate"})
    drawn = [scene.geoms[k] for k in range(scene.ngeom)]
    along, across = (each for each in drawn if np.allclose(each.rgba[:3], rgb(SIGNALS["slope_estimate"].colour)))
    for line, slope in ((along, moment.slope_estimate), (across, moment.lateral_estimate)):
        axis = line.mat[:, 2]
        assert math.atan2(-axis[2], math.hypot(*axis[:2]) * (1.0 if axis @ (1.0, 1.0, 0.0) > 0 else -1.0)) == (
            pytest.approx(slope, abs=2e-3)
        )
    arrow = next(each for each in drawn if np.allclose(each.rgba[:3], rgb(FORCE_COLOUR)))
    assert np.abs(np.cross(arrow.mat[:, 2], moment.force)).max() < 1e-3 * robot.weight
    assert moment.force[2] == pytest.approx(robot.weight, rel=0.3)


def test_the_surface_is_the_terrain(in_space: Walk) -> None:
    scene = scene_of(in_space)
    scene.go_to(0.3)
    data = mujoco.MjData(scene.model)
    mujoco.mj_kinematics(scene.model, data)
    group = np.array([0, 0, 1, 0, 0, 0], dtype=np.uint8)  # what is seen
    for x, y in ((-2.03, 0.31), (0.11, -0.27), (0.33, 1.57), (2.77, -1.13)):
        geom, above = np.zeros(1, dtype=np.int32), np.array([x, y, 0.4 + in_space.terrain.height_at(x, y)])
        hit = mujoco.mj_ray(scene.model, data, above, np.array([0.0, 0.0, -1.0]), group, 1, -1, geom)
        assert hit == pytest.approx(0.4, abs=2e-3)


@needs_gl
@pytest.mark.parametrize("camera", ["track", "side", "overview"])
def test_frames(in_space: Walk, camera: str) -> None:
    shown = render_frame(in_space, 0.5, width=320, height=240, camera=camera)
    assert np.array_equal(shown, render_frame(in_space, 0.5, width=320, height=240, camera=camera))
    for element in ("torque", "force", "ghost", "estimate", "traces", "shadows", "scale", "caption", "chart"):
        changed = shown != render_frame(in_space, 0.5, width=320, height=240, camera=camera, hide=[element])
        assert changed.any(), element
