"""The scene against the terrain and the robot it was built from, and the ground that pictures show."""

import math

import mujoco
import numpy as np
import pytest
from simulations import build_scene

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.options import GROUND_KINDS
from mjbiped.engines.mujoco.scene import Scene
from mjbiped.errors import InputError
from mjbiped.robots.robot import Robot

TERRAINS = {
    "level": mjbiped.Terrain.level(),
    "incline": mjbiped.Terrain.incline(-3.0),
    "slopes": mjbiped.Terrain.slopes(change_deg=-1.0),
    "stairs": mjbiped.Terrain.stairs(),
    "mixed": mjbiped.Terrain.mixed(),
    "rough": mjbiped.Terrain.random(seed=3, roughness=0.004),
}


def scene_of(terrain: mjbiped.Terrain, ground: str = "auto", robot: mjbiped.Compass | None = None) -> Scene:
    return build_scene(robot or mjbiped.Compass(), terrain, timestep=1e-4, reach=20.0, ground=ground)


def ground_below(scene: Scene, data: mujoco.MjData, x: float) -> float:
    """Height at which a vertical ray meets what the feet collide with, m."""
    hit = np.zeros(1, dtype=np.int32)
    groups = np.array([0, 0, 0, 1, 0, 0], dtype=np.uint8)  # what collides, and nothing that is only seen
    start = 10.0
    distance = mujoco.mj_ray(scene.model, data, [x, 0.0, start], [0.0, 0.0, -1.0], groups, 1, -1, hit, None)
    assert distance >= 0.0, f"no ground under x = {x}"
    return float(start - distance)


@pytest.mark.parametrize("ground", GROUND_KINDS)
@pytest.mark.parametrize("name", TERRAINS)
def test_surface_is_the_profile_offset_by_the_foot(name: str, ground: str) -> None:
    terrain = TERRAINS[name]
    scene = scene_of(terrain, ground)
    data = mujoco.MjData(scene.model)
    mujoco.mj_forward(scene.model, data)
    for x in np.linspace(-2.0, 19.9, 251) + 1e-3:
        if min(abs(x - start) for start in terrain.x) < 0.01:
            continue  # risers stand 0.3 mm before the step, and are lowered
        expected = terrain.height(x) - FOOT_RADIUS / math.cos(terrain.slope(x))
        # boxes: rounding of a ray of 10 m. Heightfields: float32 heights of a range of some metres (6e-8 of it),
        # and the mean offset of two segments at a node, r |1/cos - 1/cos'| / 2 < 5e-8 m for the slopes here
        tolerance = 1e-12 if ground == "boxes" else 5e-7
        assert ground_below(scene, data, x) == pytest.approx(expected, abs=tolerance)


def test_auto_chooses_plane_boxes_and_heightfields() -> None:
    kinds = {}
    for name, terrain in TERRAINS.items():
        model = scene_of(terrain).model
        kinds[name] = {mujoco.mjtGeom(int(kind)).name for kind in model.geom_type[model.geom_bodyid == 0]}
    assert kinds["level"] == kinds["incline"] == {"mjGEOM_PLANE"}
    assert kinds["slopes"] == {"mjGEOM_HFIELD"}
    assert kinds["stairs"] == {"mjGEOM_BOX"}
    assert kinds["mixed"] == {"mjGEOM_BOX", "mjGEOM_HFIELD"}


def test_risers_are_frictionless_and_foremost() -> None:
    terrain = mjbiped.Terrain.from_segments([(2.0, 0.0, 0.0), (2.0, 0.0, 0.03), (2.0, 0.0, -0.03)])
    model = scene_of(terrain).model
    up, down = model.geom("riser_1"), model.geom("riser_2")
    for riser in (up, down):
        assert (riser.condim, riser.priority, riser.pos[2] + riser.size[2]) == (1, 2, pytest.approx(0.03))
    # the end of the leg, a foot's radius before the plate, meets it at the step's face
    assert up.pos[0] - up.size[0] == pytest.approx(2.0 + FOOT_RADIUS)
    assert down.pos[0] + down.size[0] == pytest.approx(4.0 - FOOT_RADIUS)


LIGHT: list[tuple[Robot, str]] = [
    (mjbiped.Compass(leg_mass=1e-9), "leg_mass = 1e-09, hip_mass = 0, .*has 2e-16 kg or kg m.2 for the hip"),
    (mjbiped.Compass(leg_mass=1e-6, leg_inertia=0.0), "leg_inertia = 0: .*has 2e-16 kg or kg m.2 for the leg"),
    (mjbiped.KneedBiped(shank_mass=1e-9, shank_inertia=0.0), "shank_mass = 1e-09, .*for the shank"),
    (mjbiped.FootedCompass(foot_mass=1e-9, sole=(1e-4, 1e-4)), "foot_mass = 1e-09: .*for the foot"),
    (mjbiped.RimlessWheel(mass=1e-9), "mass = 1e-09, .*for the rod"),
]


@pytest.mark.parametrize(("robot", "message"), LIGHT)
def test_bodies_that_mujoco_takes_for_massless_are_refused_by_the_parameters_names(robot: Robot, message: str) -> None:
    with pytest.raises(InputError, match=f"{message}.*engine='hybrid'"):
        mjbiped.walk(Unpowered(), TERRAINS["level"], robot=robot, initial=[0.0] * (2 * len(robot.angles)))
