"""Ground of robots in space: MuJoCo's pieces are where the terrain says."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from mjbiped.engines.mujoco.ground import FOOT_RADIUS, Ground
from mjbiped.terrain.terrain import Terrain

HALF_WIDTH = 6.0
GROUNDS = {
    "level": Terrain.level(lateral_deg=3.0),
    "incline": Terrain.incline(4.0, lateral_deg=-5.0),
    "stairs": Terrain.stairs(tread=0.7, rise=0.02, lateral_deg=2.0),
    "segments": Terrain.from_segments([(1.0, 0.0), (2.0, 3.0, 0.0, 4.0), (1.0, 3.0, 0.01, -2.0), (2.0, 0.0, 0.0, 1.0)]),
}


def found(terrain: Terrain, x: float, y: float, model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, float]:
    """Height of MuJoCo's ground at a place, m, as a ray finds it, raised to the terrain; and that of the terrain."""
    above = 50.0
    far = mujoco.mj_ray(model, data, [x, y, above], [0.0, 0.0, -1.0], None, True, -1, np.zeros(1, np.int32))
    return above - far + FOOT_RADIUS / terrain.normal_at(x, y)[2], terrain.height_at(x, y)


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("kind", ["auto", "boxes", "heightfield"])
def test_a_ray_finds_the_ground_where_the_terrain_is(name: str, kind: str) -> None:
    terrain = GROUNDS[name]
    spec = mujoco.MjSpec()
    spec.add_default("terrain", spec.default)
    ground = Ground(terrain, reach=20.0, kind=kind, half_width=HALF_WIDTH)
    ground.add_to(spec, ground.pieces)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    draw = np.random.default_rng(1)
    places = np.column_stack([draw.uniform(-1.0, 15.0, 300), draw.uniform(-5.5, 5.5, 300)])
    if kind == "boxes":  # a box that leans across ends ahead or behind
        places = places[[min(abs(np.subtract(terrain.x, x))) > 0.4 for x in places[:, 0]]]
    heights = np.array([found(terrain, *place, model, data) for place in places.tolist()])
    # a heightfield is of single precision: 6e-8 of its rise
    assert np.abs(heights[:, 0] - heights[:, 1]).max() < 6e-8 * max(1.0, np.ptp(heights[:, 1]) * 2.0)
