"""Tests of `mjbiped.terrain`, its segments and its files."""

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.engines.checks import check_ground
from mjbiped.errors import InputError
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.terrain.profile import HIGHEST_STEP, segment_near, segment_under
from mjbiped.terrain.shape import STEP_RESOLUTION
from mjbiped.terrain.terrain import Terrain, parse_terrain

STEPS = st.one_of(st.just(0.0), st.floats(-0.5, 0.5).filter(lambda s: abs(s) > 1e-6))
SEGMENTS = st.lists(st.tuples(st.floats(0.01, 20.0), st.floats(-38.0, 38.0), STEPS), min_size=1, max_size=12)
SLOPE = st.floats(-25.0, 25.0)
THREE = [(1.0, 2.0, 0.0), (2.0, -1.0, 0.01), (0.5, -3.0, 0.0)]


# ---- the profile ----------------------------------------------------------------------------------------------------


@given(SEGMENTS, st.floats(0.1, 0.9))
def test_segments_have_their_lengths_slopes_and_steps(rows: list[tuple[float, float, float]], part: float) -> None:
    """Along the ground; heights are continuous but for the rises, and slopes are minus their gradients."""
    terrain = Terrain.from_segments(rows)
    assert terrain.height(-10.0) == pytest.approx(rows[0][2] + 10.0 * math.tan(math.radians(rows[0][1])))
    # the first segment's step is the datum
    assert (terrain.x[0], terrain.z[0], terrain.rises[0], terrain.end) == (0.0, rows[0][2], 0.0, math.inf)
    for i, (length, slope, step) in enumerate(rows):
        start, stop = [*terrain.x, terrain.x[-1] + 5.0][i : i + 2]
        before = terrain.height_at(math.nextafter(start, -math.inf))
        assert terrain.height_at(start) == terrain.z[i]
        assert terrain.z[i] - before == pytest.approx(terrain.rises[i], abs=1e-11)
        assert terrain.heights_before[i] == pytest.approx(before, abs=1e-11)
        x, dx = start + part * (stop - start), 0.05 * (stop - start)
        gradient = (terrain.height(x + dx) - terrain.height(x - dx)) / (2 * dx)
        assert -math.tan(terrain.slope(x)) == pytest.approx(gradient, abs=1e-9)
        assert terrain.angle[i] == math.radians(slope)
        if i:
            assert terrain.rises[i] == pytest.approx(step, abs=1e-12)
            assert (terrain.rises[i] == 0.0) == (step == 0.0)
        if i + 1 < len(rows):
            along = math.hypot(stop - start, terrain.heights_before[i + 1] - terrain.z[i])
            assert along == pytest.approx(length, abs=1e-11)


def test_the_highest_step_is_allowed_whatever_the_rounding() -> None:
    terrain = Terrain.from_segments([(1.0, 1.25, -0.5), (1.0, 0.0, -HIGHEST_STEP)])
    assert terrain.rises[1] < -HIGHEST_STEP  # by rounding: the property test of the record found it
    assert Terrain.from_segments([(1.0, 38.6, 0.0), (1.0, -38.6, HIGHEST_STEP)]).rises[1] == HIGHEST_STEP


def test_rounding_is_no_step() -> None:
    terrain = Terrain((0.0, 1.0, 2.0), (0.0, STEP_RESOLUTION / 2, 1e-8), (0.0, 0.0, 0.0))
    assert terrain.rises[1] == 0.0
    assert terrain.rises[2] != 0.0
    assert list(terrain.stretches()) == [range(0, 2), range(2, 3)]


# ---- asking ---------------------------------------------------------------------------------------------------------


def test_a_segment_is_found_from_any_other() -> None:
    profile = Terrain.mixed().profile
    for x in (-5.0, 0.0, 2.0, 9.1, 30.0):
        assert {segment_near(profile, x, index) for index in range(14)} == {segment_under(profile, x)}


# ---- value, record --------------------------------------------------------------------------------------------------


# ---- by name, on the command line -----------------------------------------------------------------------------------


def test_text_on_the_command_line() -> None:
    assert parse_terrain("  level ") == Terrain.level()
    assert parse_terrain("stairs: tread = 2 , count=3") == Terrain.stairs(tread=2.0, count=3)
    ranges = parse_terrain("random:segment_length=.5..1.5,rise=-1e-2..0")
    assert ranges == Terrain.random(segment_length=(0.5, 1.5), rise=(-0.01, 0.0))
    assert "segment_length=0.5..1.5" in ranges.caption


# ---- files ----------------------------------------------------------------------------------------------------------


PIECES = st.tuples(st.floats(0.05, 3.0), st.floats(-0.03, 0.03), st.none() | st.floats(0.001, 0.4))


