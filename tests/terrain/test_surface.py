"""Ground with a surface: its triangles, bumps, surveyed grids and records."""

import dataclasses
import itertools
import json
import math
import pickle
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.errors import InputError
from mjbiped.terrain.surface import MOST_HEIGHTS, RESOLUTION, Surface
from mjbiped.terrain.terrain import Terrain, parse_terrain

RANDOM = 0.05 * np.random.default_rng(5).uniform(size=(4, 6))
GRID = Surface(-1.0, -0.8, 0.5, RANDOM)
FALLING = Surface(-1.0, -1.0, 1.0, np.array([[0.0] * 3, [-0.6] * 3, [-1.2] * 3]))
GROUND = Terrain((0.0,), (0.3,), (0.05,), lateral=(-0.04,), surface=GRID)

# ---- triangles ------------------------------------------------------------------------------------------------------


def test_the_grid_has_its_heights_at_its_places_and_its_edges_heights_beyond() -> None:
    for row, column in itertools.product(range(4), range(6)):
        assert GRID.height_at(-1.0 + 0.5 * column, -0.8 + 0.5 * row) == pytest.approx(RANDOM[row, column], abs=1e-16)
    assert GRID.height_at(9.0, 3.0) == pytest.approx(RANDOM[-1, -1])
    assert GRID.height_at(-9.0, -0.55) == pytest.approx(RANDOM[:2, 0].mean())
    assert GRID.ends == pytest.approx((1.5, 0.7))
    assert math.isnan(GRID.height_at(math.nan, 0.0))


@given(st.integers(0, 2), st.integers(0, 4), st.floats(0.01, 0.98), st.floats(0.01, 0.98))
def test_a_cell_is_two_planes_about_its_diagonal_forward_and_left(row: int, column: int, u: float, v: float) -> None:
    (a, b), (c, d) = RANDOM[row : row + 2, column : column + 2]
    corners = [(0.0, 0.0, a), (1.0, 0.0, b), (1.0, 1.0, d)] if u >= v else [(0.0, 0.0, a), (0.0, 1.0, c), (1.0, 1.0, d)]
    plane = np.linalg.solve([[x, y, 1.0] for x, y, _ in corners], [z for *_, z in corners])
    x, y = -1.0 + 0.5 * (column + u), -0.8 + 0.5 * (row + v)
    assert GRID.height_at(x, y) == pytest.approx(plane @ [u, v, 1.0], abs=1e-15)
    if abs(u - v) > 1e-9:
        assert GRID.gradient_at(x, y) == pytest.approx(plane[:2] / 0.5, abs=1e-14)


@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_normals_are_square_to_the_ground_everywhere(x: float, y: float) -> None:
    tiny = 1e-7
    ahead, left = (GROUND.height_at(x + dx, y + dy) - GROUND.height_at(x, y) for dx, dy in ((tiny, 0.0), (0.0, tiny)))
    normal = GROUND.normal_at(x, y)
    if (GROUND.normal_at(x + tiny, y) == normal).all() and (GROUND.normal_at(x, y + tiny) == normal).all():
        assert (-normal[0] / normal[2], -normal[1] / normal[2]) == pytest.approx((ahead / tiny, left / tiny), abs=1e-7)
    assert np.linalg.norm(normal) == pytest.approx(1.0)


def test_the_profile_lies_under_the_surface_and_is_drawn_with_it() -> None:
    x, y = 0.7, -1.3
    plane = 0.3 - math.tan(0.05) * x + math.tan(0.04) * y
    assert GROUND.height_at(x, y) == pytest.approx(plane + GRID.height_at(x, y))
    places, heights = GROUND.outline(-1.5, 2.0)
    between = np.linspace(-1.5, 2.0, 301)
    assert np.interp(between, places, heights) == pytest.approx(GROUND.height(between), abs=1e-12)
    slope = math.atan2(GROUND.height(0.2) - GROUND.height(0.21), 0.01)
    assert GROUND.slope_at(0.2) == pytest.approx(slope)


def test_the_steepest_triangle_is_found() -> None:
    heights = np.zeros((5, 5))
    heights[2, 3] = 0.2
    angle, x, y = Surface(0.0, 0.0, 0.5, heights).steepest(0.1, -0.1)
    assert math.tan(angle) == pytest.approx(math.hypot(0.4 + 0.1, 0.4 + 0.1))
    assert (x, y) == (1.0, 1.0)


# ---- bumps ----------------------------------------------------------------------------------------------------------


def test_bumps_have_the_named_height_and_wave_lengths_and_begin_level() -> None:
    terrain = Terrain.bumps(seed=4, rms=0.01, shortest=0.5, longest=3.0, length=200.0)
    assert terrain.surface is not None
    heights, start = terrain.surface.heights, round(2.0 / 0.05)
    assert not heights[:, : start + 7].any()
    grown = heights[:, start + 17 :]
    assert grown.std() == pytest.approx(0.01, rel=0.05)
    power = np.abs(np.fft.fft2(grown * np.outer(np.hanning(grown.shape[0]), np.hanning(grown.shape[1])))) ** 2
    numbers = np.hypot.outer(*(np.fft.fftfreq(count, 0.05) for count in grown.shape))
    assert power[(numbers > 1.0 / 5.0) & (numbers < 1.0 / 0.45)].sum() / power[numbers > 0.0].sum() > 0.9
    along, across = (np.diff(grown, axis=axis).std() for axis in (1, 0))
    assert along == pytest.approx(across, rel=0.3)  # waves in all directions


