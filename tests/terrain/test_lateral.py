"""Ground that falls to one side."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.engines.checks import check_ground
from mjbiped.errors import InputError
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain, parse_terrain

SLOPE = st.floats(-25.0, 25.0)


@given(SLOPE, SLOPE, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_plane_falls_forward_and_to_the_left(slope: float, lateral: float, x: float, y: float) -> None:
    terrain = parse_terrain(f"incline:slope_deg={slope!r},lateral_deg={lateral!r}")
    forward, left = math.tan(math.radians(slope)), math.tan(math.radians(lateral))
    assert terrain.height_at(x, y) == pytest.approx(-forward * x - left * y, abs=1e-12)
    normal = terrain.normal_at(x, y)
    assert normal == pytest.approx(np.array([forward, left, 1.0]) / math.hypot(forward, left, 1.0))
    assert terrain.is_profile == (left == 0.0)


def test_each_segment_has_its_own_lateral_slope(tmp_path: Path) -> None:
    rows = [(1.0, 0.0), (1.0, 2.0, 0.01, -3.0), (1.0, 0.0, 0.0, 4.0)]
    terrain = Terrain.from_segments(rows)
    assert np.rad2deg(terrain.lateral) == pytest.approx([0.0, -3.0, 4.0])
    assert terrain.height_at(0.5, 2.0) == 0.0
    assert terrain.height_at(1.0, 2.0) == pytest.approx(0.01 + 2.0 * math.tan(math.radians(3.0)))
    assert terrain.height_at(9.0, -1.0) == pytest.approx(terrain.height_at(9.0) + math.tan(math.radians(4.0)))
    path = tmp_path / "mine.toml"
    path.write_text(
        "[[segments]]\nlength=1\nslope_deg=0\n[[segments]]\nlength=1\nslope_deg=2\nstep=0.01\nlateral_deg=-3\n"
        "[[segments]]\nlength=1\nslope_deg=0\nlateral_deg=4\n"
    )
    assert Terrain.from_file(path) == Terrain.from_segments(rows, name="mine.toml")


@pytest.mark.parametrize("name", ["level", "incline", "stairs", "slopes"])
def test_presets_fall_to_one_side_everywhere_and_into_the_record(name: str) -> None:
    terrain, level = parse_terrain(f"{name}:lateral_deg=3"), Terrain.preset(name)
    assert terrain.caption.replace(", ", "(").endswith("(lateral_deg=3.0)")
    assert terrain.lateral == (math.radians(3.0),) * len(level.x)
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain
    assert Terrain.preset(name, lateral_deg=0.0) == level
    assert "lateral" not in level.to_dict()  # records of profiles are as they have always been


@pytest.mark.parametrize("terrain", [Terrain.level(lateral_deg=1.0), Terrain.bumps()], ids=["lateral", "bumps"])
@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_planar_robots_are_told_which_robots_walk_there(kind: type[Robot], terrain: Terrain) -> None:
    if "hip_y" in kind().places:
        check_ground(kind(), terrain)
    else:
        with pytest.raises(InputError, match=r"moves in a plane and .*'(level|bumps)' .*mjbiped.Compass3D"):
            check_ground(kind(), terrain)
