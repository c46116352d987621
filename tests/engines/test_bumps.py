"""Walks of robots in space on ground that is no plane."""

import numpy as np
import pytest

import mjbiped
from mjbiped.control.registry import make_controller

GROUNDS = {
    "bumps": mjbiped.Terrain.bumps(rms=0.005, seed=1, slope_deg=1.0),
    "lateral": mjbiped.Terrain.from_segments([(0.9, 0.0), (5.0, 1.0, 0.0, 2.0)]),
}


@pytest.mark.parametrize("name", GROUNDS)
@pytest.mark.parametrize("engine", ["hybrid", pytest.param("mujoco", marks=pytest.mark.slow)])
def test_a_walk_tells_where_its_feet_stand_and_how_the_ground_lies_there(name: str, engine: str) -> None:
    terrain, controller = GROUNDS[name], make_controller("adaptive", mjbiped.Compass3D(), {})
    walk = mjbiped.walk(controller, terrain, engine=engine, steps=5)
    assert walk.outcome == "finished"
    places = walk.touchdowns
    depth = 1e-12 if engine == "hybrid" else 2e-4  # of a foot in the step in which it touches the ground
    for x, y, z, slope, lateral in zip(*(places[c] for c in ("x", "y", "z", "slope", "lateral_slope")), strict=True):
        assert terrain.height_at(x, y) - depth <= z <= terrain.height_at(x, y) + 1e-6
        normal = terrain.normal_at(x, y)
        assert np.arctan2(normal[:2], normal[2]) == pytest.approx([slope, lateral], abs=2e-3)  # but for its heading
    assert np.ptp(places["lateral_slope"]) > 0.01
    for slope, estimate in (("slope", "slope_estimate"), ("lateral_slope", "lateral_estimate")):
        # (27) keeps the error that the tracking errors of the first steps leave in the estimate, 8e-4 rad
        assert places[estimate] == pytest.approx(places[slope], abs=1e-3)
    assert walk.terrain == terrain
