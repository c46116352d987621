"""Terrains that have a name: their ground, their parameters, and what these may be."""

import json
import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mjbiped.terrain.presets import PRESETS
from mjbiped.terrain.terrain import Terrain, parse_terrain


@pytest.mark.parametrize(
    ("name", "lateral"),
    [
        *((name, {}) for name in PRESETS if name != "recorded"),  # that one needs a file
        *((name, {"lateral_deg": 3.0}) for name in ("level", "incline", "stairs", "slopes", "bumps")),
    ],
)
def test_every_preset_goes_on_far_enough_and_into_the_record(name: str, lateral: dict[str, float]) -> None:
    terrain = Terrain.preset(name, **lateral)
    assert terrain.name == name
    assert {round(math.degrees(angle), 12) for angle in terrain.lateral} == set(lateral.values())
    assert lateral or "lateral" not in terrain.to_dict()  # records of profiles are as they have always been
    assert terrain.end == math.inf
    assert terrain.x[0] == 0.0
    assert len(terrain.x) == 1 or terrain.x[-1] > 23.0  # 60 steps of 0.38 m
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain
    assert pickle.loads(pickle.dumps(terrain)) == terrain
    assert Terrain.preset(name, **lateral) == terrain
    assert terrain.caption.startswith(name)


def test_stairs_are_the_papers() -> None:
    terrain = Terrain.stairs(tread=1.8, rise=-0.06)
    assert terrain.x[1:3] == (0.9, 0.9 + 1.8)
    assert len(terrain.x) == 21
    assert np.diff(terrain.x[1:]) == pytest.approx([1.8] * 19)
    assert terrain.rises[1:] == pytest.approx([-0.06] * 20)
    assert set(terrain.angle) == {0.0}
    assert Terrain.stairs(first=0.5, count=1).x == (0.0, 0.5)


def test_slopes_change_by_the_same_angle() -> None:
    terrain = Terrain.slopes(length=1.5, change_deg=-1.0, count=5, start_deg=2.0)
    assert np.rad2deg(terrain.angle) == pytest.approx([2.0, 1.0, 0.0, -1.0, -2.0, -3.0])
    assert np.diff(terrain.x) / np.cos(terrain.angle[:-1]) == pytest.approx([1.5] * 5)
    assert len(list(terrain.stretches())) == 1


def test_mixed_is_the_table_in_its_docstring() -> None:
    table = re.findall(r"\| +(\d+) +\| +(\S+) +\| +(\S+) +\| +(\S+) +\|", Terrain.mixed.__doc__ or "")
    rows = [(float(length), float(slope), 0.0 if step == "-" else float(step)) for _, length, slope, step in table]
    assert [int(k) for k, *_ in table] == list(range(1, 15))
    terrain = Terrain.mixed()
    given_in_full = Terrain.from_segments(rows)
    assert (terrain.x, terrain.z, terrain.angle) == (given_in_full.x, given_in_full.z, given_in_full.angle)
    assert f"{sum(length for length, *_ in rows):.1f} m long" in (Terrain.mixed.__doc__ or "")


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32))
def test_random_ground_keeps_its_ranges(seed: int) -> None:
    terrain = Terrain.random(
        seed, length=30.0, segment_length=(0.5, 1.0), slope_deg=(-2.0, 4.0), rise=(-0.03, 0.01), step_probability=0.7
    )
    lengths = np.diff(terrain.x) / np.cos(terrain.angle[:-1])
    assert lengths[0] == pytest.approx(1.0)
    assert terrain.angle[0] == 0.0
    assert lengths[1:].min() >= 0.5 - 1e-9
    assert lengths[1:].max() <= 1.0 + 1e-9
    assert math.radians(-2.0) <= min(terrain.angle) <= max(terrain.angle) <= math.radians(4.0)
    assert -0.03 <= min(terrain.rises) <= max(terrain.rises) <= 0.01
    assert 29.0 <= lengths.sum() <= 31.0
    assert Terrain.random(seed, step_probability=0.0).rises == (0.0,) * len(Terrain.random(seed).x)
    assert all(Terrain.random(seed, step_probability=1.0).rises[1:])


def test_roughness_is_added_to_the_same_ground() -> None:
    smooth, rough = (Terrain.random(seed=4, length=400.0, roughness=r, spacing=0.3) for r in (0.0, 0.003))
    at = np.array(rough.x)
    added = np.array(rough.z) - smooth.height(at + 1e-12)
    inner = added[at > 1.0 + 1e-9][:-1]
    assert abs(inner.mean()) < 3 * 0.003 / math.sqrt(inner.size)
    assert inner.std() == pytest.approx(0.003, rel=0.1)
    assert [r for r in rough.rises if r] == pytest.approx([r for r in smooth.rises if r], abs=1e-9)


@pytest.mark.parametrize(
    ("terrain", "places", "heights"),
    [
        (Terrain.random(seed=0), 219.6176763990466, -1.3616791928744845),
        (Terrain.random(seed=0, roughness=0.003, spacing=0.3), 1037.150329781249, -6.341679376842373),
        (Terrain.treads(seed=0, slope_deg=(-5.0, 3.0)), 79728.9996237435, 958.5376671608839),
        (Terrain.waves(seed=0), 1599761.0000001313, 0.08244126266445695),
    ],
)
def test_the_first_random_terrains_are_these(terrain: Terrain, places: float, heights: float) -> None:
    """Sums over all segments, in every version of this package: old walks can be made again."""
    assert (sum(terrain.x), sum(terrain.z)) == pytest.approx((places, heights), rel=1e-9)