def test_a_seed_gives_the_same_bumps_on_every_plane_and_others_than_another_seed() -> None:
    level, tilted = Terrain.bumps(seed=1), parse_terrain("bumps:seed=1,slope_deg=2,lateral_deg=-3")
    assert level.surface == tilted.surface != Terrain.bumps(seed=2).surface
    assert (tilted.angle, tilted.lateral) == ((math.radians(2.0),), (math.radians(-3.0),))
    assert not (level.surface.heights / RESOLUTION % 1.0).any()  # type: ignore[union-attr]


# ---- surveyed grids -------------------------------------------------------------------------------------------------

ASC = """ncols 4
NROWS 3
xllcorner -1.5
yllcorner -1
cellsize 0.5
NODATA_value -9999
0.01 0.02 0.03 0.04

0.05 0.06 0.07 0.08
0.09 0.1 0.11 1.2e-1
"""


@pytest.mark.parametrize("header", ["corner", "center"])
def test_a_surveyed_grid(tmp_path: Path, header: str) -> None:
    text = ASC.replace("xllcorner -1.5", "xllcenter -1.25").replace("yllcorner -1", "yllcenter -0.75")
    path = tmp_path / "survey.ASC"
    path.write_text(ASC if header == "corner" else text)
    terrain = parse_terrain(str(path))
    heights = np.array([[0.09, 0.1, 0.11, 0.12], [0.05, 0.06, 0.07, 0.08], [0.01, 0.02, 0.03, 0.04]])
    assert terrain.surface == Surface(-1.25, -0.75, 0.5, heights)
    assert (terrain.name, terrain.end, terrain.x) == ("survey.ASC", 0.25, (-1.25,))
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("ncols 4", ""), "ncols = 'missing'"),
        (("xllcorner -1.5", ""), "neither xllcorner nor xllcenter"),
        (("0.05 0.06", "0.05"), "line 9: 3 heights; the header says ncols 4"),
        (("NROWS 3", "NROWS 4"), "3 rows of heights; the header says 4"),
        (("0.07", "-9999.0"), "line 9, height 3 of 4, is -9999.0, which stands for no data .*fill it"),
        (("xllcorner -1.5", "xllcorner 512345"), "from x = 512345.25 to .*subtract the start's x from xllco"),
        (("yllcorner -1", "yllcorner 2"), "from y = 2.25 to .*subtract the start's y"),
        (("0.07", "1.7"), "at x = .* m: a slope of .* degrees is steeper"),
    ],
)
def test_a_spoilt_grid_is_refused_in_words(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "bad.asc"
    assert change[0] in ASC
    path.write_text(ASC.replace(*change))
    with pytest.raises(InputError, match=f"terrain file .*bad.asc: .*{message}"):
        Terrain.from_file(path)


# ---- value, record --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("terrain", [GROUND, Terrain.bumps(seed=7, lateral_deg=1.0)], ids=["grid", "bumps"])
def test_the_record_and_a_pickle_give_back_the_surface_bit_by_bit(terrain: Terrain) -> None:
    text, surface = json.dumps(terrain.to_dict(), allow_nan=False), terrain.surface
    assert surface is not None
    for again in (Terrain.from_dict(json.loads(text)), pickle.loads(pickle.dumps(terrain))):
        assert again == terrain
        assert hash(again) == hash(terrain)
        assert again.surface == surface
    assert len(text) < 1000  # bumps are remembered by what made them
    other = dataclasses.replace(terrain, surface=dataclasses.replace(surface, y0=-0.51))
    assert other != terrain
    assert Terrain.from_dict(other.to_dict()) == other


SUITS_NOT: list[tuple[dict[str, Any], str]] = [
    ({"lateral": (0.3,), "surface": FALLING}, "at x = .* m: a slope of 4.* degrees is steeper"),
    ({"x": (0.0, 1.0), "z": (0.0, 0.0), "angle": (0.0, 0.0), "lateral": ()}, "on a single segment.* has 2"),
    ({"surface": Surface(1.0, -1.0, 0.5, RANDOM)}, "from x = 1 to 3.5 m.*the robot starts at x = 0"),
    ({"surface": Surface(-1.0, 1.0, 0.5, RANDOM)}, "from y = 1 to .*the robot starts at x = 0, y = 0"),
]
SPOILT = [{"x0": 0.0}, 5, {"waves": {"seed": 1}}, {**GRID.to_dict(), "shape": [3, 6]}]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        *((partial(dataclasses.replace, GROUND, **fields), message) for fields, message in SUITS_NOT),
        *(
            (partial(Terrain.from_dict, {**GROUND.to_dict(), "surface": spoilt}), r"surface = .*is not what")
            for spoilt in SPOILT
        ),
        (lambda: Surface(0.0, 0.0, 0.1, [[0.0, 1.0]]), "1 x 2 heights: must have two rows"),  # type: ignore[arg-type]
        (lambda: Surface(0.0, 0.0, 0.1, np.zeros((2, MOST_HEIGHTS))), "heights at most"),
        (lambda: Surface(0.0, 0.0, 0.0, RANDOM), "spacing = 0.0"),
        (lambda: Surface(0.0, 0.0, 0.1, [[0.0, math.nan], [0.0, 0.0]]), "heights: nan in it"),  # type: ignore[arg-type]
        (lambda: Terrain.bumps(rms=0.05), "steeper than the robot can stand on"),
        (lambda: Terrain.bumps(shortest=0.1), "at least 0.2 m, four times"),
        (lambda: Terrain.bumps(length=1000.0), "bumps of more than .* have too many heights"),
        (lambda: Terrain.recorded(GROUND), "goes on without end"),
        (lambda: Terrain.recorded(dataclasses.replace(GROUND, end=9.0)), "is ground in space"),
    ],
)
def test_what_no_surface_can_be_is_refused(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