@settings(deadline=None)
@given(st.lists(PIECES, min_size=1, max_size=15), st.floats(0.0, 0.99), st.floats(-100, 100))
def test_sampled_profiles_are_kept_as_sampled(
    tmp_path_factory: pytest.TempPathFactory, pieces: list[tuple[float, float, Any]], start: float, datum: float
) -> None:
    rows = [(-start * pieces[0][0], datum)]
    for k, (dx, dz, step) in enumerate(pieces):
        rows.append((rows[-1][0] + dx, rows[-1][1] + dz))
        if step is not None and k < len(pieces) - 1:
            rows.append((rows[-1][0], rows[-1][1] - step))
    path = tmp_path_factory.mktemp("profile") / "ground.csv"
    path.write_text("".join(f"{x!r},{z!r}\n" for x, z in rows))
    terrain = Terrain.from_file(path)
    assert (terrain.end, terrain.name) == (rows[-1][0], "ground.csv")
    breaks = dict(rows[:-1])  # the later sample of a step counts
    assert dict(zip(terrain.x, terrain.z, strict=True)) == breaks
    assert terrain.height(rows[-1][0]) == pytest.approx(rows[-1][1], abs=1e-12)
    steps = [there[1] - here[1] for here, there in itertools.pairwise(rows) if there[0] == here[0]]
    assert [r for r in terrain.rises if r] == pytest.approx(steps, abs=1e-12)
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain
    assert parse_terrain(str(path)) == terrain


CSV = """# a survey
distance (m), elevation (m)

-1.0, 0.25   # behind the start
 0.5, 0.25
 0.5, 0.20
"2.0", 0.15
"""


@pytest.mark.parametrize("encode", [lambda t: t.encode("utf-8-sig"), lambda t: t.replace("\n", "\r\n").encode()])
def test_an_elevation_file(tmp_path: Path, encode: Any) -> None:
    path = tmp_path / "survey.CSV"
    path.write_bytes(encode(CSV))
    terrain = Terrain.from_file(str(path))
    assert (terrain.x, terrain.z, terrain.end) == ((-1.0, 0.5), (0.25, 0.20), 2.0)
    assert terrain.rises == pytest.approx((0.0, -0.05))
    assert terrain.angle == pytest.approx((0.0, math.atan2(0.05, 1.5)))
    assert terrain.height(5.0) < 0.15  # continued; the engines end the walk


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".toml", "segments = [[1, 2.0, 0], [2.0, -1.0, 0.01], [0.5, -3]]"),
        (".toml", "[[segments]]\nlength=1\nslope_deg=2\n[[segments]]\nlength=2\nslope_deg=-1\nstep=0.01\n"
                  "[[segments]]\nlength=0.5\nslope_deg=-3\n"),
        (".yaml", "segments: [[1, 2.0, 0], [2.0, -1.0, 1e-2], [0.5, -3]]"),
        (".yml", "segments:\n- {length: 1, slope_deg: 2}\n- {step: 0.01, slope_deg: -1, length: 2, lateral_deg: 0}\n"
                 "- [0.5, -3]\n"),
    ],
)  # fmt: skip
def test_segment_files(tmp_path: Path, suffix: str, text: str) -> None:
    path = tmp_path / f"mine{suffix}"
    path.write_text(text)
    assert Terrain.from_file(path) == Terrain.from_segments(THREE, name=f"mine{suffix}")


# ---- ground that falls to one side ----------------------------------------------------------------------------------


@given(SLOPE, SLOPE, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_plane_falls_forward_and_to_the_left(slope: float, lateral: float, x: float, y: float) -> None:
    terrain = parse_terrain(f"incline:slope_deg={slope!r},lateral_deg={lateral!r}")
    forward, left = math.tan(math.radians(slope)), math.tan(math.radians(lateral))
    assert terrain.height_at(x, y) == pytest.approx(-forward * x - left * y, abs=1e-12)
    normal = terrain.normal_at(x, y)
    assert normal == pytest.approx(np.array([forward, left, 1.0]) / math.hypot(forward, left, 1.0))
    assert terrain.is_profile == (left == 0.0)


def test_each_segment_has_its_own_lateral_slope(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("segments: [[1, 0], [1, 2, 0.01, -3], {length: 1, slope_deg: 0, lateral_deg: 4}]")
    terrain = Terrain.from_file(path)
    assert np.rad2deg(terrain.lateral) == pytest.approx([0.0, -3.0, 4.0])
    assert terrain.height_at(0.5, 2.0) == 0.0
    assert terrain.height_at(1.0, 2.0) == pytest.approx(0.01 + 2.0 * math.tan(math.radians(3.0)))
    assert terrain.height_at(9.0, -1.0) == pytest.approx(terrain.height_at(9.0) + math.tan(math.radians(4.0)))


@pytest.mark.parametrize("terrain", [Terrain.level(lateral_deg=1.0), Terrain.bumps()], ids=["lateral", "bumps"])
@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_planar_robots_are_told_which_robots_walk_there(kind: type[Robot], terrain: Terrain) -> None:
    if "hip_y" in kind().places:
        check_ground(kind(), terrain)
    else:
        with pytest.raises(InputError, match=r"moves in a plane and .*'(level|bumps)' .*mjbiped.Compass3D"):
            check_ground(kind(), terrain)
