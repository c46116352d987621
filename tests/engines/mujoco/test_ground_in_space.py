"""Ground of robots in space: MuJoCo's pieces are where the terrain says."""

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import FOOT_RADIUS, Ground
from mjbiped.terrain.surface import Surface
from mjbiped.terrain.terrain import Terrain

HALF_WIDTH = 6.0
GROUNDS = {
    "level": Terrain.level(lateral_deg=3.0),
    "incline": Terrain.incline(4.0, lateral_deg=-5.0),
    "stairs": Terrain.stairs(tread=0.7, rise=0.02, lateral_deg=2.0),
    "turning": Terrain.from_segments([(1.0, 1.0, 0.0, lateral) for lateral in (2.0, 2.0, -2.0, -2.0, 0.0)]),
    "segments": Terrain.from_segments([(1.0, 0.0), (2.0, 3.0, 0.0, 4.0), (1.0, 3.0, 0.01, -2.0), (2.0, 0.0, 0.0, 1.0)]),
}


SURFACES = {
    "bumps": Terrain.bumps(seed=3, slope_deg=2.0, lateral_deg=-3.0, length=10.0),
    "grid": Terrain(
        (-1.0,), (0.1,), (0.02,),
        surface=Surface(-1.0, -1.5, 0.5, 0.1 * np.random.default_rng(0).uniform(size=(7, 13))),
    ),
}  # fmt: skip


def built(terrain: Terrain, kind: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    spec = mujoco.MjSpec()
    spec.add_default("terrain", spec.default)
    ground = Ground(terrain, reach=20.0, kind=kind, half_width=HALF_WIDTH)
    ground.add_to(spec, ground.pieces)
    foot = spec.worldbody.add_body(name="foot")
    foot.add_freejoint()
    foot.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[FOOT_RADIUS, 0.0, 0.0], mass=1.0, group=1)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def places(count: int, reach: float = 15.0) -> NDArray[np.float64]:
    draw = np.random.default_rng(1)
    return np.column_stack([draw.uniform(-1.5, reach, count), draw.uniform(-5.5, 5.5, count)])


def differences(terrain: Terrain, at: NDArray[np.float64], kind: str = "auto") -> NDArray[np.float64]:
    """Heights of MuJoCo's ground, as rays find it, over those of the terrain lowered by the foot's radius, m."""
    model, data = built(terrain, kind)
    above, found, groups = 50.0, np.zeros(1, np.int32), np.array([1, 0, 0, 0, 0, 0])
    down = np.array([0.0, 0.0, -1.0])
    far = [mujoco.mj_ray(model, data, [x, y, above], down, groups, True, -1, found) for x, y in at]
    wanted = [terrain.height_at(x, y) - FOOT_RADIUS / terrain.normal_at(x, y)[2] for x, y in at.tolist()]
    return np.asarray(above - np.array(far) - np.array(wanted))


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("kind", ["auto", "boxes", "heightfield"])
def test_a_ray_finds_the_ground_where_the_terrain_is(name: str, kind: str) -> None:
    terrain, at = GROUNDS[name], places(300)
    if kind == "boxes":  # a box that leans across ends ahead or behind
        at = at[[min(abs(np.subtract(terrain.x, x))) > 0.4 for x in at[:, 0]]]
    # a heightfield is of single precision: 6e-8 of its rise
    assert np.abs(differences(terrain, at, kind)).max() < 1e-7


def spread(terrain: Terrain, at: NDArray[np.float64]) -> float:
    """Errors of single precision and of lowering triangles by a foot's radius, for which corners have one height, m."""
    return 1e-7 + FOOT_RADIUS * float(np.ptp([1.0 / terrain.normal_at(x, y)[2] for x, y in at.tolist()]))


@pytest.mark.parametrize("name", SURFACES)
def test_a_ray_finds_the_triangles_of_a_surface_and_what_is_beyond(name: str) -> None:
    terrain, at = SURFACES[name], places(1000)
    assert np.abs(differences(terrain, at)).max() < spread(terrain, at) < 2e-6


@pytest.mark.parametrize("name", SURFACES)
def test_a_foot_within_a_triangle_touches_it_at_its_height_and_along_its_normal(name: str) -> None:
    terrain, at = SURFACES[name], places(300)
    model, data = built(terrain, "auto")
    touched, near = 0, spread(terrain, at)
    for x, y in at.tolist():
        normal = terrain.normal_at(x, y)
        data.qpos[:3] = np.array([x, y, terrain.height_at(x, y)]) - 0.5 * FOOT_RADIUS * normal
        mujoco.mj_forward(model, data)
        around = [terrain.normal_at(x + dx, y + dy) for dx in (-3e-4, 3e-4) for dy in (-3e-4, 3e-4)]
        if any((each != normal).any() for each in around):  # near a line of the grid
            continue
        contact = data.contact[0]
        assert data.ncon == 1
        assert contact.dist == pytest.approx(-0.5 * FOOT_RADIUS, abs=near)
        assert np.abs(contact.frame[:3]) == pytest.approx(np.abs(normal), abs=2e-5)
        touched += 1
    assert touched > 250
