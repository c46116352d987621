"""What is drawn of an instant is what the record holds, or follows from it; and where MuJoCo draws a place."""

import math
from typing import Any

import mujoco
import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped import Terrain, Walk, render_frame
from mjbiped.records.signals import SIGNALS
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.marks import FORCE_COLOUR, MOST_GEOMS, Scales
from mjbiped.rendering.scene import Moments
from mjbiped.rendering.space import draw_marks, moments_of, scene_of
from mjbiped.robots.in_space import InSpace
from mjbiped.utils.palette import rgb

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


@pytest.fixture(scope="module", params=["hybrid", "mujoco"])
def walk(request: pytest.FixtureRequest, controller: AdaptiveController) -> Walk:
    ground = Terrain.from_segments([(0.8, 0.0, 0.0), (9.0, 2.5, -0.02)])
    return mjbiped.walk(controller, ground, engine=request.param, steps=6, sample_period=1e-3)


def test_postures_are_interpolated_and_the_stance_foot_is_on_the_ground(walk: Walk) -> None:
    moments, times = Moments(walk), walk.samples["time"]
    for index in (0, 333, 2000, len(times) - 1):
        assert moments.at(float(times[index])).qpos == tuple(walk.samples["qpos"][index])
    between = 0.25 * times[333] + 0.75 * times[334]
    expected = 0.25 * walk.samples["qpos"][333] + 0.75 * walk.samples["qpos"][334]
    assert moments.at(float(between)).qpos == pytest.approx(expected, abs=1e-12)
    for time in np.linspace(0.0, times[-1], 50).tolist():
        moment = moments.at(time)
        x, z = walk.robot.limbs(moment.qpos)[moment.stance, -1].tolist()
        height, slope = moment.ground[moment.stance]
        assert height == walk.terrain.height_at(x)
        # between samples 1 ms apart the swing leg, and the foot that is put down, turn by up to 4 mrad
        assert z == pytest.approx(height, abs=1e-4)
        assert slope == pytest.approx(moment.slope, abs=1e-12) or abs(x - 0.8) < 1e-3
        assert moment.step == 1 + (walk.touchdowns["time"] < time - 1e-9).sum()


def test_the_ground_force_is_the_robot_s(walk: Walk) -> None:
    samples, moments = walk.samples, Moments(walk)
    for index in range(50, len(samples["time"]) - 50, 200):
        q, dq, torque, slope = (samples[name][index] for name in ("q", "dq", "torque", "slope"))
        force = walk.robot.ground_force(q, dq, torque, slope)
        assert moments.at(float(samples["time"][index])).force == pytest.approx(force, rel=1e-9)


def test_the_reference_is_what_the_controller_tracked(walk: Walk) -> None:
    """A closed loop: where it tracks well, the posture is the reference."""
    moments = Moments(walk)
    off = []
    for time in np.linspace(0.1, walk.samples["time"][-1], 60).tolist():
        moment = moments.at(time)
        assert moment.reference is not None
        off.append(max(abs(moment.reference[place] - moment.qpos[place]) for place in (2, 3)))
    assert np.median(off) < 2e-3  # rad
    assert max(off) < 0.2


# ---- robots in space -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", [mjbiped.Compass3D(), mjbiped.Kneed3D()])
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
    np.testing.assert_array_equal(robot.centre_of_mass(qpos), robot.centre_in_space(qpos)[[0, 2]])


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
    given: dict[str, Any] = {"time": 0.5, "width": 320, "height": 200, "camera": camera}  # too low for a chart
    shown = render_frame(in_space, **given)
    assert np.array_equal(shown, render_frame(in_space, **given))
    for element in ("torque", "force", "ghost", "estimate", "traces") if camera == "track" else ("shadows",):
        assert (shown != render_frame(in_space, hide=[element], **given)).any(), element
