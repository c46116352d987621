"""What is drawn of an instant is what the record holds, or follows from it; and where MuJoCo draws a place."""

import dataclasses

import mujoco
import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped import Terrain, Walk
from mjbiped.rendering.gl import ensure_gl, gl_available
from mjbiped.rendering.overlay import View
from mjbiped.rendering.scene import Moments


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


def test_traces_end_at_the_feet_and_begin_two_seconds_ago(walk: Walk) -> None:
    moments = Moments(walk)
    for time in (0.0, 0.5, 4.0):
        moment = moments.at(time)
        for leg, trace in enumerate(moment.traces):
            assert trace[-1] == pytest.approx(walk.robot.limbs(moment.qpos)[leg, -1])
            before = moments.at(max(0.0, time - 2.0)).qpos
            assert np.hypot(*(trace[0] - walk.robot.limbs(before)[leg, -1])) < 0.05
            assert np.hypot(*np.diff(trace, axis=0).T).max(initial=0.0) < 0.06


SCENE = """
<mujoco><visual><headlight ambient="1 1 1"/></visual><worldbody>
  <camera name="tilted" pos="0.3 -5 1" xyaxes="1 0 0 0 0.1 1" fovy="25"/>
  <camera name="flat" pos="0.3 -5 0.4" xyaxes="1 0 0 0 0 1" projection="orthographic" fovy="2"/>
  <geom type="sphere" size="0.02" pos="-0.5 0.3 0.2" rgba="1 1 1 1"/>
</worldbody></mujoco>
"""


@pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")
@pytest.mark.parametrize("camera", ["tilted", "flat"])
def test_pixels_of_places(camera: str) -> None:
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    ensure_gl()
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 240, 320) as renderer:
        renderer.update_scene(data, camera)
        rows, columns = np.nonzero(renderer.render().max(axis=2) > 100)
        found = View.of(model, data, model.camera(camera).id, (320, 240)).pixel(-0.5, 0.3, 0.2)
    # pixels' middles are half a pixel from their corner; a ball off the axis looks a little oval
    assert found == pytest.approx((columns.mean() + 0.5, rows.mean() + 0.5), abs=0.6)


def test_no_ghost_where_nothing_is_tracked() -> None:
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine="hybrid", steps=1)
    moments = Moments(walk)
    assert moments.at(0.1).reference is None
    unknown = dataclasses.replace(walk, settings={**walk.settings, "controller": {"name": "Somebody's"}})
    assert Moments(unknown).at(0.1).reference is None
