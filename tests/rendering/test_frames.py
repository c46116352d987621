"""Pictures of a walk show the recorded posture, the ground and what explains them."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from mjbiped.records.record import Walk
from mjbiped.rendering import ELEMENTS, look
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.video import render_frame

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


def shares_of_legs(frame: Pixels) -> np.ndarray:
    """Shares of the frame that are as blue as the left leg and as orange as the right one."""
    red, _, blue = np.moveaxis(frame.astype(int), -1, 0)
    saturated = np.ptp(frame.astype(int), axis=-1) > 60
    return np.array([(saturated & (one > 2 * other)).mean() for one, other in ((blue, red), (red, blue))])


@needs_gl
@pytest.mark.parametrize("camera", ["track", "side", "overview"])
def test_every_camera_has_the_robot_and_the_ground_in_view_until_the_end(walk: Walk, camera: str) -> None:
    for frame in render_frame(walk, [0.0, walk.end[0]], width=160, height=120, camera=camera, hide="all"):
        assert (shares_of_legs(frame) > 0.0005).all()
        below, above = frame[110].astype(int), frame[4].astype(int)
        assert (below[:, 0] > below[:, 2] + 10).mean() > 0.9  # ground is brownish, the sky a pale blue
        assert (above[:, 2] >= above[:, 0]).mean() > 0.9


@needs_gl
def test_a_frame_depends_on_the_record_alone(adaptive: Walk) -> None:
    """Whatever was drawn before."""
    early, late = (render_frame(adaptive, time, width=320, height=260) for time in (0.1, 0.5))
    assert not np.array_equal(early, late)
    assert np.array_equal(render_frame(adaptive, [[0.5], [0.1]], width=320, height=260), [[late], [early]])


# where in a picture of 480 x 360 with a chart of 97 rows an element is seen, as (rows, columns)
REGIONS = {
    "torque": (slice(0, 263), slice(100, 330)),
    "force": (slice(150, 263), slice(100, 330)),
    "ghost": (slice(0, 240), slice(100, 330)),
    "estimate": (slice(150, 263), slice(50, 400)),
    "traces": (slice(150, 263), slice(0, 330)),
    "shadows": (slice(150, 263), slice(100, 330)),
    "scale": (slice(30, 110), slice(0, 110)),
    "labels": (slice(230, 263), slice(0, 480)),
    "caption": (slice(0, 110), slice(0, 480)),
    "chart": (slice(263, 360), slice(0, 480)),
}


@needs_gl
def test_each_element_is_seen_where_it_belongs_and_can_be_hidden(adaptive: Walk) -> None:
    time = float(adaptive.touchdowns["time"][2]) + 0.15  # in the haste after a step
    shown = render_frame(adaptive, time, width=480, height=360)
    assert (shown[-97:] == 255).all(axis=2).mean() > 0.6  # paper
    assert [*REGIONS] == [*ELEMENTS]
    for element, region in REGIONS.items():
        changed = (shown != render_frame(adaptive, time, width=480, height=360, hide=[element])).any(axis=2)
        assert changed[region].sum() > 30, element
        if element == "chart":
            continue  # whose room the picture takes
        if element in ("scale", "caption"):
            changed[:110] = False  # without a caption the scale moves up
        changed[region] = False
        if element in ("torque", "force", "ghost", "estimate"):
            changed[:110, 300:] = False  # its line in the legend
        assert not changed.any(), element
    low = render_frame(adaptive, time, width=480, height=200)
    assert (low[-20:] == 255).all(axis=2).mean() < 0.1  # there is no room for a chart


@needs_gl
def test_visual_flags_of_mujoco(adaptive: Walk) -> None:
    time, size = float(adaptive.touchdowns["time"][2]) + 0.3, {"width": 320, "height": 200, "hide": "all"}
    plain = render_frame(adaptive, time, **size)  # type: ignore[arg-type]
    for flag in ("contactpoint", "contactforce", "com", "wireframe", "skybox", "no-shadow", "no-static"):
        flagged = render_frame(adaptive, time, flags=[flag], **size)  # type: ignore[arg-type]
        assert (flagged != plain).any(axis=2).sum() > 20, flag


def test_elements_and_flags_by_name() -> None:
    assert look().elements == {*ELEMENTS}
    assert look(["ghost", "chart, force"]).elements == {*ELEMENTS} - {"ghost", "chart", "force"}
    assert look("all").elements == set()
    chosen = look(flags=["contactpoint", "no-static,WIREFRAME"])
    assert chosen.visual == {mujoco.mjtVisFlag.mjVIS_CONTACTPOINT: True, mujoco.mjtVisFlag.mjVIS_STATIC: False}
    assert chosen.rendering == {mujoco.mjtRndFlag.mjRND_WIREFRAME: True}
