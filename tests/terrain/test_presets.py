"""Terrains that have a name: their ground, their parameters, and what these may be."""

import json
import math
import pickle
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.errors import InputError
from mjbiped.terrain.presets import PRESETS
from mjbiped.terrain.profile import MOST_SEGMENTS
from mjbiped.terrain.terrain import Terrain


@pytest.mark.parametrize("name", [name for name in PRESETS if name != "recorded"])  # that one needs a file
def test_every_preset_goes_on_far_enough_and_into_the_record(name: str) -> None:
    terrain = Terrain.preset(name)
    assert terrain.name == name
    assert terrain.end == math.inf
    assert terrain.x[0] == 0.0
    assert len(terrain.x) == 1 or terrain.x[-1] > 23.0  # 60 steps of 0.38 m
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain
    assert pickle.loads(pickle.dumps(terrain)) == terrain
    assert Terrain.preset(name) == terrain
    assert terrain.caption.startswith(name)


def test_level_ground() -> None:
    assert Terrain.level().height(np.linspace(-5, 50, 7)).tolist() == [0.0] * 7


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
    constant = Terrain.slopes(change_deg=0, start_deg=3)
    assert set(constant.angle) == set(Terrain.incline(3.0).angle)


def test_the_papers_slopes_can_be_stood_on() -> None:
    assert math.degrees(Terrain.slopes(change_deg=-1).angle[-1]) == pytest.approx(-16.0)


def test_mixed_is_the_table_in_its_docstring() -> None:
    table = re.findall(r"\| +(\d+) +\| +(\S+) +\| +(\S+) +\| +(\S+) +\|", Terrain.mixed.__doc__ or "")
    rows = [(float(length), float(slope), 0.0 if step == "-" else float(step)) for _, length, slope, step in table]
    assert [int(k) for k, *_ in table] == list(range(1, 15))
    terrain = Terrain.mixed()
    given_in_full = Terrain.from_segments(rows)
    assert (terrain.x, terrain.z, terrain.angle) == (given_in_full.x, given_in_full.z, given_in_full.angle)
    assert f"{sum(length for length, *_ in rows):.1f} m long" in (Terrain.mixed.__doc__ or "")


def test_mixed_is_varied_but_can_be_walked() -> None:
    terrain = Terrain.mixed()
    slopes = np.rad2deg(terrain.angle)
    lengths = np.diff(terrain.x) / np.cos(terrain.angle[:-1])
    rises = np.array(terrain.rises)
    assert (slopes.min(), slopes.max()) == pytest.approx((-3.0, 3.0))
    assert np.abs(np.diff(slopes)).max() <= 2.0 + 1e-9
    assert lengths.min() >= 1.2 - 1e-9
    assert lengths.max() <= 3.0 + 1e-9
    assert terrain.x[-1] > 23.0
    assert rises.min() == pytest.approx(-0.03)
    assert rises.max() == pytest.approx(0.008)
    sizes = [len(stretch) for stretch in terrain.stretches()]
    assert sum(size > 1 for size in sizes) >= 1
    assert sum(size == 1 for size in sizes) >= 3
    # The promise of the docstring: a step up never meets ground that turns uphill by more than a degree.
    turns = np.diff(slopes, prepend=slopes[0])
    assert (turns[rises > 0.0] >= -1.0 - 1e-9).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([0.0, 0.002]))
def test_the_same_seed_gives_the_same_ground_bit_by_bit(seed: int, roughness: float) -> None:
    terrain, again = (Terrain.random(seed=seed, roughness=roughness) for _ in range(2))
    assert terrain == again
    assert np.asarray(terrain.z).tobytes() == np.asarray(again.z).tobytes()
    assert terrain != Terrain.random(seed=seed + 1, roughness=roughness)


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
    assert np.abs(added[at <= 1.0 + 1e-9]).max() < 1e-9
    inner = added[(at > 1.0 + 1e-9)][:-1]
    assert abs(inner.mean()) < 3 * 0.003 / math.sqrt(inner.size)
    assert inner.std() == pytest.approx(0.003, rel=0.1)
    cells = np.diff(at[1:])
    assert cells.min() > 0.3 / 1.5 * 0.99
    assert cells.max() < 0.3 * 1.5
    rises = [r for r in rough.rises if r]
    assert rises == pytest.approx([r for r in smooth.rises if r], abs=1e-9)
    assert added[-1] == pytest.approx(0.0, abs=1e-9)  # the last segment goes on as it is
    assert rough.angle[-1] == smooth.angle[-1]


