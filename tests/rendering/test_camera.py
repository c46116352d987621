"""Where a place is in a picture is where MuJoCo draws it."""

import mujoco
import numpy as np
import pytest

from mjbiped.rendering.gl import ensure_gl, gl_available
from mjbiped.rendering.overlay import View

SCENE = """
<mujoco><visual><headlight ambient="1 1 1"/></visual><worldbody>
  <camera name="tilted" pos="0.3 -5 1" xyaxes="1 0 0 0 0.1 1" fovy="25"/>
  <camera name="flat" pos="0.3 -5 0.4" xyaxes="1 0 0 0 0 1" projection="orthographic" fovy="2"/>
  <geom type="sphere" size="0.02" pos="{x} {y} {z}" rgba="1 1 1 1"/>
</worldbody></mujoco>
"""


@pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")
@pytest.mark.parametrize("camera", ["tilted", "flat"])
@pytest.mark.parametrize("place", [(0.3, 0.0, 0.5), (-0.5, 0.3, 0.2), (1.0, -0.5, 0.8)])
def test_pixels_of_places(camera: str, place: tuple[float, float, float]) -> None:
    x, y, z = place
    model = mujoco.MjModel.from_xml_string(SCENE.format(x=x, y=y, z=z))
    data = mujoco.MjData(model)
    ensure_gl()
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 240, 320) as renderer:
        renderer.update_scene(data, camera)
        rows, columns = np.nonzero(renderer.render().max(axis=2) > 100)
        found = View.of(model, data, model.camera(camera).id, (320, 240)).pixel(*place)
    # pixels' middles are half a pixel from their corner; a ball off the axis looks a little oval
    assert found == pytest.approx((columns.mean() + 0.5, rows.mean() + 0.5), abs=0.6)
