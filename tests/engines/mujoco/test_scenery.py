"""The ground that pictures show is the terrain's, cut open, and nothing that a foot can touch."""

import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from simulations import build_scene

import mjbiped
from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.terrain.terrain import Terrain

TERRAINS = {
    "level": Terrain.level(),
    "slope": Terrain.incline(-3.0),
    "steep": Terrain.incline(38.0),
    "stairs": Terrain.stairs(rise=-0.06, count=3),
    "up and down": Terrain.from_segments([(1.0, 0.0, 0.0), (1.0, 5.0, 0.03), (1.0, -4.0, -0.05)]),
    "rough": Terrain.random(seed=3),
}
MESHES = ("surface", "stripe", "earth", "level_line", "profile_line")


def corners(model: mujoco.MjModel, name: str) -> NDArray[np.float64]:
    """Places of a mesh's corners, m, shape (n, 3); MuJoCo keeps them about the mesh's middle and in its own axes."""
    mesh, geom = model.mesh(name), model.geom(name)
    start, count = int(model.mesh_vertadr[mesh.id]), int(model.mesh_vertnum[mesh.id])
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, geom.quat)
    return np.asarray(model.mesh_vert[start : start + count] @ turn.reshape(3, 3).T + geom.pos, dtype=np.float64)


@pytest.mark.parametrize("name", TERRAINS)
def test_the_section_is_the_terrain_and_only_for_the_eye(name: str) -> None:
    terrain = TERRAINS[name]
    model = build_scene(mjbiped.Compass(), terrain, timestep=1e-4, reach=5.0, scenery=True).model
    for mesh in MESHES:
        geom = model.geom(mesh)
        assert not geom.contype[0]
        assert not geom.conaffinity[0]
        assert geom.group[0] == 2  # which MuJoCo shows, and not the group of what collides
    surface = corners(model, "surface")
    heights = np.array([[terrain.height_at(x - 1e-5), terrain.height_at(x + 1e-5)] for x in surface[:, 0]])
    # MuJoCo keeps meshes in single precision: 1e-7 of a size of 30 m
    steepness = max(1.0, max(abs(gradient) for gradient in terrain.gradients))
    assert np.abs(heights - surface[:, 2:]).min(axis=1).max() < 3e-5 * steepness**2
    earth = corners(model, "earth")
    assert np.allclose(earth[:, 1], -CUT, atol=1e-4)
    lines = corners(model, "level_line")  # level, and under the ground
    assert len(lines) > 8
    over = lines[:, 2] - np.array([max(terrain.height_at(x - 1e-4), terrain.height_at(x + 1e-4)) for x in lines[:, 0]])
    assert over.max() < 3e-4 * steepness**2  # single precision, and the places asked for lie 1e-4 m apart
    pitch = 10.0 ** round(math.log10(0.1))
    upper = lines[: len(lines) // 2, 2] / pitch  # upper corners come first
    assert np.abs(upper - np.round(upper)).max() < 1e-3 * steepness