def test_the_first_random_terrain_is_this_one() -> None:
    terrain = Terrain.random(seed=0)
    assert terrain.x[1:5] == pytest.approx((1.0, 2.563899453479, 4.338165032399, 5.789007906733), abs=1e-11)
    assert terrain.rises[1:5] == pytest.approx((-0.018975661902, 0.0, 0.000396338853, -0.001758613839), abs=1e-11)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("incline", {"slope_deg": 40}, "terrain incline: slope_deg: a slope of 40 degrees"),
        ("incline", {"slope_deg": "steep"}, "slope_deg"),
        ("stairs", {"tread": 0.0}, "tread = 0.0: must be from 1e-06 to 100000 m"),
        ("stairs", {"tread": -1}, "tread"),
        ("stairs", {"rise": 0.6}, "rise"),
        ("stairs", {"rise": None}, "rise"),
        ("stairs", {"first": 0.0}, "first"),
        ("stairs", {"first": -1.0}, "first"),
        ("stairs", {"count": 0}, "count = 0: must be a whole number from 1 to 99999"),
        ("stairs", {"count": 2.5}, "count"),
        ("stairs", {"count": True}, "count"),
        ("stairs", {"count": MOST_SEGMENTS}, "count"),
        ("stairs", {"tread": 9e4}, "segment 3: x"),
        ("slopes", {"length": 0}, "length"),
        ("slopes", {"change_deg": math.inf}, "change_deg"),
        ("slopes", {"count": 0}, "count"),
        ("slopes", {"start_deg": 40}, "start_deg: a slope"),
        ("slopes", {"change_deg": 3.0}, "start_deg . 16 x change_deg: a slope of 48 degrees"),
        ("mixed", {"seed": 1}, "unknown parameter of the terrain mixed 'seed'"),
        ("random", {"seed": -1}, "seed"),
        ("random", {"seed": 1.5}, "seed"),
        ("random", {"seed": None}, "seed"),
        ("random", {"length": 0.99}, "length = 0.99: must be from 1 to 100000 m"),
        ("random", {"length": 1e5, "segment_length": (1e-4, 2.0)}, "can be more than"),
        ("random", {"segment_length": (0.8, 1e5), "spacing": 0.25, "roughness": 0.001}, "can be more than"),
        ("random", {"segment_length": (0.0, 1.0)}, "segment_length, low end = 0.0: "),
        ("random", {"segment_length": (2.0, 1.0)}, "swap them"),
        ("random", {"segment_length": 1.0}, "range"),
        ("random", {"segment_length": "12"}, "range"),
        ("random", {"slope_deg": (-3.0, 3.0, 5.0)}, "range"),
        ("random", {"slope_deg": (-3.0, 40.0)}, "slope_deg: a slope of 40"),
        ("random", {"slope_deg": (-3.0, "b")}, "slope_deg, high end = 'b': "),
        ("random", {"rise": (-0.6, 0.0)}, "rise, low end = -0.6: "),
        ("random", {"step_probability": 1.1}, "step_probability = 1.1: must be from 0 to 1"),
        ("random", {"step_probability": -0.1}, "step_probability"),
        ("random", {"roughness": -0.1}, "roughness"),
        ("random", {"spacing": 0.0}, "spacing"),
        ("random", {"roughness": 0.4}, "steeper than the robot can stand on"),
    ],
)
def test_parameters_outside_their_domain_are_refused(name: str, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.preset(name, **parameters)


@pytest.mark.parametrize("name", ["stair", "Level", "", None, 3])
def test_unknown_presets_are_refused_with_the_valid_names(name: Any) -> None:
    with pytest.raises(InputError, match="valid are level, incline, slopes, stairs, mixed, random"):
        Terrain.preset(name)