def test_treads_have_the_named_depth_steps_and_slopes() -> None:
    deviation, count = 0.03, 2000
    terrain = Terrain.treads(seed=3, length=2.0 + 1.5 * count, tread=1.5, deviation=deviation, slope_deg=(-5.0, 3.0))
    slopes, rises = np.degrees(terrain.angle[1:]), np.array(terrain.rises[1:])
    assert np.diff(terrain.x)[1:] == pytest.approx(1.5 * np.cos(terrain.angle[1:-1]))
    assert rises.std() == pytest.approx(deviation, rel=4 / math.sqrt(2 * count))  # four standard errors
    assert (slopes.min(), slopes.max()) == pytest.approx((-5.0, 3.0), abs=8 * 10 / count)


def test_waves_have_the_named_deviation_and_no_other_lengths() -> None:
    deviation, spacing = 0.01, 0.05
    terrain = Terrain.waves(seed=5, length=2000.0, deviation=deviation, shortest=0.8, longest=4.0, spacing=spacing)
    heights = np.array(terrain.z[1:])[1000:]
    assert heights.std() == pytest.approx(deviation, rel=0.03)  # the mean over 490 of the longest waves
    power = np.abs(np.fft.rfft(heights * np.hanning(heights.size))) ** 2
    numbers = np.fft.rfftfreq(heights.size, spacing)
    inside = (numbers > 0.95 / 4.0) & (numbers < 1.05 / 0.8)
    assert power[inside].sum() / power.sum() > 0.999
    assert max(map(abs, terrain.rises)) == 0.0
    assert np.abs(np.array(terrain.z[:3])).max() < 0.02 * deviation  # it begins level and without a step


@pytest.fixture(scope="module")
def trail(tmp_path_factory: pytest.TempPathFactory) -> Terrain:
    """A record of 20 m that rises by 1 m, rough, with a step up of 3 cm."""
    x = np.linspace(-1.0, 19.0, 81)
    z = 0.05 * x + 0.02 * np.sin(2.0 * x) + 0.004 * np.cos(11.0 * x) + np.where(x > 8.0, 0.03, 0.0)
    rows = [f"{a:.6f},{b:.6f}" for a, b in zip(x, z, strict=True)]
    at = int(np.searchsorted(x, 8.0, side="right"))
    rows.insert(at, f"{x[at]:.6f},{z[at] - 0.03:.6f}")
    path = tmp_path_factory.mktemp("record") / "trail.csv"
    path.write_text("\n".join(rows))
    return Terrain.from_file(path)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**64 - 1), st.floats(2.5, 150.0))
def test_recorded_ground_is_the_record_to_and_fro_without_its_trend(trail: Terrain, seed: int, length: float) -> None:
    terrain, once = Terrain.recorded(trail, seed=seed, length=length), 20.0
    first = np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * once)
    x, z = trail.samples
    slope, offset = np.polyfit(x, z, 1)

    def expected(way: NDArray[np.float64]) -> NDArray[np.float64]:
        place = once - np.abs(once - way % (2.0 * once)) - 1.0  # a wave of triangles: there, and back
        return np.asarray(trail.height(place) - slope * place - offset)

    ahead = np.linspace(0.0, length - 2.0, 500)[1:-1]
    heights = terrain.height(2.0 + ahead)
    wanted = expected(first + ahead) - expected(np.array([first]))
    off = np.abs(heights - wanted) > 1e-9  # rounding, of angles of segments and of sums over a hundred metres
    assert off.sum() <= 2  # at a step, rounding may put a place on its other side
    assert (terrain.x[1], terrain.z[0], terrain.rises[1]) == (2.0, 0.0, 0.0)
    assert terrain.x[-1] <= length + 1e-9
    assert np.abs(np.array(terrain.rises)[np.array(terrain.rises) != 0.0]) == pytest.approx(0.03, abs=2e-6)


def test_a_path_and_what_was_read_from_it_give_one_ground(tmp_path: Path) -> None:
    path = tmp_path / "hill.csv"
    path.write_text("x,z\n0,0\n3,0.1\n7,-0.1\n")
    ground = Terrain.recorded(path, seed=2, length=20.0)
    assert ground == Terrain.recorded(Terrain.from_file(path), seed=2, length=20.0)
    assert ground == parse_terrain(f"recorded:file={path},seed=2,length=20")
    assert ground.caption == "recorded (file=hill.csv, seed=2, length=20.0)"


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**64 - 1), st.sampled_from(["random", "treads", "waves", "recorded"]))
@example(seed=208562045, name="random")  # 19 segments in 30 m
def test_a_seed_gives_one_ground_bit_by_bit(trail: Terrain, seed: int, name: str) -> None:
    more = {"file": trail} if name == "recorded" else {}
    terrain, again = (Terrain.preset(name, seed=seed, length=30.0, **more) for _ in range(2))
    assert terrain == again
    assert terrain.to_dict() == again.to_dict()
    assert terrain != Terrain.preset(name, seed=seed // 2 + 1, length=30.0, **more) or seed in (0, 1, 2)
    longer = Terrain.preset(name, seed=seed, length=60.0, **more)
    assert longer.z[: len(terrain.z)] == terrain.z  # a longer ground begins as this one
